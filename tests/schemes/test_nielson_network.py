"""Side-vertex patches on a given network: by hand, tangent planes, exact derivatives, and whom they agree with."""

import numpy as np
import pytest

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron
from testbed.errors import SpecError
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Scheme
from testbed.registry import catalogue
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.gregory_charrot import GregoryCharrot
from testbed_schemes.nielson import Nielson
from testbed_schemes.nielson_network import NielsonNetwork
from testbed_schemes.triangular_gregory import TriangularGregory

ZOO = {case.name: case.mesh for case in cases(3)}
CURVES = [curve() for curve in catalogue(BoundaryCurve).values()]  # type: ignore[type-abstract]
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])


def jumps(surface: Surface) -> tuple[float, float]:
    """Largest angle between normals across edges in degrees, and largest gap."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
    angle = np.degrees(angle_between(left.normal, right.normal))
    return float(np.max(angle, initial=0.0)), float(np.max(norm(left.f - right.f), initial=0.0))


def edge_normals(scheme: Scheme, mesh: HermiteMesh) -> Float:
    surface = scheme.fit(mesh)
    return surface.side_jets(surface.edges.left, T, order=1).normal


def bezier(control: Float, t: float) -> Float:
    """Point at t of a Bezier curve (n + 1, d), by de Casteljau."""
    while len(control) > 1:
        control = (1.0 - t) * control[:-1] + t * control[1:]
    point: Float = control[0]
    return point


def radial_point(curves: list[Float], normals: Float, i: int, b: Float, jensen_c: float) -> Float:
    """G_i, from the curves of the sides s to s + 1; the field k C + h X' in scalars and vectors, as on paper."""
    j, k = (i + 1) % 3, (i + 2) % 3
    towards = {(s, (s + 1) % 3): curves[s] for s in range(3)} | {((s + 1) % 3, s): curves[s][::-1] for s in range(3)}
    side, s, r = towards[j, k], b[k] / (b[j] + b[k]), b[j] + b[k]
    hodograph = 3.0 * np.diff(side, axis=0)
    ends = 3.0 * (towards[i, j][3] - towards[i, j][2]), 3.0 * (towards[i, k][3] - towards[i, k][2])
    c = [np.cross(normals[j], hodograph[0]), np.cross(normals[k], hodograph[2])]
    c = [x / np.linalg.norm(x) for x in c]
    k0, k1 = ends[0] @ c[0], ends[1] @ c[1]
    h0 = ends[0] @ hodograph[0] / (hodograph[0] @ hodograph[0])
    h1 = ends[1] @ hodograph[2] / (hodograph[2] @ hodograph[2])
    factor = bezier(np.array([[k0], [jensen_c * (k0 + k1) - 0.5 * (k0 + k1)], [k1]]), s)
    arriving = factor * ((1 - s) * c[0] + s * c[1]) + ((1 - s) * h0 + s * h1) * bezier(hodograph, s)
    leaving = (1 - s) * 3.0 * (towards[i, j][1] - towards[i, j][0]) + s * 3.0 * (towards[i, k][1] - towards[i, k][0])
    start, end = towards[i, j][0], bezier(side, s)
    return bezier(np.stack([start, start + leaving / 3, end - arriving / 3, end]), r)


@pytest.mark.parametrize("jensen_c", [1.0, 1.234])
def test_a_point_by_hand(jensen_c: float) -> None:
    mesh, b, face = perturbed_icosahedron(), np.array([0.2, 0.5, 0.3]), 7
    curves = list(Projected().network(mesh).along_sides()[face])
    products = np.array([b[1] * b[2], b[2] * b[0], b[0] * b[1]])
    radial = [radial_point(curves, mesh.corner_normals()[face], i, b, jensen_c) for i in range(3)]
    expected = products @ np.stack(radial) / products.sum()
    found = NielsonNetwork(jensen_c=jensen_c).fit(mesh).evaluate(np.array([face]), b[None], order=0).f[0]
    np.testing.assert_allclose(found, expected, atol=1e-14)


