"""Patches of zero sets met by rays that start on a triangle: A-patches of faces."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.domain import CORNERS, barycentric, corner_distance
from testbed.geometry.jets import ROWS
from testbed.geometry.shooting_rays import (
    LAYERS,
    Hits,
    Shooting,
    differentiated_root,
    frozen_fields,
    ray_roots,
    side_of,
)
from testbed.geometry.simplex_bernstein import composed_jets
from testbed.geometry.taylor import Taylor
from testbed.geometry.tetrahedral import FACE_TERM, QuotientTerm, is_singular
from testbed.geometry.vectors import Float, Int

#: At a corner of a patch, a root below this is at the start of the ray.
AT_START = 1e-12
#: Values of F on a face below this, relative to its coefficients there, are zero to rounding.
ROUNDING = 1e-13
#: How far ahead F is looked at where neither its value nor its slope has a sign.
AHEAD = 1e-3
#: Directions (corners, 2, 2) of the sides that leave a corner, onward and back.
WAYS = np.stack([np.roll(CORNERS[3], -1, axis=0) - CORNERS[3], np.roll(CORNERS[3], 1, axis=0) - CORNERS[3]], axis=1)


@dataclass(frozen=True, eq=False)
class ShootingTriangles(Shooting):
    """Patches met by rays from the points of a triangle to an apex; see :class:`Shooting`.

    Parameters
    ----------
    base
        (P, 3, 3) corners of the triangle rays start from, counterclockwise seen from the positive side. F is the same
        there in both tetrahedra, and so is its gradient.
    apexes
        (P, 2, 3) apexes of the positive and of the negative side; NaN where a side has no tetrahedron.
    nets
        (P, 2, 20) coefficients of F, positive outside, on [base 0, base 1, base 2, apex].
    rational
        (P, 2, 3) the coefficient s belongs to the product of the two base coordinates other than s (equation 4.1).
    corners
        (P, 3, 3) barycentric coordinates, in the base, of the corners of the patch.

    Notes
    -----
    A point is (1 - t) q + t apex, on the positive side where F(q) <= 0, else on the negative one. Where that side has
    no tetrahedron the ray of the other is followed backwards (equation 4.5). Where rays change sides, on the curve
    F(q) = 0, the normal is continuous, derivatives of the parametrisation are not. On it, and on sides of the patch
    that lie on the surface, derivatives are those from within the patch; at a corner of the patch, those along either
    side of it.

    The rational term has no second derivatives at the corners of the base. Near these, rounding takes about 1e-16 over
    the distance from curvatures.
    """

    base: Float
    apexes: Float
    nets: Float
    rational: Float
    corners: Float

    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "algebraic triangle"
    term: ClassVar[QuotientTerm] = FACE_TERM

    def __post_init__(self) -> None:
        shapes = {"base": (3, 3), "apexes": (2, 3), "nets": (2, 20), "rational": (2, 3), "corners": (3, 3)}
        frozen_fields(self, shapes)

    def _arrays(self) -> dict[str, Float]:
        return {name: getattr(self, name) for name in ("base", "apexes", "nets", "rational", "corners")}

    def _jets(self, patch: Int, points: Float, order: int) -> Float:
        coordinates = self._coordinates(patch, points)
        side = self._side(patch, points, coordinates)
        t, result = self._along(patch, side, coordinates, order)
        both = self._present(patch).all(axis=1)
        (split,) = np.nonzero(both & (corner_distance(3, points) == 0.0) & (np.abs(t) <= AT_START))
        if len(split):
            corner = barycentric(points[split]).argmax(axis=-1)
            result[:, split] = self._at_crossing(patch[split], corner, coordinates[..., split], order)
        return result

    def _coordinates(self, patch: Int, points: Float) -> Float:
        """Jets (6, 3, n) of the barycentric coordinates in the base."""
        weights = barycentric(points)
        corners = np.moveaxis(self.corners[patch], 0, -1)
        result = np.zeros((6, 3, len(patch)))
        result[0] = weights[:, 0] * corners[0] + weights[:, 1] * corners[1] + weights[:, 2] * corners[2]
        result[1], result[2] = corners[1] - corners[0], corners[2] - corners[0]
        return result

    def _side(self, patch: Int, points: Float, coordinates: Float) -> Int:
        def values(some: Int) -> Float:
            chosen = patch[some]
            start: Float = self._start_values(chosen, np.zeros_like(chosen), coordinates[:1, :, some])[0]
            (on,) = np.nonzero(np.abs(start) <= ROUNDING * self._size(chosen))
            if len(on):
                there = some[on]
                start[on] = self._onward_values(patch[there], coordinates[..., there], 1.0 / 3.0 - points[there])
            return start

        return side_of(self._present(patch), values)

    def _size(self, patch: Int) -> Float:
        """Largest modulus (n,) of the coefficients of F on the base."""
        size: Float = np.abs(self.nets[patch, 0][:, LAYERS[0]]).max(axis=1)
        return size

    def _onward_values(self, patch: Int, coordinates: Float, direction: Float) -> Float:
        """Numbers (n,) with the sign of F next to points with F = 0 in a direction (n, 2), zero where F stays zero.

        The slope; where that is zero to rounding, as along an edge that touches the surface, the value further ahead.
        Coordinates are jets (3 or 6, 3, n).
        """
        first, allowed = np.zeros_like(patch), ROUNDING * self._size(patch)
        rows = self._start_values(patch, first, coordinates[:3])
        slope = direction[:, 0] * rows[1] + direction[:, 1] * rows[2]
        ahead = coordinates[:1] + AHEAD * (direction[:, 0] * coordinates[1:2] + direction[:, 1] * coordinates[2:3])
        value = self._start_values(patch, first, ahead)[0]
        found = np.where(np.abs(slope) > allowed, slope, value)
        return np.where(np.abs(found) > allowed, found, 0.0)

    def _start_values(self, patch: Int, side: Int, coordinates: Float) -> Float:
        """Jets (rows, n) of F on the base."""
        layer = np.ascontiguousarray(self.nets[patch, side][:, LAYERS[0]].T)[:, None]
        rows = composed_jets(3, layer, coordinates)[:, 0]
        rational = self.rational[patch, side].T
        if rational.any():
            rows += face_term(rational, coordinates)
        return rows

    def _cubics(self, patch: Int, side: Int, coordinates: Float) -> list[Float]:
        """Coefficients of the shooting polynomials, jets (4 of rows, n)."""
        net = self.nets[patch, side]
        cubics = [self._start_values(patch, side, coordinates)]
        for s in (1, 2):
            layer = np.ascontiguousarray(net[:, LAYERS[s]].T)[:, None]
            cubics.append(composed_jets(3 - s, layer, coordinates)[:, 0])
        constant = np.zeros((len(coordinates), len(patch)))
        constant[0] = net[:, LAYERS[3][0]]
        return [*cubics, constant]

    def _along(
        self, patch: Int, side: Int, coordinates: Float, order: int, at_start: bool = False
    ) -> tuple[Float, Float]:
        """Parameters (n,) on the rays to a side and jets (rows, n, 3) of the points there."""
        rows = ROWS[order]
        coordinates = coordinates[:rows]
        cubics = self._cubics(patch, side, coordinates)
        t = np.zeros(len(patch)) if at_start else ray_roots(np.stack([b[0] for b in cubics]), side)
        base = np.ascontiguousarray(np.moveaxis(self.base[patch], 0, -1))
        planes = coordinates[:, :1] * base[0] + coordinates[:, 1:2] * base[1] + coordinates[:, 2:] * base[2]
        q, root = Taylor(planes.swapaxes(1, 2)), differentiated_root(cubics, t)
        point = q + root[:, None] * (self.apexes[patch, side] - q)
        return t, point.coefficients

    def _at_crossing(self, patch: Int, corner: Int, coordinates: Float, order: int) -> Float:
        """Jets (rows, n, 3) at corners of patches with F = 0, where each side of the patch may have rays of its own.

        Second derivatives are NaN unless rays go to the same tetrahedron along both sides.
        """
        ways = WAYS[corner]
        ahead, behind = (self._onward_values(patch, coordinates, ways[:, i]) for i in range(2))
        # a side of the patch that lies on the surface says nothing: rays there have no length
        onward = np.where(np.where(ahead == 0.0, behind, ahead) <= 0.0, 0, 1)
        back = np.where(np.where(behind == 0.0, ahead, behind) <= 0.0, 0, 1)
        _, first = self._along(patch, onward, coordinates, order, at_start=True)
        _, second = self._along(patch, back, coordinates, order, at_start=True)
        result = first
        if order > 0:
            which = corner[:, None]
            fu, fv = first[1], first[2]
            gu, gv = second[1], second[2]
            along = np.choose(which, [fu, fv - fu, -fv])
            backward = np.choose(which, [gv, -gu, gu - gv])
            result[1] = np.choose(which, [along, -backward, backward - along])
            result[2] = np.choose(which, [backward, along - backward, -along])
        result[3:, onward != back] = np.nan
        return result

    def _hits(self, patch: Int, points: Float) -> Hits:
        coordinates = self._coordinates(patch, points)
        side = self._side(patch, points, coordinates)
        coordinates = coordinates[:1]
        t = ray_roots(np.stack([b[0] for b in self._cubics(patch, side, coordinates)]), side)
        alpha = np.concatenate([(1.0 - t) * coordinates[0], t[None]])
        corners = np.concatenate([self.base[patch], self.apexes[patch, side][:, None]], axis=1)
        return Hits(corners, self.nets[patch, side].T, self.rational[patch, side].T, alpha)


def face_term(rational: Float, coordinates: Float) -> Float:
    """Jets (rows, n) of the rational term of a face on its base: coefficients (3, n), coordinates as jets (rows, 3, n).

    At the corners of the base, value and first derivatives are zero, second derivatives NaN unless it is zero anyway.
    """
    value = coordinates[0]
    singular = is_singular(FACE_TERM, value)
    safe = coordinates.copy()
    safe[0][:, singular] = 1.0 / 3.0
    b0, b1, b2 = (Taylor(safe[:, i]) for i in range(3))
    m0, m1, m2 = b1 * b2, b2 * b0, b0 * b1
    c0, c1, c2 = rational
    term = 6.0 * b0 * m0 * (c0 * m0 + c1 * m1 + c2 * m2) / (m0 + m1 + m2)
    rows: Float = term.coefficients
    rows[:3, singular] = 0.0
    rows[3:, singular] = np.where((rational[:, singular] == 0.0).all(axis=0), 0.0, np.nan)
    return rows
