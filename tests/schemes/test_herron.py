"""Herron's scheme: three blended quartics as printed, appendix A with its misprint, and the mean that replaces it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import icosahedron, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.bernstein import curve_tables
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import barycentric, corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.continuity_conditions.chiyokura_kimura import perpendicular_derivative
from testbed_schemes.herron import Herron
from testbed_schemes.triangular_gregory import TriangularGregory

AT = lattice(3, 12)
AT = AT[corner_distance(3, AT) > 0.0]


def control_points(mesh: HermiteMesh, jensen_c: float = 1.0) -> Float:
    """Control points of the scheme, (F, 18, 3)."""
    batch = Herron(jensen_c=jensen_c).fit(mesh).batches[0]
    assert isinstance(batch, TabulatedTriangles)
    return batch.control_points


def random_triangles(seed: int) -> HermiteMesh:
    """Return five triangles of any shape and place, their normals within some forty degrees of the face's."""
    rng = np.random.default_rng(seed)
    corners = np.eye(3) + 0.2 * rng.normal(size=(5, 3, 3)) + 3.0 * rng.normal(size=(5, 1, 3))
    flat = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    normals = unit(flat[:, None] + 0.4 * rng.uniform(-1.0, 1.0, corners.shape))
    return HermiteMesh(corners.reshape(-1, 3), np.arange(15).reshape(-1, 3), normals.reshape(-1, 3))


