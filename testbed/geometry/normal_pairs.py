"""Two fields of normals along the same edges: cosine and sine of their angle, and where the angle is stationary.

With the normals A and B along an edge as polynomials, N = <A, B> and V = A x B, the angle is atan2(|V|, N), from 0 to
180 degrees. Where the patches share the boundary curve H, A = H' x F and B = G x H', and V = -Delta H' with
Delta = det(H', F, G), so that the angle with a sign is atan2(|H'| Delta, N); its derivative has the sign of

    Q = (s' Delta / 2 + s Delta') N - s Delta N',  s = <H', H'>,

which has degree 16 for cubic triangles. Mann 1992, section 5.3.1, has 2 N' D^2 - N (D^2)' with D = |A| |B|, of "degree
19". Corrected: that polynomial has degree 22 and is -2 Delta Q; the zeros of Delta are minima. The thesis looks at the
roots of N as well, because cos^2 is stationary there; the angle is not, it passes through 90 degrees. But where Delta
vanishes and N is negative the normals are opposite, 180 degrees.

Where the boundary curves differ (by rounding, or because the surface has gaps) the derivative of the angle has the sign
of <V, V'N - VN'>, of degree 22 for cubics.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from testbed.geometry.normal_fields import NormalFields
from testbed.geometry.polynomials import basis, combine, multiply, multiply_cross, multiply_dot, real_roots, wronskian
from testbed.geometry.vectors import Bool, Float, Int, norm

#: The relative error of an operation: half a unit in the last place.
ROUNDING = 2.0**-53
#: What a bound is enlarged by for the rounding of the few operations since its coefficients.
SLACK = 16.0 * ROUNDING
#: Half a turn rounded up: no angle between vectors is larger.
HALF_TURN = float(np.nextafter(np.pi, 4.0))
#: Angles whose rounding is above this are not taken for what they are computed as.
SHORT = 1e-7
#: Intervals between the first samples of an edge.
FIRST = 4


@dataclass(frozen=True, eq=False)
class NormalPairs:
    """The normals of two patches along E edges.

    Parameters
    ----------
    left, right
        Normals along the edges, both as the left sides run.
    cosine
        (n + 1, E) N = <A, B>.
    sine
        (n + 1, 3, E) V = A x B.
    error
        (E,) bound of the rounding in the coefficients of N, and of that in those of V as vectors.
    """

    left: NormalFields
    right: NormalFields
    cosine: Float
    sine: Float
    error: Float

    @classmethod
    def of(cls, left: NormalFields, right: NormalFields) -> Self:
        """Pair normals along the left and, the same way, along the right sides of edges."""
        with np.errstate(invalid="ignore", over="ignore"):  # not finite stays so
            cosine, sine = multiply_dot(left.normals, right.normals), multiply_cross(left.normals, right.normals)
            error = _error(len(cosine), left.scale, right.scale)
        return cls(left, right, cosine, sine, error)

    def __len__(self) -> int:
        return len(self.error)

    def __getitem__(self, chosen: Int | Bool) -> Self:
        parts = (self.left[chosen], self.right[chosen])
        return type(self)(*parts, self.cosine[:, chosen], self.sine[:, :, chosen], self.error[chosen])

    def halves(self) -> Self:
        """The first halves of all edges, and then the second halves."""
        return self.of(self.left.halves(), self.right.halves())

    @property
    def regular(self) -> Bool:
        """(E,) true where all is finite and no normal vanishes at an end."""
        # one number that is not finite makes the sum so
        with np.errstate(invalid="ignore", over="ignore"):
            regular: Bool = np.isfinite(self.cosine.sum(axis=0) + self.sine.sum(axis=(0, 1)))
        for normals in (self.left.normals, self.right.normals):
            for end in (0, -1):
                regular &= (normals[end] != 0.0).any(axis=0)
        return regular

    def angles(self, t: Float, row: Int | None = None) -> tuple[Float, Float]:
        """Angles (K,) at parameters (K,) or (1,) of rows (K,), by default all, and bounds (K,) of their rounding.

        NaN where a normal vanishes.
        """
        rows: Int | slice = slice(None) if row is None else row
        weights = basis(len(self.cosine) - 1, t)
        # the error of evaluation is below that of the coefficients, whose scale it has
        return _angles(
            combine(weights, self.sine[:, :, rows]), combine(weights, self.cosine[:, rows]), self.error[rows]
        )

    def end_angles(self, end: int) -> tuple[Float, Float]:
        """Angles (E,) at the beginning (0) or the end (-1), and bounds (E,) of their rounding."""
        error = _error(len(self.cosine), self.left.end_scale(end), self.right.end_scale(end))
        return _angles(self.sine[end], self.cosine[end], error)

    def shared(self) -> Bool:
        """(E,) true where both sides have the same derivative along the edge to the last bit."""
        one, other = self.left.tangents, self.right.tangents
        if one is None or other is None or one.shape != other.shape:
            return np.zeros(len(self), dtype=np.bool_)
        # the right tangents are those of a side that runs the other way, turned round
        same: Bool = (one == other).all(axis=(0, 1))
        return same

    def stationary_places(self) -> tuple[Int, Float]:
        """Rows (K,) and parameters (K,) between which the angle is monotone; some more than needed."""
        rows, places = [], []
        shared = self.shared()
        for some, same in ((shared, True), (~shared, False)):
            (chosen,) = np.nonzero(some)
            if not len(chosen):
                continue
            pairs = self[chosen]
            row, t = real_roots(pairs.reduced_factor() if same else pairs.general_factor())
            rows.append(chosen[row])
            places.append(t)
            (folding,) = np.nonzero(same & (pairs.cosine < 0.0).any(axis=0))
            if len(folding):
                row, t = real_roots(pairs[folding].triple_product())
                rows.append(chosen[folding][row])
                places.append(t)
        return np.concatenate(rows or [np.empty(0, np.int64)]), np.concatenate(places or [np.empty(0)])

    def triple_product(self) -> Float:
        """Delta = det(H', F, G), (m + p + q + 1, E), of patches with a common boundary curve."""
        if self.right.across is None:
            raise TypeError("rational patches have no derivatives that are polynomials: use general_factor")
        # derivatives along and into the right patches are both turned round there
        return -multiply_dot(self.left.normals, self.right.across)

    def reduced_factor(self) -> Float:
        """Q of patches with a common boundary curve: degree 5 m + 2 p + 2 q - 2 for H' of degree m, F of p, G of q.

        Written with the partial derivatives of forms in 1 - t and t, as in :func:`polynomials.wronskian`, it comes out
        in its true degree.
        """
        tangents = self.left.tangents
        if tangents is None:
            raise TypeError("rational patches have no derivatives that are polynomials: use general_factor")
        delta, s, cosine = self.triple_product(), multiply_dot(tangents, tangents), self.cosine
        m, d = len(tangents) - 1, len(delta) - 1
        if d == 0:
            return np.zeros((1, len(self)))
        rising, falling = d * multiply(s, delta[1:]), d * multiply(s, delta[:-1])
        if m:
            rising, falling = rising + m * multiply(s[1:], delta), falling + m * multiply(s[:-1], delta)
        return multiply(rising, cosine[:-1]) - multiply(falling, cosine[1:])

    def general_factor(self) -> Float:
        """<V, V'N - VN'>, (3 n - 1, E), with the sign of the derivative of the angle for any two patches."""
        return multiply_dot(self.sine, wronskian(self.sine, self.cosine[:, None]))

    def first_bound(self) -> Float:
        """Upper bounds (E,) of the angle: V / N is a mean of ratios of coefficients where those of N are positive."""
        least = self.cosine - self.error
        with np.errstate(divide="ignore", invalid="ignore"):
            bound = np.arctan(((norm(np.moveaxis(self.sine, 1, -1)) + self.error) / least).max(axis=0))
        return np.where((least > 0.0).all(axis=0), bound * (1.0 + SLACK), HALF_TURN)

    def sampled(self) -> tuple[Float, Float, Float]:
        """Largest angle (E,) of even samples, ends included, its place (E,) and rounding (E,); NaN if one is."""
        angle, rounding = self.end_angles(0)
        t = np.zeros(len(self))
        for place in np.arange(1, FIRST + 1) / FIRST:
            other, its_rounding = self.angles(np.full(1, place)) if place < 1.0 else self.end_angles(-1)
            # once NaN, always NaN
            larger = (merit(other, its_rounding) > merit(angle, rounding)) | np.isnan(other)
            angle, rounding = np.where(larger, other, angle), np.where(larger, its_rounding, rounding)
            t[larger] = place
        return angle, t, rounding


def _error(count: int, left: Float, right: Float) -> Float:
    """Bound of the rounding in N and in V with so many coefficients, from the scales of the normals' (E,)."""
    # differences, products, weights and sums: (28 + 1.5 n) sqrt(3) roundings of at most the scale each for derivatives,
    # of which rational normals have some more
    return 8.0 * (count + 15.0) * ROUNDING * left * right


def _angles(sine: Float, cosine: Float, error: Float) -> tuple[Float, Float]:
    """Angles (K,) from V (3, K) and N (K,), and their rounding from that in these (K,); NaN where both are zero."""
    length = norm(sine.T)
    angle, length = np.arctan2(length, cosine), np.hypot(length, cosine)
    with np.errstate(divide="ignore", invalid="ignore"):
        rounding = np.where(length > 4.0 * error, 4.0 * error / length, HALF_TURN) + 8.0 * ROUNDING
    return np.where(length == 0.0, np.nan, angle), rounding


def merit(angle: Float, rounding: Float) -> Float:
    """What candidates compare by: the angle, less its rounding where a normal is so short that rounding matters."""
    return np.where(rounding < SHORT, angle, angle - rounding)
