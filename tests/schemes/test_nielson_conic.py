"""Side-vertex patches of generalised conics: circles where the data are a circle's, G1, and no singularity."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron
from testbed.errors import Refused
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import CORNERS, corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, tangential, unit
from testbed_datasets.sphere import Sphere
from testbed_schemes.nielson_conic import NielsonConic, side_curve, side_data

ZOO = {case.name: case.mesh for case in cases(3)}
every_mesh = pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])
#: Samples away from the corners.
INTERIOR = lattice(3, 60)[corner_distance(3, lattice(3, 60)) > 0.0]


def conic(p: Float, n: Float, q: Float, m: Float, t: float) -> tuple[Float, Float, Float, Float]:
    """Point and derivative of the rational cubic from p to q, from its points and weights, and its end tangents."""
    chord, length = q - p, np.linalg.norm(q - p)
    first, last = ((chord - (chord @ x) * x) for x in (n, m))
    first, last = first / np.linalg.norm(first), last / np.linalg.norm(last)
    w0, w1 = 1 + 2 * (first @ chord) / length, 1 + 2 * (last @ chord) / length
    weights = np.array([1.0, w0 / 3, w1 / 3, 1.0])
    points = np.stack([p, p + length * first / w0, q - length * last / w1, q])
    bernstein = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    slopes = 3 * np.array([-((1 - t) ** 2), (1 - t) ** 2 - 2 * t * (1 - t), 2 * t * (1 - t) - t**2, t**2])
    w, dw = bernstein @ weights, slopes @ weights
    point = (bernstein * weights) @ points / w
    return point, ((slopes * weights) @ points - dw * point) / w, length * first, length * last


def test_a_point_by_hand() -> None:
    mesh, b = perturbed_icosahedron(), np.array([0.2, 0.5, 0.3])
    points, normals = mesh.corner_points()[7], mesh.corner_normals()[7]
    expected = np.zeros(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        s = b[k] / (b[j] + b[k])
        foot, slope, first, last = conic(points[j], normals[j], points[k], normals[k], s)
        normal = np.cross(slope, (1 - s) * np.cross(normals[j], first) + s * np.cross(normals[k], last))
        piece = conic(points[i], normals[i], foot, normal / np.linalg.norm(normal), 1 - b[i])[0]
        expected += piece * b[j] * b[k] / (b[0] * b[1] + b[1] * b[2] + b[2] * b[0])
    result = NielsonConic().fit(mesh).evaluate(np.array([7]), b[None], order=0).f[0]
    np.testing.assert_allclose(result, expected, atol=1e-14)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_the_side_has_the_point_and_the_normal_of_the_rational_cubic(seed: int) -> None:
    rng = np.random.default_rng(seed)
    p, q, n, m = rng.normal(size=(4, 3))
    n, m, s = unit(n), unit(m), rng.uniform()
    point, slope, first, last = conic(p, n, q, m, s)
    off_chord, normal = side_curve(**side_data(q - p, first, last, n, m), s=np.array(s), rest=np.array(1.0 - s))
    np.testing.assert_allclose(p + s * (q - p) + off_chord, point, atol=1e-13 * float(1.0 + norm(slope)))
    expected = cross(slope, (1 - s) * cross(n, first) + s * cross(m, last))
    # parallel: their vector product vanishes, and they point to one side
    assert norm(cross(normal, expected)) <= 1e-12 * norm(normal) * norm(expected)
    assert dot(normal, expected) >= 0.0


@every_mesh
def test_points_and_normals_are_interpolated(mesh: HermiteMesh) -> None:
    jet = NielsonConic().fit(mesh).batches[0].jets(CORNERS[3], 1)
    np.testing.assert_array_equal(jet.f, mesh.corner_points())
    assert np.degrees(angle_between(jet.normal, mesh.corner_normals())).max() < 1e-10


@every_mesh
def test_tangent_planes_agree_across_every_edge(mesh: HermiteMesh) -> None:
    surface = NielsonConic().fit(mesh)
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, 1)
    assert np.max(norm(left.f - right.f), initial=0.0) < 1e-14
    assert np.max(np.degrees(angle_between(left.normal, right.normal)), initial=0.0) < 1e-9


@pytest.mark.parametrize("mesh", [octahedron(), ZOO["tetrahedron"], Sphere().mesh(1)])
def test_edges_of_a_sphere_are_great_circles_with_its_normals(mesh: HermiteMesh) -> None:
    surface = NielsonConic().fit(mesh)
    side = surface.side_jets(surface.edges.left, T, 1)
    ends = mesh.points[surface.edges.ids]
    assert np.abs(norm(side.f) - 1.0).max() < 1e-15 * 4
    assert np.abs(dot(side.f, unit(cross(ends[:, 0], ends[:, 1]))[:, None])).max() < 1e-15
    assert angle_between(side.normal, side.f).max() < 1e-13


def test_an_edge_with_an_inflection_is_a_smooth_curve_and_near_to_the_one_without() -> None:
    """The curve changes smoothly as the second normal turns through the position where the first bend vanishes."""
    turn = np.linspace(-0.3, 0.3, 61)
    chord, first = np.array([1.0, 0.0, 0.0]), unit(np.array([-0.1, 0.0, 1.0]))
    normals = np.stack([np.sin(turn), 0.0 * turn, np.cos(turn)], axis=-1)
    chords, firsts = np.broadcast_to(chord, normals.shape), np.broadcast_to(first, normals.shape)
    leaving, arriving = (unit(tangential(chords, n)) for n in (firsts, normals))
    half = np.full(61, 0.5)
    middle = side_curve(**side_data(chords, leaving, arriving, firsts, normals), s=half, rest=half)[0][:, 2]
    assert middle.min() < 0.0 < middle.max()
    assert np.abs(np.diff(middle, n=2)).max() < 1e-4


def test_planes_keep_their_linear_parameters() -> None:
    mesh, at = ZOO["flat mesh"], lattice(3, 7)
    a, b, c = np.moveaxis(mesh.corner_points()[:, :, None], 1, 0)
    u, v = at[:, :1], at[:, 1:]
    points = NielsonConic().fit(mesh).batches[0].jets(at, 0).f
    np.testing.assert_allclose(points, (1 - u - v) * a + u * b + v * c, atol=1e-14)


def test_octahedron() -> None:
    """K in [0.909, 1.095] is on record; it is 0.9084 nearest to the vertices."""
    near = CORNERS[3][:, None] + 1e-5 * (np.array([[0.5, 0.5], [0.2, 0.3], [0.9, 0.1]]) - CORNERS[3][:, None])
    surface: Surface = NielsonConic().fit(octahedron())
    K = gauss(surface.batches[0].jets(np.concatenate([INTERIOR, near.reshape(-1, 2)])))
    np.testing.assert_allclose((K.min(), K.max()), (0.909, 1.095), atol=1e-3)


def test_second_derivatives_are_good_down_to_the_corner_margin() -> None:
    """Along a ray into a corner the curvature has a limit; what is left of third differences is rounding."""
    batch = NielsonConic().fit(perturbed_icosahedron()).batches[0]
    steps = batch.corner_margin * np.array([1.0, 1.25, 1.5, 1.75, 2.0])
    for corner in CORNERS[3]:
        K = gauss(batch.jets(corner + steps[:, None] * (np.array([0.4, 0.25]) - corner)))
        assert np.abs(np.diff(K, n=3, axis=1)).max() < 1e-6 * np.abs(K).max()


def test_a_chord_along_a_normal_is_refused_by_its_vertices() -> None:
    normals = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    with pytest.raises(Refused, match=r"^nielson-conic .* vertex 0 to vertex 1"):
        NielsonConic().fit(HermiteMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals))


def test_normals_that_cancel_half_way_are_refused() -> None:
    normals = unit(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.5, 1.0]]))
    with pytest.raises(Refused, match="no normal half-way"):
        NielsonConic().fit(HermiteMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals))
