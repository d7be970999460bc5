"""The surfaces of A-patches: joins, reproduction, the paper's examples and counts, single cubics, refusals."""

import dataclasses
from functools import partial

import numpy as np
import pytest
from trivariate_functions import noisy_torus

from testbed.conformance.meshes import icosahedron, octahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.curvature import gauss, mean
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.shooting_quads import ShootingQuads
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, cross, norm, unit
from testbed.plugins.scheme import Shape
from testbed.registry import scheme
from testbed_datasets.joined_faces import Case, JoinedFaces
from testbed_schemes.a_patch import APatch
from testbed_schemes.mathematics.a_patch_assembly import check_backward_rays
from testbed_schemes.mathematics.a_patch_sides import hull, nets_of_edges, nets_of_faces

CASES: tuple[Case, ...] = ("convex", "mixed", "nonconvex", "flat")
EAST, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
EDGE = np.concatenate([[1e-3, 1e-2], np.arange(1, 16) / 16, [1.0 - 1e-2, 1.0 - 1e-3]])


def joins(surface: Surface) -> tuple[float, float]:
    """Worst gap and worst angle of normals over all edges between patches."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], EDGE, 1)
    return float(norm(left.f - right.f).max()), float(angle_between(left.normal, right.normal).max())


def all_points(surface: Surface, steps: int = 10) -> Float:
    return np.concatenate([batch.jets(lattice(batch.sides, steps), 0).f.reshape(-1, 3) for batch in surface.batches])


def with_gradients(mesh: HermiteMesh, gradients: Float) -> HermiteMesh:
    return HermiteMesh(mesh.points, mesh.faces, gradients=gradients)


def cylinder(around: int = 10) -> HermiteMesh:
    """A band of a cylinder whose straight lines are edges."""
    turn = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    k, after = np.arange(around), (np.arange(around) + 1) % around
    faces = np.concatenate([np.stack([k, after, after + around], 1), np.stack([k, after + around, k + around], 1)])
    return HermiteMesh(np.concatenate([ring, ring + 0.7 * UP]), faces, gradients=np.concatenate([ring, ring]))


def crossing_tetrahedra() -> HermiteMesh:
    """A torus so coarse inside that tetrahedra of neighbours cross there."""
    return torus(6, 4, 3)


def ridge(width: float, turn_deg: float) -> HermiteMesh:
    """Two faces at an edge about which the outer side takes so much, the second face ``width`` times as wide."""
    turn = np.radians(turn_deg)

    def at(angle: float) -> Float:
        return np.array([0.0, np.cos(angle), np.sin(angle)])

    points = np.array([[-1.0, 0, 0], [1.0, 0, 0], at(0.0) + 0.1 * EAST, width * at(turn)])
    vectors = [at(turn / 2) - 0.5 * EAST, at(turn / 2) + 0.5 * EAST, at(np.pi / 2), at(turn - np.pi / 2)]
    return HermiteMesh(points, [[0, 1, 2], [1, 0, 3]], gradients=np.array(vectors))


# ---- joins


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("free", ["default", "quadric", 2.0])
def test_the_papers_examples_are_g1_on_all_edges_and_interpolate(case: Case, free: float) -> None:
    mesh = JoinedFaces(case).mesh(0)
    surface = APatch(free=free).fit(mesh)
    gap, angle = joins(surface)
    assert gap <= 1e-14
    assert angle <= 1e-12
    assert mesh.normals is not None
    for part in surface.parts:
        corners = np.array(
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
            if part.batch.sides == 3
            else [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        )
        jet = part.batch.jets(corners, 1)
        patch, corner = np.nonzero(part.corner_ids < 4)
        vertex = part.corner_ids[patch, corner]
        assert jet.f[patch, corner] == pytest.approx(mesh.points[vertex], abs=1e-14)
        assert jet.normal[patch, corner] == pytest.approx(mesh.normals[vertex], abs=1e-12)


@pytest.mark.parametrize(
    ("case", "triangles", "quads", "flat", "interior"),
    [
        # two faces, an edge
        ("convex", 2, 1, 0, 2),
        # a face, a fan of three, an edge
        ("mixed", 4, 1, 0, 5),
        # two fans with the third at the common edge cut in two, an edge in two parts
        ("nonconvex", 8, 2, 0, 12),
        # a fan that meets the flat face in the edge itself
        ("flat", 3, 0, 1, 4),
    ],
)
def test_how_many_patches_there_are_and_that_all_join(
    case: Case, triangles: int, quads: int, flat: int, interior: int
) -> None:
    surface = APatch().fit(JoinedFaces(case).mesh(0))
    counts = dict.fromkeys(("triangles", "quads", "flat"), 0)
    for batch in surface.batches:
        kinds = ("triangles", ShootingTriangles), ("quads", ShootingQuads)
        counts[next((name for name, kind in kinds if isinstance(batch, kind)), "flat")] += len(batch)
    assert counts == {"triangles": triangles, "quads": quads, "flat": flat}
    assert surface.edges.interior.sum() == interior


@pytest.mark.parametrize(
    "built", [APatch(), APatch(free="quadric"), APatch(normals="loop"), APatch(split="single")], ids=str
)
def test_a_noisy_torus_is_g1_on_all_edges(built: APatch) -> None:
    mesh = noisy_torus()
    surface = built.fit(mesh)
    assert len(surface.edges) == surface.edges.interior.sum()
    gap, angle = joins(surface)
    assert gap <= 1e-13
    assert angle <= 1e-9
    assert np.isfinite(all_points(surface)).all()


def test_the_surface_turned_over_is_the_same() -> None:
    mesh = noisy_torus()
    one, other = APatch().fit(mesh), APatch().fit(mesh.flipped())
    rng = np.random.default_rng(3)
    face, bary = rng.integers(0, len(mesh.faces), 400), rng.dirichlet(np.ones(3), 400)
    first, second = one.evaluate(face, bary, 1), other.evaluate(face, bary[:, ::-1], 1)
    assert norm(first.f - second.f).max() <= 1e-14
    assert angle_between(first.normal, -second.normal).max() <= 1e-10


def test_boundaries_have_no_edge_patches() -> None:
    whole = icosahedron()
    mesh = whole.submesh((whole.faces == 3).any(axis=1) | (whole.faces == whole.faces[0, 0]).any(axis=1))
    surface = APatch().fit(mesh)
    inner = int((~mesh.boundary_edges).sum())
    quads = [len(batch) for batch in surface.batches if isinstance(batch, ShootingQuads)]
    assert quads == [inner]
    assert (~surface.edges.interior).sum() == mesh.boundary_edges.sum()
    alone = APatch().fit(icosahedron().submesh(np.arange(1)))
    assert alone.patch_count == 1


def test_edges_along_straight_lines_of_a_cylinder_stay_and_are_joined_smoothly() -> None:
    mesh = cylinder()
    surface = APatch(free="quadric").fit(mesh)
    assert surface.branches["flat edges"] == 10
    assert surface.branches["flat faces"] == 0
    quads = sum(len(batch) for batch in surface.batches if isinstance(batch, ShootingQuads))
    assert quads == 10  # the diagonals; boundary edges have none, straight lines neither
    gap, angle = joins(surface)
    assert gap <= 1e-15
    assert angle <= 1e-13
    assert np.abs(norm(all_points(surface)[:, :2]) - 1.0).max() <= 1e-13


# ---- shape


def test_the_curvatures_on_both_sides_of_figure_6s_junction() -> None:
    """Above q = 0.4 p_1 + 0.6 p_2; curvature jumps there, as it may."""
    surface = APatch().fit(JoinedFaces("convex").mesh(0))
    face, edge = (
        next(b for b in surface.batches if isinstance(b, kind)) for kind in (ShootingTriangles, ShootingQuads)
    )
    on_face, on_edge = face.jets(np.array([[0.6, 0.0]])), edge.jets(np.array([[0.6, 1.0]]))
    assert on_face.f[0, 0] == pytest.approx(on_edge.f[0, 0], abs=1e-14)
    assert (mean(on_face)[0, 0], gauss(on_face)[0, 0]) == pytest.approx((0.37446399, 0.12482777), abs=5e-9)
    assert (mean(on_edge)[0, 0], gauss(on_edge)[0, 0]) == pytest.approx((0.36463588, 0.11503921), abs=5e-9)


def test_the_family_of_figure_2_sinks_from_the_apex_to_the_face() -> None:
    mesh = JoinedFaces("convex").mesh(0)
    middle = (np.zeros(1, dtype=int), np.full((1, 3), 1.0 / 3.0))
    heights = []
    for free in (-1e9, -0.5, 0.0, 3.3, 30.0, 3000.0):
        surface = APatch(free=free).fit(mesh)
        heights.append(float(norm(surface.evaluate(*middle, 0).f[0] - mesh.points[mesh.faces[0]].mean(axis=0))))
        assert surface.branches["free coefficients raised to their bounds"] == (2 if free < -1.0 else 0)
    assert heights == sorted(heights, reverse=True)
    assert heights[-1] < 0.1 * heights[0]


def test_rays_of_other_tetrahedra_miss_the_surface() -> None:
    """What section 5 prints: F of the negative tetrahedron for rays to u; weights of u_y that do not sum to one."""
    surface = APatch().fit(JoinedFaces("nonconvex").mesh(0))
    faces, edges = (
        next(b for b in surface.batches if isinstance(b, kind)) for kind in (ShootingTriangles, ShootingQuads)
    )
    at = np.array([[0.3, 0.2]])
    points = faces.jets(at, 0).f[:, 0]
    swapped = dataclasses.replace(faces, nets=faces.nets[:, ::-1], rational=faces.rational[:, ::-1])
    assert not (norm(swapped.jets(at, 0).f[:, 0] - points) < 1e-3).any()  # or there is no root
    n, m = 4, 2
    printed = edges.apexes.copy()
    printed[:, :, 1] *= m / n  # u_y at y = 0, on the side of the face ijk
    junction = np.array([[0.5, 1.0]])
    off = dataclasses.replace(edges, apexes=printed).jets(junction, 0).f - edges.jets(junction, 0).f
    assert norm(off).min() > 1e-2


def test_the_numbers_of_patches_are_as_eight_to_five_on_closed_convex_meshes() -> None:
    """One patch a face and one an edge; with two an edge, as in the authors' scheme before, the ratio is 8 : 5."""
    for mesh in (octahedron(), icosahedron()):
        surface = APatch().fit(mesh)
        faces, edges = len(mesh.faces), len(mesh.edges)
        assert surface.patch_count == faces + edges
        assert surface.branches["tetrahedra of faces"] == faces
        assert surface.branches["tetrahedra of edges"] == edges
        assert (faces + 2 * edges) / (faces + edges) == pytest.approx(8.0 / 5.0)


