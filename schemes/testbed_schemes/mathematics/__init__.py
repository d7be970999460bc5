"""Mathematics that several schemes or boundary curves share, each module named after its subject.

planar_frame          end tangents, plane and curvatures of an edge
crossed_parabolas     all positive solutions of the geometric Hermite equations
geometric_hermite     which of them to take
edge_conics           the conic of an edge
quintic_hermite       quintic curves as deviations from their chords
split_domain          three patches a face, joined inside
quadratic_precision   a centre of cubic triangles
three_quadrics        all real roots of three quadrics
bicubic_nets          boundary and twist points of bicubic patches
bicubic_centre        inner points of bicubic patches from samples at their centres
blended_quartics      quartics whose inner points are blended rationally
edge_deviations       blends of edges and cross-boundary fields as vectors and functions
side_vertex           blends of curves from vertices to opposite sides
triangle_subdivision  places of the pieces of one-to-four refinement
butterfly_stencil     new vertices on edges by the butterfly's rule
box_spline            a quartic box spline's Bezier triangles
loop_corners          Loop's surface at irregular vertices, exactly
a_patch_refinement    A-patches: where tetrahedra of neighbours cross, and splits of edges that part them
tetrahedron_crossings  which of many tetrahedra cross
"""
