"""The largest angle along every edge of a surface: exact of polynomial patches, searched for on others."""

from collections.abc import Callable

import numpy as np
import pytest
from built_surfaces import OCTAHEDRON, OCTANTS, bumpy_octahedron, exact_cap, graph, octahedron

from testbed.conformance.meshes import perturbed_icosahedron
from testbed.geometry.bernstein import elevate_tensor, elevate_triangle
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.normal_fields import along_sides
from testbed.geometry.polynomials import basis, combine
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float, angle_between, unit
from testbed.measures.continuity import edge_jumps, interior_edges
from testbed.measures.edge_angles import EdgeAngles, edge_angles
from testbed.registry import scheme

T = np.arange(401) / 400.0


def triangles(surface: Surface) -> BezierTriangles:
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    return batch


def rational(seed: int = 0) -> Surface:
    """The bumpy octahedron with weights."""
    points = triangles(bumpy_octahedron(seed)).control_points
    weights = np.random.default_rng(seed).uniform(0.4, 2.5, size=points.shape[:2])
    return Surface.over_faces(HermiteMesh(OCTAHEDRON, OCTANTS), RationalBezierTriangles(points, weights))


def quads(degrees: tuple[int, int] = (3, 2), seed: int = 0) -> Surface:
    """Tensor-product patches over a cube, turned in all ways, with kinks and gaps."""
    corners = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    faces = np.array([[0, 2, 3, 1], [5, 7, 6, 4], [0, 1, 5, 4], [3, 2, 6, 7], [4, 6, 2, 0], [3, 7, 5, 1]])
    u, v = (np.arange(d + 1) / d for d in degrees)
    weights = np.stack([np.outer(1 - u, 1 - v), np.outer(u, 1 - v), np.outer(u, v), np.outer(1 - u, v)])
    net = np.einsum("cmn,fcd->fmnd", weights, corners[faces])
    net = net + 0.1 * np.random.default_rng(seed).normal(size=net.shape)
    return Surface.over_faces(HermiteMesh(corners, faces), BezierQuads(net))


def sampled(surface: Surface) -> Float:
    """Largest sampled angles (E,)."""
    return np.asarray(edge_jumps(surface, interior_edges(surface), T)[0].max(axis=1))


def angle_at(surface: Surface, found: EdgeAngles) -> Float:
    """Angles (E,) at the places found, from jets."""
    return np.asarray(edge_jumps(surface, found.edges, found.t[:, None])[0][:, 0])


SURFACES: dict[str, Callable[[], Surface]] = {
    "quartic triangles": bumpy_octahedron,
    "flat triangles": octahedron,
    "rational triangles": rational,
    "patches of a sphere": exact_cap,
    "tensor-product patches": quads,
    "quartics of a scheme": lambda: scheme("shirman-sequin").fit(perturbed_icosahedron()),
    "cubics of a scheme": lambda: scheme("cubic-interpolant").fit(perturbed_icosahedron()),
}
every_surface = pytest.mark.parametrize("name", SURFACES)


@every_surface
def test_angles_are_attained_and_not_below_samples(name: str) -> None:
    surface = SURFACES[name]()
    found = edge_angles(surface)
    assert len(found) == interior_edges(surface).interior.sum()
    assert found.certified
    # jets are rounded relative to the size of the coordinates
    assert (found.angle >= sampled(surface) - 1e-12).all()
    assert (found.high >= sampled(surface) - 1e-12).all()
    np.testing.assert_allclose(angle_at(surface, found), found.angle, atol=1e-12)
    assert (found.low <= found.angle).all()
    assert (found.angle <= found.high).all()
    # polynomials of thrice the degree lose more digits
    gap = 1e-7 if name == "rational triangles" else 2e-9
    assert (found.high - found.low <= gap * found.angle + 1e-10).all()


@pytest.mark.parametrize("name", ["quartic triangles", "rational triangles", "tensor-product patches"])
def test_normals_along_sides_are_those_of_jets(name: str) -> None:
    batch = SURFACES[name]().batches[0]
    for side in range(batch.sides):
        patches = np.arange(len(batch))
        fields = along_sides(batch, patches, np.full(len(batch), side))
        start, end = CORNERS[batch.sides][[side, (side + 1) % batch.sides]]
        for t in (0.0, 0.3, 1.0):
            normals = combine(basis(len(fields.normals) - 1, np.full(1, t)), fields.normals).T
            expected = batch.jets(((1 - t) * start + t * end)[None], 1).normal[:, 0]
            assert angle_between(unit(normals), expected).max() < 1e-14


@every_surface
def test_the_order_of_patches_does_not_matter(name: str) -> None:
    whole = SURFACES[name]()
    part = whole.parts[0]
    order = np.random.default_rng(1).permutation(len(part.batch))
    shuffled = Part(part.batch.take(order), part.corner_ids[order], part.faces[order], part.corners_in_face[order])
    one, other = edge_angles(whole), edge_angles(Surface(whole.mesh, (shuffled,)))
    for field in ("angle", "t", "low", "high"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))