# ---- data


def test_claims_follow_the_parameters() -> None:
    assert APatch().reproduces == (Shape.PLANES,)
    assert APatch(free="quadric").reproduces == (Shape.PLANES, Shape.SPHERES, Shape.QUADRICS)
    assert APatch(free="quadric", lengths="unit").reproduces == (Shape.PLANES, Shape.SPHERES)
    assert APatch(free="quadric", normals="loop").reproduces == (Shape.PLANES,)
    assert scheme("a-patch[free=quadric]") == APatch(free="quadric")
    assert scheme("a-patch[free=2.5,split=single]") == APatch(free=2.5, split="single")


def test_without_normals_loops_are_taken() -> None:
    mesh = torus(16, 10, 3)
    bare = HermiteMesh(mesh.points, mesh.faces)
    assert np.array_equal(all_points(APatch().fit(bare), 3), all_points(APatch(normals="loop").fit(mesh), 3))


def test_where_tetrahedra_cross_the_mesh_is_refined_and_the_surface_is_still_over_the_given_one() -> None:
    mesh = crossing_tetrahedra()
    with pytest.raises(Refused, match="cross"):
        APatch(modifications=0).fit(mesh)
    surface = APatch().fit(mesh)
    assert surface.branches["hull modifications"] > 0
    assert surface.notes == {"edges split where tetrahedra cross": surface.branches["hull modifications"]}
    assert surface.mesh is mesh
    gap, angle = joins(surface)
    assert gap <= 1e-13
    assert angle <= 1e-9
    corners = surface.evaluate(np.repeat(np.arange(len(mesh.faces)), 3), np.tile(np.eye(3), (len(mesh.faces), 1)), 1)
    assert corners.f == pytest.approx(mesh.corner_points().reshape(-1, 3), abs=1e-13)
    assert mesh.normals is not None
    assert corners.normal == pytest.approx(mesh.normals[mesh.faces].reshape(-1, 3), abs=1e-9)