@pytest.mark.parametrize("boundary", CURVES, ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_tangent_planes_agree_on_every_network(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for jensen_c in (1.0, 1.234):
        angle, gap = jumps(NielsonNetwork(boundary, jensen_c).fit(mesh))
        assert angle < 1e-9
        assert gap < 1e-14 * (1.0 + np.abs(mesh.points).max())


@pytest.mark.parametrize("boundary", [Projected(), Planar(), Hermite()], ids=str)
def test_edges_are_the_curves_of_the_network(boundary: BoundaryCurve) -> None:
    mesh, t = perturbed_icosahedron(), np.linspace(0.0, 1.0, 9)
    found = NielsonNetwork(boundary).fit(mesh).batches[0].jets(np.stack([t, 0.0 * t], axis=-1), 0).f
    side = boundary.network(mesh).along_sides()[:, 0]
    expected = np.stack([bezier(np.moveaxis(side, 1, 0), x) for x in t], axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_nielsons_own_normals_come_out_on_nielsons_own_curves() -> None:
    """With tangents of one length g_n is perpendicular to the same field: C0 and C1 are N x X' over that length."""
    mesh = perturbed_icosahedron()
    own = edge_normals(Nielson(), mesh)
    assert angle_between(own, edge_normals(NielsonNetwork(Projected()), mesh)).max() < 1e-13
    circular = edge_normals(Nielson(tangents="circular"), mesh)
    assert angle_between(circular, edge_normals(NielsonNetwork(Circular()), mesh)).max() > 1e-3


@pytest.mark.parametrize("boundary", [Projected(), Hermite()], ids=str)
def test_schemes_with_one_field_have_one_normal_along_the_edges(boundary: BoundaryCurve) -> None:
    mesh = perturbed_icosahedron()
    expected = edge_normals(TriangularGregory(boundary), mesh)
    for scheme in (NielsonNetwork(boundary), GregoryCharrot(boundary)):
        assert angle_between(edge_normals(scheme, mesh), expected).max() < 1e-13


def test_curvature_at_a_vertex_depends_on_the_direction_as_in_gregorys_patch() -> None:
    """The limits are those of every scheme on the same curves whose field is Chiyokura and Kimura's."""
    mesh, near = perturbed_icosahedron(), np.array([[0.9, 0.1], [0.5, 0.5], [0.1, 0.9]])
    schemes = (TriangularGregory(), NielsonNetwork(), GregoryCharrot(), Nielson())
    one, *others = [gauss(scheme.fit(mesh).batches[0].jets(1e-6 * near)) for scheme in schemes]
    assert (np.ptp(one, axis=1) > 0.05).any()
    for other in others:
        np.testing.assert_allclose(other, one, atol=1e-5)


def test_a_flat_mesh_keeps_the_linear_parameters_of_its_faces() -> None:
    mesh, at = ZOO["flat mesh"], lattice(3, 7)
    for scheme in (NielsonNetwork(), NielsonNetwork(jensen_c=1.0, boundary=Hermite())):
        a, b, c = np.moveaxis(mesh.corner_points()[:, :, None], 1, 0)
        u, v = at[:, :1], at[:, 1:]
        points = scheme.fit(mesh).batches[0].jets(at, 0).f
        np.testing.assert_allclose(points, (1 - u - v) * a + u * b + v * c, atol=1e-14)


@pytest.mark.parametrize(
    ("scheme", "gauss_range"),
    [
        (NielsonNetwork(), (0.3998, 2.7183)),
        (NielsonNetwork(Hermite()), (0.5776, 2.1713)),
        (NielsonNetwork(Hermite(), 1.234), (0.9071, 1.0369)),
    ],
    ids=str,
)
def test_octahedron(scheme: Scheme, gauss_range: tuple[float, float]) -> None:
    """To what we measure; the first two are on record for other schemes only."""
    at = lattice(3, 60)
    K = gauss(scheme.fit(octahedron()).batches[0].jets(at[1.0 - at.max(axis=1) > 0.0][1:]))
    np.testing.assert_allclose((K.min(), K.max()), gauss_range, atol=1e-4)


def test_jensens_c_is_finite() -> None:
    with pytest.raises(SpecError, match="jensen_c"):
        NielsonNetwork(jensen_c=float("nan"))