def test_patches_may_stand_in_several_parts_of_different_degrees() -> None:
    whole = bumpy_octahedron()
    net = triangles(whole).control_points
    corners = np.broadcast_to(CORNERS[3], (4, 3, 2))
    parts = tuple(
        Part(BezierTriangles(elevate_triangle(net[some], steps)), whole.mesh.faces[some], np.array(some), corners)
        for some, steps in (([7, 1, 4, 2], 0), ([0, 3, 5, 6], 2))
    )
    one, other = edge_angles(whole), edge_angles(Surface(whole.mesh, parts))
    np.testing.assert_allclose(other.angle, one.angle, atol=1e-13)
    np.testing.assert_allclose(other.t, one.t, atol=1e-5)
    assert other.certified


def test_degree_elevation_changes_nothing() -> None:
    surface = quads()
    batch = surface.batches[0]
    assert isinstance(batch, BezierQuads)
    raised = Surface.over_faces(surface.mesh, BezierQuads(elevate_tensor(batch.control_points, (1, 2))))
    np.testing.assert_allclose(edge_angles(raised).angle, edge_angles(surface).angle, atol=1e-13)


def test_equal_weights_are_as_good_as_none() -> None:
    surface = bumpy_octahedron()
    points = triangles(surface).control_points
    weighted = Surface.over_faces(surface.mesh, RationalBezierTriangles(points, np.full(points.shape[:2], 3.0)))
    np.testing.assert_allclose(edge_angles(weighted).angle, edge_angles(surface).angle, atol=1e-13)


def test_far_from_the_origin_angles_are_the_same() -> None:
    surface = rational()
    batch = surface.batches[0]
    assert isinstance(batch, RationalBezierTriangles)
    shift = np.array([1024.0, -2048.0, 512.0])
    points = batch.control_points + shift
    near = Surface.over_faces(surface.mesh, RationalBezierTriangles(points - shift, batch.weights))
    far = Surface.over_faces(HermiteMesh(OCTAHEDRON + shift, OCTANTS), RationalBezierTriangles(points, batch.weights))
    np.testing.assert_allclose(edge_angles(far).angle, edge_angles(near).angle, atol=1e-13)


def test_a_peak_between_samples_is_found() -> None:
    """Flat for y >= 0; for y < 0 the slope across the edge is x^2 (1 - x): largest at x = 2/3, where it is 4/27."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 1.0], [0.7, -1.0]])
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    found = edge_angles(graph(lambda x, y: np.where(y < 0.0, y * x**2 * (1.0 - x), 0.0), 4, corners, faces))
    assert found.angle == pytest.approx(np.arctan(4.0 / 27.0), rel=1e-14)
    assert found.t == pytest.approx(2.0 / 3.0, rel=1e-9)
    assert found.low[0] <= np.arctan(4.0 / 27.0) <= found.high[0]


def test_blended_patches_are_searched_without_a_guarantee() -> None:
    surface = scheme("nielson").fit(perturbed_icosahedron())
    found = edge_angles(surface)
    assert not found.exact.any()
    assert not found.certified
    assert np.isinf(found.high).all()
    np.testing.assert_array_equal(found.low, found.angle)
    t = np.linspace(0.01, 0.99, 99)
    assert (found.angle >= edge_jumps(surface, found.edges, t)[0].max(axis=1) - 1e-13).all()


def test_weights_that_are_not_positive_give_no_guarantee() -> None:
    surface = rational()
    batch = surface.batches[0]
    assert isinstance(batch, RationalBezierTriangles)
    weights = batch.weights.copy()
    weights[0, 4] = -0.01
    found = edge_angles(Surface.over_faces(surface.mesh, RationalBezierTriangles(batch.control_points, weights)))
    assert not found.exact.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_control_point_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    surface = bumpy_octahedron()
    points = triangles(surface).control_points.copy()
    points[3, 4] = bad
    found = edge_angles(Surface.over_faces(surface.mesh, BezierTriangles(points)))
    beside = (found.edges.left.face == 3) | (found.edges.right.face == 3)
    of_the_point = np.isnan(found.angle)
    assert of_the_point.any()
    assert not (of_the_point & ~beside).any()
    np.testing.assert_array_equal(np.isnan(found.high), of_the_point)
    np.testing.assert_array_equal(found.angle[~beside], edge_angles(surface).angle[~beside])


def test_a_collapsed_corner_has_no_angle() -> None:
    surface = bumpy_octahedron()
    points = triangles(surface).control_points.copy()
    points[0, 1] = points[0, 0]
    found = edge_angles(Surface.over_faces(surface.mesh, BezierTriangles(points)))
    assert np.isnan(found.angle).sum() == 2


def test_points_have_no_normals() -> None:
    net = np.zeros((8, 1, 3))
    found = edge_angles(Surface.over_faces(HermiteMesh(OCTAHEDRON, OCTANTS), BezierTriangles(net)))
    assert np.isnan(found.angle).all()


def test_chosen_edges_have_the_same_angles() -> None:
    surface = bumpy_octahedron()
    edges = interior_edges(surface)
    chosen = np.array([7, 2, 2, 11])
    np.testing.assert_array_equal(edge_angles(surface, edges[chosen]).angle, edge_angles(surface).angle[chosen])


def test_a_surface_without_edges_between_patches_has_none() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64)
    mesh = HermiteMesh(points, np.array([[0, 1, 2]]))
    found = edge_angles(Surface.over_faces(mesh, BezierTriangles(points[None])))
    assert len(found) == 0
    assert found.certified
