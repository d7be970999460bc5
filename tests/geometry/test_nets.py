"""Nets over curve networks: the sides are the curves, to the last bit and from both faces."""

import numpy as np
import pytest

from testbed.geometry import bernstein
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE, boundary_net, corner_legs, inner_indices, side_indices

OCTAHEDRON = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def some_network(seed: int = 0) -> CurveNetwork:
    rng = np.random.default_rng(seed)
    points = np.repeat(np.eye(3), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None] + rng.uniform(-0.1, 0.1, (6, 3))
    mesh = HermiteMesh(points, OCTAHEDRON)
    control_points = rng.standard_normal((len(mesh.edges), 4, 3))
    control_points[:, [0, 3]] = points[mesh.edges]
    return CurveNetwork(mesh, control_points)


def test_the_centre_is_the_one_point_on_no_side() -> None:
    assert bernstein.multi_indices(3)[CENTRE].tolist() == [1, 1, 1]
    assert inner_indices(3).tolist() == [CENTRE]
    assert bernstein.multi_indices(4)[inner_indices(4)].tolist() == [[2, 1, 1], [1, 2, 1], [1, 1, 2]]


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 6])
def test_side_s_runs_from_corner_s_to_the_next(degree: int) -> None:
    exponents = bernstein.multi_indices(degree)
    for side, places in enumerate(side_indices(degree)):
        assert (exponents[places, (side + 2) % 3] == 0).all()
        assert exponents[places, side].tolist() == list(range(degree, -1, -1))


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_sides_are_the_raised_curves(degree: int) -> None:
    network = some_network()
    net = boundary_net(network, degree)
    raised = bernstein.elevate_curve(network.along_sides(), degree - 3)
    np.testing.assert_array_equal(net[:, side_indices(degree)], raised)
    inner = np.isin(np.arange(net.shape[1]), inner_indices(degree))
    np.testing.assert_array_equal(np.isnan(net), np.broadcast_to(inner[:, None], net.shape))


@pytest.mark.parametrize("degree", [3, 4])
def test_faces_on_an_edge_share_its_points_to_the_last_bit(degree: int) -> None:
    network = some_network()
    mesh = network.mesh
    sides = boundary_net(network, degree)[:, side_indices(degree)]
    for edge, (one, other) in enumerate(mesh.edge_faces):
        forward = sides[one][mesh.face_edges[one] == edge][0]
        back = sides[other][mesh.face_edges[other] == edge][0]
        np.testing.assert_array_equal(forward, back[::-1])


def test_each_call_gives_a_net_of_its_own() -> None:
    network = some_network()
    net = boundary_net(network)
    net[:] = 0.0
    assert np.isfinite(boundary_net(network)[:, 0]).all()
    assert (boundary_net(network)[:, 0] != 0.0).any()


@pytest.mark.parametrize("degree", [3, 4])
def test_legs_are_the_derivatives_along_the_sides(degree: int) -> None:
    net = boundary_net(some_network(), degree)
    net[:, inner_indices(degree)] = 0.5
    vertex, towards_next, towards_previous = corner_legs(net)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    jet = BezierTriangles(net).jets(corners, 1)
    np.testing.assert_array_equal(vertex, some_network().mesh.corner_points())
    for corner in range(3):
        along_next, along_previous = (corners[(corner + step) % 3] - corners[corner] for step in (1, 2))
        for legs, (du, dv) in ((towards_next, along_next), (towards_previous, along_previous)):
            derivative = du * jet.fu[:, corner] + dv * jet.fv[:, corner]
            np.testing.assert_allclose(degree * legs[:, corner], derivative, atol=1e-13)


def test_quadrilaterals_and_low_degrees_are_refused() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = HermiteMesh(points, [[0, 1, 2, 3]])
    with pytest.raises(ValueError, match="4 sides"):
        boundary_net(CurveNetwork(mesh, np.zeros((4, 4, 3))))
    with pytest.raises(ValueError, match="degree 2"):
        boundary_net(some_network(), 2)
