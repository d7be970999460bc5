"""Patches of zero sets met by rays that start on an edge: A-patches of edges, with two sides collapsed to points."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.evaluation import PARTIALS
from testbed.geometry.jets import ROWS
from testbed.geometry.shooting_rays import (
    Hits,
    Shooting,
    differentiated_root,
    frozen_fields,
    ray_roots,
    side_of,
)
from testbed.geometry.simplex_bernstein import simplex_places
from testbed.geometry.taylor import Taylor
from testbed.geometry.tetrahedral import EDGE_TERM, QuotientTerm
from testbed.geometry.vectors import Bool, Float, Int

#: Places in the net of a tetrahedron of the coefficients of b_s, one row s; the index along v runs faster.
LAYERS = tuple(
    simplex_places(np.array([[s - j, 3 - s - i, i, j] for i in range(4 - s) for j in range(s + 1)])) for s in range(4)
)
#: F at the ends of a patch, where rays have no length, is at most this, relative to the largest coefficient of F.
AT_ENDS = 1e-9
#: A ray's length that grows less than this, relative to its second derivative, leaves the edge with the square.
TANGENT = 1e-9


@dataclass(frozen=True, eq=False)
class ShootingQuads(Shooting):
    """Patches met by rays from the points of an edge to the points of a segment; see :class:`Shooting`.

    Parameters
    ----------
    ends
        (P, 2, 3) ends p_i, p_j of the edge.
    apexes
        (P, 2, 2, 3) ends of the segment rays run to, at v = 0 and at v = 1; the first of the axes of length two is the
        side, positive and negative. NaN where a side has no tetrahedron.
    nets
        (P, 2, 20) coefficients of F, positive outside, on [apex at v = 0, p_i, p_j, apex at v = 1].
    rational
        (P, 2, 4) a_1101, b_1101, a_1011, b_1011 of equation 4.3.
    span
        (P, 2) the part of the edge, 0 at p_i and 1 at p_j, that u runs over. F is zero at its ends.

    Raises
    ------
    ValueError
        F is not zero at an end of the span.

    Notes
    -----
    With x = x_0 + (x_1 - x_0) u a point is (1 - t) ((1 - x) p_i + x p_j) + t ((1 - v) w_0 + v w_1), w the apexes of the
    positive side where F <= 0 on the edge, else of the negative one. The shooting polynomial, with its rational terms,
    is a polynomial in x, v and t.

    The sides u = 0 and u = 1 are points in space: t = 0. Beside them t = -b_0 / (3 b_1) to first order, where b_0 does
    not depend on v, so that f_v / t tends to w_v - (b_1v / b_1) (w - q). On them this stands for f_v, times the
    derivative of t along the distance from the side; where F touches zero along the edge, t is of second order, and the
    factor is half the second derivative.

    Near a collapsed side rounding takes about 1e-16 over the distance from curvatures, where F touches zero over its
    square: 1e-6 at the margin, at worst.
    """

    ends: Float
    apexes: Float
    nets: Float
    rational: Float
    span: Float

    corner_margin = 1e-5
    sides: ClassVar[int] = 4
    kind: ClassVar[str] = "algebraic edge patch"
    collapsed: ClassVar[tuple[int, ...]] = (1, 3)
    term: ClassVar[QuotientTerm] = EDGE_TERM

    def __post_init__(self) -> None:
        shapes = {"ends": (2, 3), "apexes": (2, 2, 3), "nets": (2, 20), "rational": (2, 4), "span": (2,)}
        frozen_fields(self, shapes)
        for end in range(2):
            value = np.abs(self._edge_values(self.span[:, end]))
            size = np.abs(np.where(self.present[..., None], self.nets, 0.0)).max(axis=(1, 2), initial=0.0)
            # a patch that is not finite is for the caller to find
            wrong = value > AT_ENDS * size
            if wrong.any():
                patch = int(np.argmax(wrong))
                raise ValueError(
                    f"F is {value[patch]:.1e} at parameter {self.span[patch, end]:g} of the edge of patch {patch}, "
                    "which should end in a point there: let spans end at vertices and where F changes its sign"
                )

    def _arrays(self) -> dict[str, Float]:
        return {name: getattr(self, name) for name in ("ends", "apexes", "nets", "rational", "span")}

    def _edge_values(self, x: Float) -> Float:
        """F (P,) at parameters (P,) of the edges."""
        first = np.where(self.present[:, 0], 0, 1)
        net = self.nets[np.arange(len(self)), first].T[LAYERS[0]]
        values: Float = product_rows(net, bernstein_rows(3, x, 1.0 - x, 0), bernstein_rows(0, x, x, 0), 0)[0]
        return values

    def _jets(self, patch: Int, points: Float, order: int) -> Float:
        rows = ROWS[order]
        side = self._side(patch, points)
        cubics = [b[:rows] for b in self._cubics(patch, side, points)]
        t = self._roots(cubics, side, points)
        q, away = self._rays(patch, side, points)
        point = Taylor(q[:rows]) + differentiated_root(cubics, t)[:, None] * Taylor(away[:rows])
        result: Float = point.coefficients
        (collapsed,) = np.nonzero(ends_of_span(points))
        if order > 0 and len(collapsed):
            some = patch[collapsed], side[collapsed], points[collapsed]
            result[2, collapsed] = limit_direction(self._cubics(*some), self._rays(*some)[1], points[collapsed])
            result[3:, collapsed] = np.nan
        return result

    def _hits(self, patch: Int, points: Float) -> Hits:
        side = self._side(patch, points)
        t = self._roots([b[:1] for b in self._cubics(patch, side, points)], side, points)
        (x, rest), v = self._edge_parameters(patch, points), points[:, 1]
        alpha = np.stack([(1.0 - v) * t, rest * (1.0 - t), x * (1.0 - t), v * t])
        apexes, ends = self.apexes[patch, side], self.ends[patch]
        corners = np.stack([apexes[:, 0], ends[:, 0], ends[:, 1], apexes[:, 1]], axis=1)
        return Hits(corners, self.nets[patch, side].T, self.rational[patch, side].T, alpha)

    def _edge_parameters(self, patch: Int, points: Float) -> tuple[Float, Float]:
        """Return x and 1 - x (n,), both with all their digits near the ends of the edge."""
        u, (start, end) = points[:, 0], self.span[patch].T
        return (1.0 - u) * start + u * end, (1.0 - u) * (1.0 - start) + u * (1.0 - end)

    def _side(self, patch: Int, points: Float) -> Int:
        # at the ends of the span, where F is zero, the side is that of the rest of the patch
        inner = points.copy()
        inner[ends_of_span(points), 0] = 0.5

        def values(some: Int) -> Float:
            x, rest = self._edge_parameters(patch[some], inner[some])
            net = self.nets[patch[some], 0].T[LAYERS[0]]
            start: Float = product_rows(net, bernstein_rows(3, x, rest, 0), bernstein_rows(0, x, x, 0), 0)[0]
            return start

        return side_of(self._present(patch), values)

    def _cubics(self, patch: Int, side: Int, points: Float) -> list[Float]:
        """Coefficients of the shooting polynomials to second order, jets (4 of 6, n).

        b_s is a polynomial of degree 3 - s in x and s in v. The rational terms, divided by (1 - t) t^2, are
        6 v (1 - v) ((1 - x) (a_1101 (1 - v) + b_1101 v) + x (a_1011 (1 - v) + b_1011 v)): they add to b_2 a part of
        degree three in v, with coefficients 2 / 3 of theirs.
        """
        net, rational = self.nets[patch, side].T, self.rational[patch, side].T
        x, rest = self._edge_parameters(patch, points)
        v = points[:, 1]
        length = self.span[patch, 1] - self.span[patch, 0]
        along = [bernstein_rows(3 - s, x, rest, 2, length) for s in range(4)]
        across = [bernstein_rows(s, v, 1.0 - v, 2) for s in range(4)]
        cubics = [product_rows(net[LAYERS[s]], along[s], across[s]) for s in range(4)]
        cubics[2] += product_rows(rational * (2.0 / 3.0), along[2], across[3][:, 1:3])
        return cubics

    def _roots(self, cubics: list[Float], side: Int, points: Float) -> Float:
        """Parameters (n,) on the rays where they meet the surface; zero at the ends of the span, to the last bit."""
        return np.where(ends_of_span(points), 0.0, ray_roots(np.stack([b[0] for b in cubics]), side))

    def _rays(self, patch: Int, side: Int, points: Float) -> tuple[Float, Float]:
        """Jets (6, n, 3) of the starts of rays, and of the vectors from these to the points rays run to."""
        (x, rest), v = self._edge_parameters(patch, points), points[:, 1]
        ends, apexes = self.ends[patch], self.apexes[patch, side]
        q, away = np.zeros((2, 6, len(patch), 3))
        q[0] = rest[:, None] * ends[:, 0] + x[:, None] * ends[:, 1]
        q[1] = (self.span[patch, 1] - self.span[patch, 0])[:, None] * (ends[:, 1] - ends[:, 0])
        away[0] = (1.0 - v)[:, None] * apexes[:, 0] + v[:, None] * apexes[:, 1] - q[0]
        away[1], away[2] = -q[1], apexes[:, 1] - apexes[:, 0]
        return q, away


def ends_of_span(points: Float) -> Bool:
    """(n,) true for points (n, 2) on the collapsed sides."""
    ends: Bool = (points[:, 0] == 0.0) | (points[:, 0] == 1.0)
    return ends


def limit_direction(cubics: list[Float], away: Float, points: Float) -> Float:
    """Limits (n, 3) of f_v over the distance from a collapsed side, or over its square where F touches zero there."""
    b0, b1 = cubics[0], cubics[1]
    direction = away[2] - (b1[2] / b1[0])[:, None] * away[0]
    # t = -b_0 / (3 b_1) to first order in b_0, which is zero here
    inward = np.where(points[:, 0] == 0.0, 1.0, -1.0)
    first, half_second = -inward * b0[1] / (3.0 * b1[0]), -b0[3] / (6.0 * b1[0])
    factor = np.where(np.abs(first) > TANGENT * np.abs(half_second), first, half_second)
    limit: Float = factor[:, None] * direction
    return limit


def bernstein_rows(degree: int, x: Float, rest: Float, order: int, length: Float | float = 1.0) -> Float:
    """Bernstein polynomials (order + 1, degree + 1, n) at x, with rest = 1 - x, and derivatives along x / length."""
    result = np.zeros((order + 1, degree + 1, len(x)))
    for taken in range(min(order, degree) + 1):
        lower = degree - taken
        values = [math.comb(lower, i) * power(x, i) * power(rest, lower - i) for i in range(lower + 1)]
        scale = math.perm(degree, taken) * power(np.broadcast_to(length, x.shape), taken)
        for i, value in enumerate(values):
            # the difference of control points, taken over to the polynomials
            for step in range(taken + 1):
                result[taken, i + step] += (-1) ** (taken - step) * math.comb(taken, step) * scale * value
    return result


def power(x: Float, exponent: int) -> Float:
    """Powers (n,) by multiplication: equal bits for equal numbers."""
    result = np.ones(x.shape)
    for _ in range(exponent):
        result = result * x
    return result


def product_rows(net: Float, along: Float, across: Float, order: int = 2) -> Float:
    """Jets (rows, n) of tensor-product polynomials.

    Parameters
    ----------
    net
        (coefficients, n), the index along v running faster.
    along, across
        (order + 1, m + 1, n) polynomials in x and in v, with derivatives.
    order
        0, 1 or 2.
    """
    columns = across.shape[1]
    result = np.zeros((ROWS[order], along.shape[2]))
    for row, (r, s) in enumerate(PARTIALS[: ROWS[order]]):
        for place, values in enumerate(net):
            i, j = divmod(place, columns)
            result[row] += values * (along[r, i] * across[s, j])
    return result
