"""Peters' single cubics: linear normals along edges, the six equations, what is taken and what is refused."""

import numpy as np
import pytest

from testbed import registry
from testbed.conformance.meshes import cases, icosahedron, octahedron, perturbed_icosahedron, sphere, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.domain import lattice, side_points
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.nets import CENTRE, boundary_net
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, unit
from testbed_schemes.peters_cubic import PetersCubic, centre_points, linear_normal_curves

T = np.linspace(0.0, 1.0, 17)
ZOO = {case.name: case.mesh for case in cases(3)}


def bipyramid(turn: Float) -> HermiteMesh:
    """Poles and points on the equator of the unit sphere."""
    count = len(turn)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(count)], axis=-1)
    k, after = np.arange(count), (np.arange(count) + 1) % count
    faces = np.stack([k, after, np.full(count, count)], axis=-1)
    lower = np.stack([after, k, np.full(count, count + 1)], axis=-1)
    return sphere(np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]), np.concatenate([faces, lower]))


def cylinder(shear: float = 0.0) -> HermiteMesh:
    """A piece of the unit cylinder, with straight edges, arcs and diagonals; sheared, without the straight ones."""
    i, j = (axis.ravel() for axis in np.indices((4, 4)))
    turn = 0.4 * i + shear * j
    normals = np.stack([np.cos(turn), np.sin(turn), np.zeros(16)], axis=-1)
    a, b = (axis.ravel() for axis in np.indices((3, 3)))
    quads = 4 * a[:, None] + b[:, None] + np.array([0, 4, 5, 1])
    return HermiteMesh(
        normals + 0.5 * j[:, None] * [0.0, 0.0, 1.0],
        np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]),
        normals,
    )


TAKEN = {
    "octahedron": octahedron(),
    "icosahedron": icosahedron(),
    "tetrahedron": ZOO["tetrahedron"],
    "plane": ZOO["flat mesh"],
    "even bipyramid": bipyramid(2.0 * np.pi * np.arange(5) / 5),
    "uneven bipyramid": bipyramid(np.array([0.0, 1.1, 1.9, 3.3, 4.1, 5.2])),
    "cylinder": cylinder(),
}


def sampled_edges() -> EdgeData:
    """Edges between points of an elliptic paraboloid."""
    at = np.random.default_rng(1).uniform(-0.7, 0.7, (2, 100, 2))
    points = np.stack([at[..., 0], at[..., 1], -(at[..., 0] ** 2) - 0.7 * at[..., 1] ** 2], axis=-1)
    normals = unit(np.stack([2.0 * at[..., 0], 1.4 * at[..., 1], np.ones((2, 100))], axis=-1))
    return EdgeData(points[0], points[1], normals[0], normals[1], None, None)


def test_the_normal_of_a_curve_turns_linearly() -> None:
    edges = sampled_edges()
    curves = linear_normal_curves(edges)
    assert edges.n0 is not None
    assert edges.n1 is not None
    v = np.diff(curves, axis=1)
    for t in T:
        along = (1 - t) ** 2 * v[:, 0] + 2 * t * (1 - t) * v[:, 1] + t**2 * v[:, 2]
        across = (1 - t) * edges.n0 + t * edges.n1
        some = np.isfinite(curves).all(axis=(1, 2))
        assert some.sum() > 90
        assert np.abs(dot(along, across)[some]).max() < 1e-14


def test_a_short_arc_has_legs_of_a_third() -> None:
    angle = 1e-3
    n = np.array([[np.cos(t), np.sin(t), 0.0] for t in (0.0, angle)])
    curve = linear_normal_curves(EdgeData(n[:1], n[1:], n[:1], n[1:], None, None))[0]
    assert norm(np.diff(curve, axis=0)) == pytest.approx(np.full(3, angle / 3), rel=1e-6)
    # the leg is 2/3 tan(angle / 2) on every arc
    assert norm(curve[1] - curve[0]) == pytest.approx(2.0 / 3.0 * np.tan(angle / 2.0), rel=1e-9)


@pytest.mark.parametrize("mesh", TAKEN.values(), ids=TAKEN.keys())
def test_every_edge_of_every_patch_has_the_linear_normal(mesh: HermiteMesh) -> None:
    surface = PetersCubic().fit(mesh)
    normals = mesh.corner_normals()
    for side in range(3):
        found = surface.batches[0].jets(side_points(3, np.array([side]), T)[0], 1).normal
        start, end = normals[:, side, None], normals[:, (side + 1) % 3, None]
        linear = unit((1.0 - T)[:, None] * start + T[:, None] * end)
        assert np.degrees(angle_between(found, linear)).max() < 1e-12
    edges = surface.edges[surface.edges.interior]
    left, right = surface.edge_jets(edges, T, 1)
    assert np.degrees(angle_between(left.normal, right.normal)).max() < 1e-12


