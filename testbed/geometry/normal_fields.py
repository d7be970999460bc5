"""Normals of polynomial and rational patches along their sides, as vector polynomials in Bernstein form.

Along a side, with the derivative T of the boundary curve and the derivative C into the patch, T x C points along the
outward normal. Both are taken from differences of control points, without the degrees for factors: only directions
matter. A rational patch has the normal of the plane through three homogeneous points w (x, 1), those of the last but
one step of the de Casteljau algorithm: w0 p1 x p2 + w1 p2 x p0 + w2 p0 x p1 with p = w x, a polynomial too (for
positive weights, its direction is the outward one).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from testbed.geometry.bernstein import index_of
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.patches import PatchBatch
from testbed.geometry.polynomials import divide, multiply, multiply_cross
from testbed.geometry.vectors import Bool, Float, Int, norm


@dataclass(frozen=True, eq=False)
class NormalFields:
    """Normals along E sides, each in a scale of its own.

    Parameters
    ----------
    normals
        (n + 1, 3, E) Bernstein coefficients of the normal, not of unit length.
    scale
        (E,) bound of the lengths of all products that a coefficient is a mean of: rounding is relative to it.
    tangents
        (m + 1, 3, E) derivative along the side, up to a positive factor; None for rational patches.
    across
        (p + 1, 3, E) derivative into the patch, up to a positive factor; None for rational patches.
    lengths
        (2, E) the lengths of these two that their own rounding is relative to: 0 where they are differences of control
        points, right to the last digit; more on pieces of a side. None for rational patches.
    """

    normals: Float
    scale: Float
    tangents: Float | None = None
    across: Float | None = None
    lengths: Float | None = None

    @classmethod
    def of_derivatives(cls, tangents: Float, across: Float, lengths: Float | None = None) -> "NormalFields":
        """Cross product of derivatives along (m + 1, 3, E) and into (p + 1, 3, E) the patches."""
        lengths = np.zeros((2, tangents.shape[-1])) if lengths is None else lengths
        (tangents, along), (across, into) = _in_unit_range(tangents, lengths[0]), _in_unit_range(across, lengths[1])
        lengths = np.stack([along, into])
        scale = _scale(_longest(tangents), _longest(across), lengths)
        return cls(multiply_cross(tangents, across), scale, tangents, across, lengths)

    @classmethod
    def of_planes(cls, points: Float, weights: Float) -> "NormalFields":
        """Normals of planes through three rational points each, (3, d, 3, E) with weights (3, d, 1, E)."""
        # about the first point: no digits are lost far from the origin
        none = np.zeros(points.shape[-1])
        points, weights = (_in_unit_range(p, none, (0, 1, 2))[0] for p in (points - points[:1, :1], weights))
        p = points * weights
        longest = [_longest(corner) for corner in p]
        first, *others = (multiply(weights[i], multiply_cross(p[i - 2], p[i - 1])) for i in range(3))
        scale = sum(np.abs(weights[i]).max(axis=(0, 1)) * longest[i - 2] * longest[i - 1] for i in range(3))
        return cls(first + others[0] + others[1], np.asarray(scale))

    def __getitem__(self, chosen: Int | Bool) -> "NormalFields":
        fields = (self.tangents, self.across, self.lengths)
        others = (None if field is None else field[..., chosen] for field in fields)
        return NormalFields(self.normals[..., chosen], self.scale[chosen], *others)

    def reversed(self) -> "NormalFields":
        """Return the same normals along the sides run the other way.

        The tangents then point the other way, and so that normals are still T x C, C points out of the patch.
        """
        return NormalFields(
            self.normals[::-1],
            self.scale,
            None if self.tangents is None else -self.tangents[::-1],
            None if self.across is None else -self.across[::-1],
            self.lengths,
        )

    def end_scale(self, end: int) -> Float:
        """(E,) what the rounding of the first (0) or the last (-1) coefficient is relative to, a single product."""
        if self.tangents is None or self.across is None or self.lengths is None:
            return self.scale
        return _scale(norm(self.tangents[end].T), norm(self.across[end].T), self.lengths)

    def halves(self) -> "NormalFields":
        """Normals along the first halves of all sides, and then along the second halves.

        Each half has a scale of its own: where a normal is short on a half, less is lost by rounding.
        """
        if self.tangents is None or self.across is None or self.lengths is None:
            # three roundings in each of n steps, of the largest coefficient; the scale stands for a hundred and more
            scale = (1.0 + len(self.normals) / 16.0) * self.scale
            return NormalFields(np.concatenate(divide(self.normals), axis=-1), np.tile(scale, 2))
        lengths = np.array(
            [
                (1.0 + len(field) / 16.0) * length + len(field) / 16.0 * _longest(field)
                for field, length in zip((self.tangents, self.across), self.lengths, strict=True)
            ]
        )
        tangents, across = (np.concatenate(divide(field), axis=-1) for field in (self.tangents, self.across))
        return NormalFields.of_derivatives(tangents, across, np.tile(lengths, 2))


def _scale(tangents: Float, across: Float, lengths: Float) -> Float:
    """Scale (E,) of the rounding in T x C from the lengths (E,) of T and C and those (2, E) that theirs is of."""
    scale: Float = tangents * across + lengths[0] * across + tangents * lengths[1]
    return scale


def _longest(vectors: Float) -> Float:
    """Length (E,) of the longest of vectors (n + 1, 3, E)."""
    longest: Float = norm(np.moveaxis(vectors, 1, -1)).max(axis=0, initial=0.0)
    return longest


def _in_unit_range(coefficients: Float, length: Float, axes: tuple[int, ...] = (0, 1)) -> tuple[Float, Float]:
    """Coefficients (..., E) times powers of two, one for each of the E, that bring the largest over the axes below one.

    Exact but for coefficients 1e300 times smaller than the largest, and products of a few neither overflow nor vanish.
    Where one is not finite all become NaN, which stays NaN without a warning. A length (E,) is scaled likewise.
    """
    largest = np.abs(coefficients).max(axis=axes, initial=0.0)
    finite = np.isfinite(largest)
    coefficients, exponent = np.where(finite, coefficients, np.nan), np.frexp(np.where(finite, largest, 1.0))[1]
    # in two steps, since the power of two itself may be no float
    half = exponent // 2
    scaled, length = (np.ldexp(np.ldexp(x, -half), half - exponent) for x in (coefficients, length))
    return scaled, length


def have_polynomial_normals(batch: PatchBatch) -> bool:
    """Whether the normals along the sides of all patches are polynomials, up to positive factors."""
    if isinstance(batch, RationalBezierTriangles):
        return bool((batch.weights > 0.0).all())
    return isinstance(batch, BezierTriangles | BezierQuads)


def along_sides(batch: PatchBatch, patches: Int, side: Int) -> NormalFields:
    """Normals along sides ``side`` (E,) of patches (E,), as each side runs, from its corner to the next.

    A patch without extent along a side or into it (degree 0) has zero for a normal.

    Parameters
    ----------
    batch
        One that :func:`have_polynomial_normals`.
    patches, side
        Sides of tensor-product patches are all even or all odd where the degrees along u and v differ.

    Raises
    ------
    TypeError
        Another kind of batch.
    """
    if isinstance(batch, BezierQuads):
        outer, inner = _quad_rows(batch, patches, side)
    elif isinstance(batch, BezierTriangles | RationalBezierTriangles):
        rows = [places[side] for places in _triangle_places(batch.degree)]
        outer, inner = (batch.control_points[patches[:, None], places] for places in rows)
    else:
        raise TypeError(f"{batch.kind} has no polynomial normals: sample them")
    if outer.shape[1] < 2 or not inner.shape[1]:
        none = np.zeros((1, 3, len(patches)))
        return NormalFields.of_derivatives(none, none)
    with np.errstate(invalid="ignore", over="ignore"):  # patches that are not finite keep their NaN
        if isinstance(batch, RationalBezierTriangles):
            points = np.stack([outer[:, :-1], outer[:, 1:], inner]).transpose(0, 2, 3, 1)
            weights = [batch.weights[patches[:, None], places] for places in rows]
            weights = [weights[0][:, :-1], weights[0][:, 1:], weights[1]]
            return NormalFields.of_planes(points, np.stack(weights).transpose(0, 2, 1)[:, :, None])
        tangents, across = np.diff(outer, axis=1), inner - outer[:, : inner.shape[1]]
        return NormalFields.of_derivatives(*(np.ascontiguousarray(d.transpose(1, 2, 0)) for d in (tangents, across)))


@cache
def _triangle_places(degree: int) -> tuple[Int, Int]:
    """Places of the control points along each side, (3, d + 1), and of those in the row inside it, (3, d)."""
    rows = []
    for inside in (0, 1):
        places = np.empty((3, degree + 1 - inside), dtype=np.int64)
        for side, r in np.ndindex(places.shape):
            exponents = [0, 0, 0]
            exponents[side], exponents[side - 2], exponents[side - 1] = degree - inside - r, r, inside
            places[side, r] = index_of((exponents[0], exponents[1], exponents[2]))
        places.flags.writeable = False
        rows.append(places)
    return rows[0], rows[1]


def _quad_rows(batch: BezierQuads, patches: Int, side: Int) -> tuple[Float, Float]:
    """Control points along sides and in the row inside, (E, n + 1, 3) each; the second empty where there is no row."""
    net = batch.control_points
    degrees = batch.degree
    along, into = degrees[int(side[0]) % 2], degrees[1 - int(side[0]) % 2]
    r = np.arange(along + 1)
    # sides 0 and 1 run up, sides 2 and 3 down; sides 0 and 3 are the first row, sides 1 and 2 the last
    running = np.where((side < 2)[:, None], r, along - r)
    rows = []
    for inside in (0, 1)[: 1 + min(into, 1)]:
        fixed = np.broadcast_to(np.where((side % 3 == 0)[:, None], inside, into - inside), running.shape)
        first, second = (fixed, running) if side[0] % 2 else (running, fixed)
        rows.append(net[patches[:, None], first, second])
    return rows[0], rows[1] if into else np.empty((len(patches), 0, 3))