# ---- refusals


def test_a_normal_below_a_face_is_refused_with_face_and_vertex() -> None:
    mesh = icosahedron()
    vectors = mesh.points.copy()
    vertex = int(mesh.faces[4, 1])
    corners = mesh.points[mesh.faces[4]]
    normal = unit(cross(corners[1] - corners[0], corners[2] - corners[0]))
    vectors[vertex] -= (vectors[vertex] @ normal + 0.01) * normal
    with pytest.raises(Refused, match=rf"that of vertex {vertex} does not on face \d+ "):
        APatch().fit(with_gradients(mesh, vectors))


def test_an_edge_that_no_coefficients_help_is_refused_by_name() -> None:
    mesh = ridge(8.0, 290.0)
    found = hull(mesh, 0.05, 1e-12)
    nets = nets_of_faces(found, 0, np.zeros(2, dtype=bool))
    edges = nets_of_edges(found, 0, nets, nets.default)
    assert edges.nu[0, 0] + edges.mu[0, 3] < -2.0
    with pytest.raises(Refused, match=r"the edge between vertices 0 and 1 is so wide, nu_1 \+ mu_4 = -2\.24"):
        APatch().fit(mesh)
    gap, angle = joins(APatch().fit(ridge(5.0, 290.0)))
    assert max(gap, angle) <= 1e-12