@pytest.mark.parametrize("mesh", [octahedron(), icosahedron(), perturbed_icosahedron()])
def test_the_centre_solves_the_six_equations_as_they_come_from_the_edges(mesh: HermiteMesh) -> None:
    """2 <Q - H1, N_j> + <F0 - H0, N_k> = 0 and <F2 - H2, N_j> + 2 <Q - H1, N_k> = 0, by a general solver."""
    network = CurveNetwork(mesh, linear_normal_curves(mesh.edge_data))
    net, normals = boundary_net(network), mesh.corner_normals()
    centre, residual = centre_points(net, normals)
    curves = network.along_sides()
    for face in range(len(net)):
        rows, right = [], []
        for side in range(3):
            h, before, after = curves[face, side], curves[face, side - 1], curves[face, (side + 1) % 3]
            start, end = normals[face, side], normals[face, (side + 1) % 3]
            rows += [start, end]
            right += [
                h[1] @ start - 0.5 * (before[2] - h[0]) @ end,
                h[1] @ end - 0.5 * (after[1] - h[2]) @ start,
            ]
        solution = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
        left_over = np.abs(np.array(rows) @ solution - right).max()
        longest = norm(np.roll(mesh.corner_points()[face], 1, axis=0) - mesh.corner_points()[face]).max()
        assert centre[face] == pytest.approx(solution, abs=1e-12)
        assert residual[face] == pytest.approx(left_over / longest, abs=1e-14)


@pytest.mark.parametrize("mesh", [octahedron(), icosahedron()])
def test_symmetric_data_satisfy_all_six_equations(mesh: HermiteMesh) -> None:
    net = boundary_net(CurveNetwork(mesh, linear_normal_curves(mesh.edge_data)))
    assert centre_points(net, mesh.corner_normals())[1].max() < 1e-15


def test_the_curvatures_of_the_octahedron() -> None:
    """27 / 16 at the centre of a face, 1 / 4 at its corners; 1.6836 and 0.2697 are values at points near them."""
    curvature = gauss(PetersCubic().fit(octahedron()).batches[0].jets(lattice(3, 60)))
    assert float(curvature.max()) == pytest.approx(27.0 / 16.0, abs=1e-12)
    assert float(curvature.min()) == pytest.approx(0.25, abs=1e-12)


def test_a_cylinder_piece_with_straight_edges_stays_developable() -> None:
    curvature = gauss(PetersCubic().fit(cylinder()).batches[0].jets(lattice(3, 12)))
    assert np.abs(curvature).max() < 1e-12
    with pytest.raises(Refused, match="no centre for 18 of 18 faces"):
        PetersCubic().fit(cylinder(shear=0.1))


def test_a_sphere_is_taken_where_corners_are_right_angled_or_have_equal_sides() -> None:
    """At a corner <y, N_k> = <x, N_i>: cos A (tan(b / 2) sin c - tan(c / 2) sin b) = 0 with sides b and c."""
    right = unit(np.array([[1.0, 0.0, 0.0], [np.cos(0.5), np.sin(0.5), 0.0], [0.0, 0.0, 1.0]]))
    PetersCubic().fit(HermiteMesh(right, [[0, 1, 2]], right))
    oblique = unit(right + np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    with pytest.raises(Refused, match=r"face 0 \(vertices 0, 1, 2\).*residual of 0\.0"):
        PetersCubic().fit(HermiteMesh(oblique, [[0, 1, 2]], oblique))


def test_the_refusal_names_the_worst_face_and_its_residual() -> None:
    mesh = perturbed_icosahedron()
    network = CurveNetwork(mesh, linear_normal_curves(mesh.edge_data))
    residual = centre_points(boundary_net(network), mesh.corner_normals())[1]
    worst = int(np.argmax(residual))
    with pytest.raises(Refused, match=f"face {worst} .*a residual of {residual[worst]:.2g} edge lengths"):
        PetersCubic().fit(mesh)


def test_an_inflected_edge_is_refused_by_its_vertices() -> None:
    with pytest.raises(Refused, match=r"no curve for \d+ of 120 edges, the first from vertex 1 to vertex 7"):
        PetersCubic().fit(torus(8, 5, 3))


def test_what_the_residual_lets_through_joins_as_smoothly_as_the_residual_is_small() -> None:
    mesh = octahedron()
    assert mesh.normals is not None
    rng = np.random.default_rng(2)
    for off in (1e-5, 1e-7):
        normals = unit(mesh.normals + off * rng.uniform(-1.0, 1.0, mesh.normals.shape))
        moved = HermiteMesh(mesh.points, mesh.faces, normals)
        with pytest.raises(Refused):
            PetersCubic(tol=off * 1e-3).fit(moved)
        surface = PetersCubic(tol=off * 10.0).fit(moved)
        left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, 1)
        assert angle_between(left.normal, right.normal).max() < 30.0 * off


@pytest.mark.parametrize(("name", "levels"), [("octahedron", 1), ("icosahedron", 1), ("plane", 3), ("sphere", 0)])
def test_which_levels_of_the_datasets_it_takes(name: str, levels: int) -> None:
    dataset = registry.dataset(name)
    for level in range(levels):
        PetersCubic().fit(dataset.mesh(level))
    if name != "plane":
        with pytest.raises(Refused):
            PetersCubic().fit(dataset.mesh(levels))


def test_flat_data_give_the_plane_with_its_own_parameters() -> None:
    mesh = ZOO["flat mesh"]
    batch = PetersCubic().fit(mesh).batches[0]
    assert isinstance(batch, BezierTriangles)
    assert batch.control_points[:, CENTRE] == pytest.approx(mesh.corner_points().mean(axis=1), abs=1e-15)
    assert norm(cross(batch.jets(lattice(3, 4), 1).normal, mesh.corner_normals()[:, :1])).max() < 1e-14


@pytest.mark.parametrize("tol", [0.0, -1.0, float("nan"), float("inf")])
def test_a_tolerance_that_is_not_positive_is_no_parameter(tol: float) -> None:
    with pytest.raises(SpecError, match="tol must be positive and finite"):
        PetersCubic(tol=tol)
