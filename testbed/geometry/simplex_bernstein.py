"""Bernstein-Bezier algebra of simplices: multi-indices, blossoms as tables, depth elevation.

A Bezier simplex of degree d in n barycentric coordinates has C(n - 1 + d, d) control points, multi-indices
(s_0, ..., s_{n-1}), the exponents of the coordinates, ordered by decreasing s_0, then decreasing s_1, and so on; with
n = 3 that is the order of :mod:`testbed.geometry.bernstein`. The place of a multi-index is

    sum over k = 1 .. n - 1 of C(r_k + n - 1 - k, n - k),   r_k = s_k + ... + s_{n-1},

which does not depend on d. The formulas are those of S-patches (Loop and DeRose 1989; Mann 1992, section 5.4.3).
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from testbed.geometry.vectors import Float, Int


def simplex_point_count(sides: int, degree: int) -> int:
    """Control points of a simplex with ``sides`` coordinates, C(n - 1 + d, d)."""
    return math.comb(sides - 1 + degree, degree)


@cache
def simplex_multi_indices(sides: int, degree: int) -> Int:
    """Exponents in the order of the control points, (C(n - 1 + d, d), n), read-only."""
    rows = np.array([[degree]], dtype=np.int64)
    for _ in range(sides - 1):
        # the last coordinate so far is divided between itself and one more
        parts = rows[:, -1] + 1
        owner = np.repeat(np.arange(len(rows)), parts)
        moved = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
        rows = np.column_stack([rows[owner, :-1], rows[owner, -1] - moved, moved])
    rows.flags.writeable = False
    return rows


def simplex_places(indices: Int) -> Int:
    """Places (...) of multi-indices (..., n) in their nets, by the sum above."""
    sides = indices.shape[-1]
    tails = np.cumsum(indices[..., ::-1], axis=-1)[..., ::-1]
    place = np.zeros(indices.shape[:-1], dtype=np.int64)
    for k in range(1, sides):
        binomials = np.array([math.comb(r + sides - 1 - k, sides - k) for r in range(int(tails.max(initial=0)) + 1)])
        place += binomials[tails[..., k]]
    return place


@cache
def simplex_raised(sides: int, degree: int) -> Int:
    """Places, in the net of degree + 1, of the multi-indices of ``degree`` with one raised: (n, points), read-only."""
    places = simplex_places(simplex_multi_indices(sides, degree) + np.eye(sides, dtype=np.int64)[:, None, :])
    places.flags.writeable = False
    return places


@cache
def side_places(sides: int, degree: int) -> Int:
    """Places (n, degree + 1) of the control points along side i, from corner i to corner i + 1; read-only."""
    unit = np.eye(sides, dtype=np.int64)
    k = np.arange(degree + 1)[:, None]
    places = simplex_places((degree - k) * unit[:, None] + k * np.roll(unit, -1, axis=0)[:, None])
    places.flags.writeable = False
    return places


def blossom_step(table: Float, sides: int, degree: int, argument: Float) -> Float:
    """Give a blossom one argument more.

    Parameters
    ----------
    table
        (N, ...): what each control point of a simplex of ``degree`` counts in a blossom of ``degree`` arguments.
    argument
        (n, ...): the new argument, a point (sum one) or a direction (sum zero).

    Returns
    -------
    Float
        The same for degree + 1. The transpose of a de Casteljau step, with the same multiplications.
    """
    result = np.zeros(
        (simplex_point_count(sides, degree + 1), *np.broadcast_shapes(table.shape[1:], argument.shape[1:]))
    )
    for coordinate, places in zip(argument, simplex_raised(sides, degree), strict=True):
        result[places] += coordinate * table
    return result


def blossom_table(arguments: Sequence[Float]) -> Float:
    """What each control point counts in b(u^1, ..., u^d): (N, ...) for d >= 1 arguments (n, ...) each.

    Equal points give the Bernstein polynomials there.
    """
    sides = len(arguments[0])
    table = np.ones((1, *arguments[0].shape[1:]))
    for degree, argument in enumerate(arguments):
        table = blossom_step(table, sides, degree, argument)
    return table


def composed_tables(depth: int, coordinates: Float) -> Float:
    """Bernstein polynomials of a simplex composed with a map L into it, and their derivatives.

    Parameters
    ----------
    depth
        Degree d of the simplex.
    coordinates
        Jets of L, (1 | 3 | 6, n, ...): L | L_x, L_y | L_xx, L_xy, L_yy.

    Returns
    -------
    Float
        (1 | 3 | 6, N, ...), by the blossom b of the simplex (Mann 1992, appendix B):

            D_z S = d b(D_z L, L, ..., L),
            D_zw S = d (d - 1) b(D_z L, D_w L, L, ..., L) + d b(D_zw L, L, ..., L).
    """
    L = coordinates[0]
    sides, shape = len(L), L.shape[1:]
    rows = len(coordinates)
    result = np.empty((rows, simplex_point_count(sides, depth), *shape))
    # degree d - 1, and d - 2 for the second derivatives
    lower = blossom_table([L] * (depth - 2)) if depth > 2 else np.ones((1, *shape))
    last = blossom_step(lower, sides, depth - 2, L) if depth > 1 else lower
    result[0] = blossom_step(last, sides, depth - 1, L)
    for row in range(1, rows):
        result[row] = depth * blossom_step(last, sides, depth - 1, coordinates[row])
    if rows == 6 and depth > 1:
        for row, (z, w) in zip((3, 4, 5), ((1, 1), (1, 2), (2, 2)), strict=True):
            along = blossom_step(lower, sides, depth - 2, coordinates[z])
            result[row] += depth * (depth - 1) * blossom_step(along, sides, depth - 1, coordinates[w])
    return result


def contracted(net: Float, sides: int, degree: int, argument: Float) -> Float:
    """One de Casteljau step: nets (N, ..., S) of a degree to those of degree - 1, at an argument (n, S) for each."""
    result: Float = argument[0] * net[simplex_raised(sides, degree - 1)[0]]
    for coordinate, places in zip(argument[1:], simplex_raised(sides, degree - 1)[1:], strict=True):
        result += coordinate * net[places]
    return result


def composed_jets(depth: int, nets: Float, coordinates: Float) -> Float:
    """Jets of simplices composed with a map L into them, each simplex at its own point, by the de Casteljau algorithm.

    Parameters
    ----------
    depth
        Degree d of the simplices.
    nets
        (N, dim, S) control points.
    coordinates
        Jets of L, (1 | 3 | 6, n, S).

    Returns
    -------
    Float
        (1 | 3 | 6, dim, S), by the formulas of :func:`composed_tables`, with the arguments L taken first.
    """
    L, rows = coordinates[0], len(coordinates)
    sides = len(L)
    result = np.empty((rows, *nets.shape[1:]))
    quadratic: Float | None = None
    for degree in range(depth, 1, -1):
        if degree == 2:
            quadratic = nets
        nets = contracted(nets, sides, degree, L)
    result[0] = contracted(nets, sides, 1, L)[0]
    for row in range(1, rows):
        result[row] = depth * contracted(nets, sides, 1, coordinates[row])[0]
    if rows == 6 and quadratic is not None:
        along_x, along_y = (contracted(quadratic, sides, 2, coordinates[z]) for z in (1, 2))
        for row, (along, w) in zip((3, 4, 5), ((along_x, 1), (along_x, 2), (along_y, 2)), strict=True):
            result[row] += depth * (depth - 1) * contracted(along, sides, 1, coordinates[w])[0]
    return result


def elevate_simplex(net: Float, sides: int, degree: int, steps: int = 1) -> Float:
    """Nets (..., N, dim) of the same simplices written with degree d + steps: P_s = sum_i s_i / (d + 1) P_{s - e_i}."""
    for current in range(degree, degree + steps):
        exponents = simplex_multi_indices(sides, current) + 1
        total = np.zeros((*net.shape[:-2], simplex_point_count(sides, current + 1), net.shape[-1]))
        for i, places in enumerate(simplex_raised(sides, current)):
            total[..., places, :] += exponents[:, i, None] * net
        net = total / (current + 1)
    return net
