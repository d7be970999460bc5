"""When two patches join with a common tangent plane, or with a common curvature: the conditions, one module each.

Schemes solve these conditions for their control points; the modules here know edges and rows of control points only.
All number an edge's cubic boundary H_0 to H_3 and write F_r and G_r for the second rows on its two sides.

farin             G1 of two Bezier triangles of any degree whose inner boundary is shared, as a residual
chiyokura_kimura  a cubic boundary: both rows from one field of tangent planes, neither reads the other; Jensen's C
piper             quartic patches: both rows and the boundary's middle point at once, nearest to a candidate
peters            cubic patches: a quadratic boundary (one row alone), a cubic one (both rows, where solvable)
hagen_pottmann    G2: a tangent plane field and a curvature field along a curve
"""
