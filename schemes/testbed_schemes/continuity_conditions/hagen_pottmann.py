"""Curvature continuity along a curve: a field of tangent planes and one of second fundamental forms (G2).

Two patches that interpolate both fields along their common boundary join with a common curvature. The fields depend on
the boundary curve X(s) and the data at its ends alone, so no patch reads what is across the edge (Mann 1992, section
2.3.2, after Hagen and Pottmann 1989).

The tangent plane at s is spanned by X'(s) and a cross-boundary vector D(s). A second fundamental form is known once it
is known in three directions, and two of them follow from what is there already:

    II(X', X') = -<X'', n>,   II(X', D) = -<D', n>   (from <D, n> = 0, which makes it <n', D>),   n along X' x D.

For the first two to agree with the data at the ends, D' has to be given there, which takes a cubic D:

    D(0) = N_0 x X'(0) / |N_0 x X'(0)|,   <D'(0), N_0> = -II_0(X'(0), D(0)),   and the same at 1.

Formulas: the source gives this in words. **Fills**: the unit length and the direction of D at the ends, D' along N
there, and the third value: II(D, D) = ((1 - s) II_0(D, D) + s II_1(D, D)) <D, D>, with the unit vectors D of the ends.
Hagen and Pottmann blend conjugate directions to find a third direction, which has special cases; this one has none.

All functions take arrays (..., 3), and so Taylors, where they are evaluated at a parameter. The sign of II is the
project's: positive where the surface bends away from its normal.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float, quadratic_form
from testbed_schemes.continuity_conditions.chiyokura_kimura import conormal


@dataclass(frozen=True, slots=True)
class EndField:
    """The cross-boundary field at an end of the curve.

    Parameters
    ----------
    across
        (..., 3) the unit vector D in the tangent plane, perpendicular to the curve.
    turn
        (..., 3) its derivative D' along the curve.
    curvature
        (...) II(D, D), the normal curvature across the curve.
    """

    across: Float
    turn: Float
    curvature: Float


def end_field(normal: Float, tangent: Float, form: Float) -> EndField:
    """Return the cross-boundary field at an end from the data there.

    Reversing the curve, with ``tangent`` negated, negates D and keeps D' and II(D, D), bit for bit: it is the same
    field.

    Parameters
    ----------
    normal
        (..., 3) unit normal.
    tangent
        (..., 3) X', as the curve runs; NaN comes out where it vanishes.
    form
        (..., 3, 3) second fundamental form.
    """
    across = conormal(normal, tangent)
    turn = -quadratic_form(tangent, form, across)[..., None] * normal
    return EndField(across, turn, quadratic_form(across, form, across))


def cross_field(start: EndField, end: EndField, s: Float, rest: Float) -> tuple[Float, Float]:
    """Return the cubic D and its derivative D', (..., 3) each, at ``s`` = 1 - ``rest``, (...)."""
    s, rest = s[..., None], rest[..., None]
    # the derivatives' own difference, not that of two points which nearly agree
    change = end.across - start.across
    across = (
        start.across + (s * s * (3.0 * rest + s)) * change + (s * rest * rest) * start.turn - (s * s * rest) * end.turn
    )
    turn = (6.0 * s * rest) * change + (rest * (rest - 2.0 * s)) * start.turn + (s * (s - 2.0 * rest)) * end.turn
    return across, turn


@dataclass(frozen=True, slots=True)
class CurvatureField:
    """Tangent plane and second fundamental form at points of a curve.

    Parameters
    ----------
    tangent, bend
        (..., 3) X' and X''.
    across, turn
        (..., 3) D and D'.
    curvature
        (...) II(D, D) / <D, D>.
    normal
        (..., 3) X' x D, along n; not of length one.
    square
        (...) its square.
    """

    tangent: Float
    bend: Float
    across: Float
    turn: Float
    curvature: Float
    normal: Float
    square: Float

    def second_form(self, direction: Float) -> Float:
        """II(a, a), (...), for the parts a in the tangent plane of directions (..., 3)."""
        E, F, G = (
            np.vecdot(a, b)
            for a, b in ((self.tangent, self.tangent), (self.tangent, self.across), (self.across, self.across))
        )
        # a = u X' + v D by the Gram matrix, whose determinant is the normal's square
        along, off = np.vecdot(direction, self.tangent), np.vecdot(direction, self.across)
        u, v = (along * G - off * F) / self.square, (off * E - along * F) / self.square
        normal_part = u * (u * np.vecdot(self.bend, self.normal) + 2.0 * v * np.vecdot(self.turn, self.normal))
        form: Float = v * v * self.curvature * G - normal_part / np.sqrt(self.square)
        return form


def curvature_field(
    tangent: Float, bend: Float, start: EndField, end: EndField, s: Float, rest: Float
) -> CurvatureField:
    """Return the fields at ``s`` = 1 - ``rest`` (...) of a curve with derivatives X' and X'' (..., 3) there."""
    across, turn = cross_field(start, end, s, rest)
    normal: Float = np.cross(tangent, across)
    curvature = rest * start.curvature + s * end.curvature
    return CurvatureField(tangent, bend, across, turn, curvature, normal, np.vecdot(normal, normal))