def test_a_convex_face_whose_rays_meet_nothing_is_refused_by_name() -> None:
    """F = 1 everywhere: positive on the face, and no zero behind it."""
    part = APatch().fit(icosahedron()).parts[0]
    assert isinstance(part.batch, ShootingTriangles)
    check_backward_rays(part)
    nets = part.batch.nets.copy()
    nets[7, 0] = 1.0
    broken = dataclasses.replace(part, batch=dataclasses.replace(part.batch, nets=nets))
    with pytest.raises(Refused, match="rays through face 7,"):
        check_backward_rays(broken)


def test_loop_normals_that_do_not_exist_are_refused() -> None:
    with pytest.raises(Refused, match="a-patch needs normals"):
        APatch(normals="loop").fit(_without_loop_normal())


def _without_loop_normal() -> HermiteMesh:
    """A vertex whose neighbours are so placed that both tangents of Loop's limit surface are parallel."""
    turn = 2.0 * np.pi * np.arange(4) / 4
    ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    ring[2:] = ring[:2] + UP
    points = np.concatenate([[[0.0, 0.0, 5.0]], ring])
    ring_ids = np.arange(1, 5)
    return HermiteMesh(points, np.stack([np.zeros(4, dtype=int), ring_ids, np.roll(ring_ids, -1)], axis=1))


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("epsilon", 0.0, "epsilon must be positive"),
        ("epsilon", float("nan"), "epsilon must be finite"),
        ("tolerance", -1e-9, "tolerance must not be negative"),
        ("modifications", -1, "modifications must not be negative"),
        ("free", float("inf"), "free must be finite"),
    ],
)
def test_numbers_that_make_no_sense_are_no_parameters(field: str, value: float, words: str) -> None:
    with pytest.raises(SpecError, match=words):
        partial(dataclasses.replace, APatch())(**{field: value})
