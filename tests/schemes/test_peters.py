"""Peters: cubic and quartic faces side by side, Jensen's surface on symmetric data, the split element as a system."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import cases, icosahedron, octahedron, perturbed_icosahedron, tetrahedron, torus
from testbed.errors import SpecError
from testbed.geometry.bernstein import elevate_triangle
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.jensen import Jensen
from testbed_schemes.peters import Peters, SecondRows, is_quadratic

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])
CLOSED = {
    "octahedron": octahedron(),
    "icosahedron": icosahedron(),
    "tetrahedron": tetrahedron(),
    "perturbed": perturbed_icosahedron(),
    "torus": torus(8, 5, 3),
}
WITH_CUBICS = {**CLOSED, **{name: ZOO[name] for name in ("open mesh with a vertex of valence 12", "needle faces")}}
SYMMETRIC = {name: CLOSED[name] for name in ("octahedron", "icosahedron", "tetrahedron")}


def nets(surface: Surface, degree: int) -> Float:
    """Control points of the patches of one degree, (F, 3, n, 3)."""
    (batch,) = (one for one in surface.batches if isinstance(one, BezierTriangles) and one.degree == degree)
    return batch.control_points.reshape(-1, 3, *batch.control_points.shape[1:])


def degrees(surface: Surface) -> list[int]:
    """Degrees of the batches."""
    return [batch.degree for batch in surface.batches if isinstance(batch, BezierTriangles)]


def largest_jump(surface: Surface) -> float:
    """Largest angle between normals across edges, inner ones included, in degrees."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
    assert norm(left.f - right.f).max() < 1e-14 * (1.0 + np.abs(surface.mesh.points).max())
    return float(np.degrees(angle_between(left.normal, right.normal)).max())


def extremes(surface: Surface, margin: float = -1.0) -> tuple[float, float]:
    """Least and greatest Gaussian curvature at points of the patches further than ``margin`` from their edges."""
    at = lattice(3, 30)
    at = at[np.min([*at.T, 1.0 - at.sum(axis=1)], axis=0) > margin]
    curvature = [gauss(batch.jets(at)) for batch in surface.batches]
    return float(min(k.min() for k in curvature)), float(max(k.max() for k in curvature))