def blend_of_three(points: Float, free: Float) -> Float:
    """Equation (2.13) as printed, at AT: sum of beta_i F_i, with ``free`` (F, 3, 3) for the C_i."""
    b = barycentric(AT)
    beta = np.stack([b[:, 1] * b[:, 2], b[:, 2] * b[:, 0], b[:, 0] * b[:, 1]])
    beta /= beta.sum(axis=0)
    total: Float = np.zeros((len(points), len(AT), 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        net = np.empty((len(points), 15, 3))
        net[:, [0, 1, 3, 6, 10, 11, 12, 13, 14, 9, 5, 2]] = points[:, :12]
        inner = [4, 7, 8]
        net[:, inner[i]] = free[:, i]
        # edge i is the second one of corner j and the first one of corner k
        net[:, inner[j]], net[:, inner[k]] = points[:, 13 + 2 * j], points[:, 12 + 2 * k]
        total += beta[i][:, None] * BezierTriangles(net).jets(AT, 0).f
    return total


def appendix_a(mesh: HermiteMesh, jensen_c: float = 1.0, sign: float = -1.0) -> Float:
    """C_i of the thesis's appendix A, (F, 3, 3), with r_ji and r_ki times ``sign``: 1 as printed, -1 corrected."""
    curves, normals = Herron().boundary.network(mesh).opposite_vertices(), mesh.corner_normals()
    result = np.empty((len(curves), 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        v_i, v_j, v_k = curves[:, k, 0], curves[:, i, 0], curves[:, j, 0]
        t_ij, t_ji = 3.0 * (curves[:, k, 1] - v_i), 3.0 * (curves[:, k, 2] - v_j)
        t_jk, t_kj = 3.0 * (curves[:, i, 1] - v_j), 3.0 * (curves[:, i, 2] - v_k)
        t_ki, t_ik = 3.0 * (curves[:, j, 1] - v_k), 3.0 * (curves[:, j, 2] - v_i)
        r_ji = sign * (dot(t_jk, t_ji) / dot(t_jk, t_jk))[:, None]
        r_ki = sign * (dot(t_kj, t_ki) / dot(t_kj, t_kj))[:, None]
        field, _ = perpendicular_derivative(curves[:, i], t_ji, t_ki, normals[:, j], normals[:, k], jensen_c)
        bracket = np.zeros_like(v_i)
        for t in (1.0 / 3.0, 2.0 / 3.0):
            p_j, p_k = t * (r_ji + r_ki + 1) - r_ji - 1, (1 - t) * (r_ji + r_ki + 1) - r_ki - 1
            q = 6 * t * (1 - t) * (p_j * v_j + p_k * v_k) + (1 - t) ** 2 * t_ji + t**2 * t_ki
            q += ((1 - t) ** 2 * p_k + 2 * t * (1 - t) * p_j) * t_jk + (t**2 * p_j + 2 * t * (1 - t) * p_k) * t_kj
            r = np.einsum("r,frx->fx", curve_tables(3, np.array(t), 0)[0], field)
            bracket += 9.0 / 4.0 * (r - q)
        middle = v_j / 2 + t_ji / 6 + v_i / 2 + t_ij / 6
        result[:, i] = (-6 * v_j - 2 * t_ji + t_ik - t_ij + bracket) / 12 + middle
    return result


def means(points: Float) -> Float:
    """Means of the two Chiyokura-Kimura points near each corner, (F, 3, 3)."""
    return (points[:, 12::2] + points[:, 13::2]) / 2.0


@given(st.integers(0, 2**32 - 1), st.floats(-1.0, 3.0))
@settings(max_examples=40, deadline=None)
def test_appendix_a_corrected_and_the_mean_are_one_surface(seed: int, jensen_c: float) -> None:
    mesh = random_triangles(seed)
    points = control_points(mesh, jensen_c)
    surface = Herron(jensen_c=jensen_c).fit(mesh).batches[0].jets(AT, 0).f
    by_appendix, by_mean = appendix_a(mesh, jensen_c), means(points)
    size = np.abs(points).max()
    assert blend_of_three(points, by_mean) == pytest.approx(surface, abs=1e-12 * size)
    assert blend_of_three(points, by_appendix) == pytest.approx(surface, abs=1e-12 * size)
    assert by_appendix.sum(axis=1) == pytest.approx(points[:, 12:].sum(axis=1) / 2.0, abs=1e-13 * size)


def test_appendix_a_and_the_mean_differ_point_by_point() -> None:
    mesh = random_triangles(1)
    assert norm(appendix_a(mesh) - means(control_points(mesh))).max() > 1e-2


@pytest.mark.parametrize(
    ("apex", "printed_error"), [((0.0, 1.0), 0.02619), ((0.3, 0.8), 0.01153), ((0.5, 0.75**0.5), 0.0)]
)
def test_the_printed_signs_of_appendix_a_break_linear_precision(
    apex: tuple[float, float], printed_error: float
) -> None:
    """On the equilateral triangle the errors of the three C_i cancel out."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [*apex, 0.0]])
    mesh = HermiteMesh(corners, [[0, 1, 2]], np.tile([0.0, 0.0, 1.0], (3, 1)))
    expected, points = barycentric(AT) @ corners, control_points(mesh)
    error = {
        sign: norm(blend_of_three(points, appendix_a(mesh, sign=sign))[0] - expected).max() for sign in (1.0, -1.0)
    }
    assert error[1.0] == pytest.approx(printed_error, abs=5e-6)
    assert error[-1.0] < 1e-15
    assert norm(Herron().fit(mesh).batches[0].jets(AT, 0).f[0] - expected).max() < 1e-15


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_of_the_free_points_only_the_sum_has_an_influence(seed: int) -> None:
    mesh, rng = random_triangles(seed), np.random.default_rng(seed)
    points = control_points(mesh)
    shift = rng.normal(size=(5, 3, 3))
    balanced = shift - shift.mean(axis=1, keepdims=True)
    before = blend_of_three(points, means(points))
    assert blend_of_three(points, means(points) + balanced) == pytest.approx(before, abs=1e-13 * np.abs(points).max())
    assert norm(blend_of_three(points, means(points) + shift) - before).max() > 1e-3


EXTREMES = [
    (Herron(), octahedron(), (0.41800, 2.91054)),
    (Herron(Hermite()), octahedron(), (0.59366, 2.30750)),
    (Herron(Hermite(), jensen_c=1.234), octahedron(), (0.98430, 1.03784)),
    (Herron(Hermite(), jensen_c=1.062), icosahedron(), (0.99433, 1.00733)),
]


@pytest.mark.parametrize(("scheme", "mesh", "extremes"), EXTREMES, ids=[str(case[0]) for case in EXTREMES])
def test_the_curvatures_on_platonic_solids(scheme: Herron, mesh: HermiteMesh, extremes: tuple[float, float]) -> None:
    at = lattice(3, 60)
    curvature = gauss(scheme.fit(mesh).batches[0].take(slice(0, 1)).jets(at[corner_distance(3, at) > 0.0]))
    assert (float(curvature.min()), float(curvature.max())) == pytest.approx(extremes, abs=1e-5)


def test_it_has_gregorys_control_points_and_another_blend() -> None:
    mesh = perturbed_icosahedron()
    gregory = TriangularGregory().fit(mesh).batches[0]
    assert isinstance(gregory, TabulatedTriangles)
    assert np.array_equal(control_points(mesh), gregory.control_points)
    assert norm(gregory.jets(AT, 0).f - Herron().fit(mesh).batches[0].jets(AT, 0).f).max() > 1e-3
    # at the centre all shares are one half
    centre = np.full((1, 2), 1.0 / 3.0)
    assert Herron().fit(mesh).batches[0].jets(centre, 0).f == pytest.approx(gregory.jets(centre, 0).f, abs=1e-15)


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="herron needs vertex normals"):
        Herron().fit(HermiteMesh(mesh.points, mesh.faces))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        Herron().fit(torus(8, 5, 4))


@pytest.mark.parametrize("jensen_c", [float("nan"), float("inf")])
def test_a_jensen_c_that_is_not_finite_is_no_parameter(jensen_c: float) -> None:
    with pytest.raises(SpecError, match="jensen_c must be finite"):
        Herron(jensen_c=jensen_c)
