"""Bezier nets over the faces of a mesh: boundary points from a curve network, names for places in a net."""

import numpy as np

from testbed.geometry.bernstein import elevate_curve, index_of, multi_indices, point_count, triangle_degree
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.vectors import Float, Int

#: Place of the inner control point 111 of a cubic triangle.
CENTRE = index_of((1, 1, 1))


def side_indices(degree: int) -> Int:
    """Places of the control points along the sides, (3, degree + 1); side s runs from corner s to corner s + 1."""
    r = np.arange(degree + 1)
    places = np.empty((3, degree + 1), dtype=np.int64)
    for side in range(3):
        exponents = np.zeros((degree + 1, 3), dtype=np.int64)
        exponents[:, side] = degree - r
        exponents[:, (side + 1) % 3] = r
        places[side] = [index_of((i, j, k)) for i, j, k in exponents.tolist()]
    return places


def inner_indices(degree: int) -> Int:
    """Places of the control points that are on no side, in the order of the net."""
    return np.flatnonzero((multi_indices(degree) > 0).all(axis=1))


def boundary_net(network: CurveNetwork, degree: int = 3) -> Float:
    """Nets of triangles bounded by the curves of a network, inner control points open.

    Parameters
    ----------
    network
        Cubic curves on the edges of a mesh of triangles.
    degree
        3, or more: the curves are raised to that degree.

    Returns
    -------
    Float
        (F, n, 3); the inner points (one, :data:`CENTRE`, for a cubic; see :func:`inner_indices`) are NaN until set.

    Raises
    ------
    ValueError
        The faces are not triangles, or the degree is below 3.
    """
    curves = network.along_sides()
    if curves.shape[1] != 3 or degree < 3:
        raise ValueError(
            f"a boundary net of degree {degree} over faces with {curves.shape[1]} sides: need triangles, degree >= 3"
        )
    net = np.full((len(curves), point_count(degree), 3), np.nan)
    net[:, side_indices(degree)] = elevate_curve(curves, degree - 3)
    return net


def corner_legs(net: Float) -> tuple[Float, Float, Float]:
    """Corners of nets (F, n, 3) and the first legs of the boundary there.

    Returns
    -------
    tuple
        The corner, the vector from it to the control point beside it towards the next corner, and the same towards the
        previous corner, (F, 3, 3) each; axis 1 is the corner. A leg times the degree is the derivative along that side.
    """
    sides = side_indices(triangle_degree(net.shape[1]))
    vertex = net[:, sides[:, 0]]
    towards_next = net[:, sides[:, 1]] - vertex
    towards_previous = net[:, np.roll(sides, 1, axis=0)[:, -2]] - vertex
    return vertex, towards_next, towards_previous