@pytest.mark.parametrize("boundary", [PetersCurve(), Projected(), Circular(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_mesh_edges_and_inner_edges(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for scheme in (Peters(boundary), Peters(boundary, tol=0.01), Peters(boundary, tol=1.0, jensen_c=1.3)):
        assert largest_jump(scheme.fit(mesh)) < 1e-8


def test_cubic_and_quartic_faces_stand_side_by_side_and_agree_about_their_edges() -> None:
    mesh = torus(10, 5, 3)
    surface = Peters(Projected(), tol=0.05).fit(mesh)
    assert degrees(surface) == [3, 4]
    assert sorted(np.concatenate([part.faces for part in surface.parts])) == sorted(np.repeat(np.arange(100), 3))
    edges = surface.edges[surface.edges.interior]
    assert (edges.left.part != edges.right.part).sum() > 10
    assert largest_jump(surface) < 1e-10
    assert surface.notes == {"faces made quartic": len(surface.parts[1].faces) // 3}
    # a face is quartic if one of its edges is, and the rows of its other edges are raised cubics
    rows = SecondRows.of(Projected().network(mesh), 0.05)
    assert np.array_equal(np.unique(surface.parts[1].faces), np.flatnonzero(rows.quartic[mesh.face_edges].any(axis=1)))
    assert np.isfinite(rows.solved[:, ~rows.quartic]).all()
    assert np.isnan(rows.solved[:, rows.quartic]).all()


@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_the_quartic_construction_without_quartic_edges_is_the_cubic_one_raised(mesh: HermiteMesh) -> None:
    scheme = Peters()
    rows = SecondRows.of(scheme.boundary.network(mesh), 1e-6)
    assert not rows.quartic.any()
    faces = np.flatnonzero(~rows.sides(np.arange(len(mesh.faces))).free.any(axis=1))
    assert len(faces) or len(mesh.faces) == 1
    assert scheme.quartics(rows, faces) == pytest.approx(elevate_triangle(scheme.cubics(rows, faces)), abs=2e-15)


@pytest.mark.parametrize("boundary", [Projected(), Circular(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", SYMMETRIC.values(), ids=SYMMETRIC.keys())
def test_on_symmetric_data_with_cubic_edges_it_is_jensens_scheme(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    """Every edge is singular: b_0 = b_1 = 1 / 2."""
    surface = Peters(boundary).fit(mesh)
    assert degrees(surface) == [4]
    assert nets(surface, 4) == pytest.approx(nets(Jensen(boundary).fit(mesh), 4), abs=1e-14)


@pytest.mark.parametrize("mesh", WITH_CUBICS.values(), ids=WITH_CUBICS.keys())
def test_without_solved_edges_it_is_jensens_scheme_on_any_data(mesh: HermiteMesh) -> None:
    surface = Peters(Projected(), tol=1.0, jensen_c=1.2).fit(mesh)
    assert nets(surface, 4) == pytest.approx(nets(Jensen(Projected(), 1.2).fit(mesh), 4), abs=1e-14)


@pytest.mark.parametrize("mesh", SYMMETRIC.values(), ids=SYMMETRIC.keys())
def test_its_own_curves_make_symmetric_data_cubic(mesh: HermiteMesh) -> None:
    surface = Peters().fit(mesh)
    assert degrees(surface) == [3]
    assert surface.notes == {}


def test_rows_that_are_solved_keep_the_side_of_the_face_they_belong_to() -> None:
    """Swapping the two faces' points, or taking the row of the quadratic rule on a cubic edge, breaks the join."""
    mesh = torus(10, 5, 3)
    network = Projected().network(mesh)
    scheme, rows = Peters(Projected(), tol=1e-9), SecondRows.of(network, 1e-9)
    faces = np.arange(len(mesh.faces))

    def jump(changed: SecondRows) -> float:
        net = scheme.cubics(changed, faces).reshape(-1, 10, 3)
        return largest_jump(Surface.over_split_faces(mesh, BezierTriangles(net)))

    assert not rows.quartic.any()
    assert jump(rows) < 1e-8
    swapped = SecondRows(network, rows.quadratic, rows.quartic, rows.solved[::-1])
    assert jump(swapped) > 1.0
    as_quadratics = SecondRows(network, np.ones_like(rows.quadratic), rows.quartic, rows.solved)
    assert jump(as_quadratics) > 1e-3


def test_the_torus_near_singular_edges() -> None:
    """[-12, 6] at tol = 0.1 and [-22, 27] at 0.05, as measured at points inside the patches; more at their corners."""
    i, j = (axis.ravel() for axis in np.indices((10, 5)))
    u, v = 2.0 * np.pi * i / 10, 2.0 * np.pi * j / 5
    out = np.stack([np.cos(u), np.sin(u), np.zeros(50)], axis=-1)
    normals = np.cos(v)[:, None] * out + np.sin(v)[:, None] * [0.0, 0.0, 1.0]
    i1, j1 = (i + 1) % 10, (j + 1) % 5
    quads = np.stack([5 * i + j, 5 * i1 + j, 5 * i1 + j1, 5 * i + j1], axis=-1)
    mesh = HermiteMesh(out + 0.4 * normals, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), normals)
    careful, bold = Peters(Projected()).fit(mesh), Peters(Projected(), tol=0.05).fit(mesh)
    assert careful.notes == {"faces made quartic": 100}
    assert bold.notes == {"faces made quartic": 80}
    assert extremes(careful, 1e-9) == pytest.approx((-11.5, 6.0), abs=0.05)
    assert extremes(bold, 1e-9) == pytest.approx((-21.5, 23.4), abs=0.05)
    assert extremes(careful) == pytest.approx((-13.3, 6.8), abs=0.05)
    assert extremes(bold) == pytest.approx((-40.2, 27.5), abs=0.05)


def test_a_cylinder_piece_with_its_own_curves_stays_developable() -> None:
    i, j = (axis.ravel() for axis in np.indices((4, 4)))
    normals = np.stack([np.cos(0.4 * i), np.sin(0.4 * i), np.zeros(16)], axis=-1)
    a, b = (axis.ravel() for axis in np.indices((3, 3)))
    quads = 4 * a[:, None] + b[:, None] + np.array([0, 4, 5, 1])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    surface = Peters().fit(HermiteMesh(normals + 0.5 * j[:, None] * [0.0, 0.0, 1.0], faces, normals))
    assert degrees(surface) == [3]
    assert max(np.abs(extremes(surface))) < 1e-12
    assert max(np.abs(extremes(Peters(Projected()).fit(surface.mesh)))) > 1e-2


def test_an_open_face_with_cubic_edges_is_cubic_and_keeps_linear_precision() -> None:
    mesh = ZOO["one face"]
    assert degrees(Peters(Projected()).fit(mesh)) == [3]
    flat = HermiteMesh(mesh.points * [1.0, 1.0, 0.0], mesh.faces, np.tile([0.0, 0.0, 1.0], (3, 1)))
    surface = Peters(Projected()).fit(flat)
    bary = np.array([[0.2, 0.3, 0.5], [0.7, 0.1, 0.2], [0.1, 0.6, 0.3]])
    assert surface.evaluate(np.zeros(3, dtype=np.int64), bary, 0).f == pytest.approx(bary @ flat.points, abs=1e-15)


@cache
def random_network_curves() -> Float:
    return np.random.default_rng(1).normal(size=(200, 4, 3))


@pytest.mark.parametrize("shift", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_quadratics_are_told_from_cubics_in_any_place_and_size(shift: float, scale: float) -> None:
    points = random_network_curves()
    q0, q1, q2 = points[:, 0], points[:, 1], points[:, 2]
    raised = np.stack([q0, (q0 + 2.0 * q1) / 3.0, (2.0 * q1 + q2) / 3.0, q2], axis=1)
    assert is_quadratic(scale * (raised + shift)).all()
    assert not is_quadratic(scale * (points + shift)).any()
    bent = raised + 1e-6 * np.array([0.0, 1.0, -1.0, 0.0])[:, None]
    assert not is_quadratic(scale * bent).any()


@given(st.floats(1e-3, 2.0), st.floats(0.5, 2.5))
@settings(max_examples=10)
def test_every_tol_and_c_leaves_the_surface_tangent_continuous(tol: float, jensen_c: float) -> None:
    surface = Peters(Projected(), tol=tol, jensen_c=jensen_c).fit(torus(8, 5, 3))
    assert largest_jump(surface) < 1e-8


@pytest.mark.parametrize("tol", [0.0, -0.1, float("nan"), float("inf")])
def test_a_tol_that_is_not_positive_is_no_parameter(tol: float) -> None:
    with pytest.raises(SpecError, match="tol must be positive and finite"):
        Peters(tol=tol)


@pytest.mark.parametrize("jensen_c", [float("nan"), float("inf")])
def test_a_jensen_c_that_is_not_finite_is_no_parameter(jensen_c: float) -> None:
    with pytest.raises(SpecError, match="jensen_c must be finite"):
        Peters(jensen_c=jensen_c)
