"""Geometric Hermite curves in space (Mann 1992, section 2.4.4): a given normal curvature at both ends, no common plane.

A cubic with Bezier legs d0, d1 along given unit tangents t0, t1 has at its ends the normal curvatures k0, k1 if, with
the unit normals n0, n1 and the chord a = p1 - p0,

    <n1, t0> d0 = <n1, a> + 3/2 k1 d1^2,    <n0, t1> d1 = <n0, a> - 3/2 k0 d0^2.

**Corrected**: the printed first equation has the other sign on its right. Tangents are for the caller to give there;
**fill**: unit projections of the chord, and k = -II(t, t) of the data in their direction. Where normals and chord are
in one plane the curve is that of `hermite`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Bool, Float, dot, quadratic_form
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.crossed_parabolas import positive_solutions
from testbed_schemes.mathematics.geometric_hermite import Root, check_guard, chosen_legs
from testbed_schemes.mathematics.planar_frame import (
    STRAIGHT,
    curve_from_legs,
    edge_normals,
    edge_second_forms,
    projected_tangents,
)


@dataclass(frozen=True)
class HermiteSpace(BoundaryCurve):
    """Space cubics along the projected chord that match the data's normal curvature at both ends.

    Parameters
    ----------
    root
        Which of several solutions to take: ``best``, the most uniform speed (least standard deviation of |C'| over its
        mean), or ``worst``, the least uniform, with the longer leg at the lower vertex id of two mirror images.
    guard
        Least and greatest leg, in chords, of a solution that counts. The default leaves out the spurious ones next to
        zero and infinity only.
    """

    root: Root = "best"
    guard: tuple[float, ...] = (1e-4, 1e4)

    name = "hermite-space"
    title = "Geometric Hermite in space"
    reference = "Mann 1992, section 2.4.4"
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    formula = (
        "Legs d0, d1 > 0 along the unit projected chord with <n1, t0> d0 = <n1, a> + 3/2 k1 d1^2, "
        "<n0, t1> d1 = <n0, a> - 3/2 k0 d0^2; k = -II(t, t), a = p1 - p0."
    )
    status = (
        "Corrected: the sign of the first equation's right side; fill: the tangents, which the thesis takes as given."
    )
    failures = (
        "Refused where a chord is parallel to a normal. Data whose normals and curvatures disagree have no root (18 of "
        "30 edges of an icosahedron with normals turned by ten degrees), nor have some long edges of a coarse torus (8 "
        "of 120). Short legs make patches lumpy: K from -300 to 180 on a torus of 50 points, -17 to 12 with "
        "guard=(0.15 0.75)."
    )

    def __post_init__(self) -> None:
        """Check the guard."""
        check_guard(self.name, self.guard)

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the matching curves, (E, 4, 3); projected curves with legs of L / 3, counted, where there is none."""
        chord = edges.p1 - edges.p0
        tangents, length = projected_tangents(chord, *edge_normals(edges))
        with np.errstate(invalid="ignore", divide="ignore"):  # no chord: NaN, and the row is refused
            along = chord / length[:, None]
        legs, solved = self._legs(edges, tangents, along, length)
        d0, d1 = np.where(solved, legs, 1.0 / 3.0) * length
        control_points = curve_from_legs(edges, tangents, d0, d1)
        missing = ~solved & np.isfinite(control_points).all(axis=(1, 2))
        return control_points, {"curves without a root": int(missing.sum())} if missing.any() else {}

    def _legs(self, edges: EdgeData, tangents: tuple[Float, Float], along: Float, length: Float) -> tuple[Float, Bool]:
        """d0 / L and d1 / L, (2, E), and where there is a solution, (E,)."""
        forms = edge_second_forms(edges)
        k = np.stack([-quadratic_form(t, W, t) for t, W in zip(tangents, forms, strict=True)])
        linear, square, constant = end_equations(tangents, edge_normals(edges), along, k * length)
        solutions = positive_solutions(linear, square, constant, *self.guard)
        # every leg matches straight data
        straight = np.max(np.abs([linear, square, constant]), axis=(0, 1)) <= STRAIGHT
        t0, t1 = tangents
        chosen = chosen_legs(solutions, t0.T, t1.T, along.T, self.root)
        legs: Float = np.where(straight, 1.0 / 3.0, chosen)
        solved: Bool = np.logical_and(*np.isfinite(legs))
        return legs, solved


def end_equations(
    tangents: tuple[Float, Float], normals: tuple[Float, Float], chord: Float, k: Float
) -> tuple[Float, Float, Float]:
    """Coefficients of linear[0] d0 + square[0] d1^2 = constant[0] and linear[1] d1 + square[1] d0^2 = constant[1].

    Parameters
    ----------
    tangents
        t0 and t1, (E, 3) unit vectors.
    normals
        n0 and n1, (E, 3).
    chord
        (E, 3).
    k
        (2, E) normal curvatures <n, C''> / |C'|^2 at the two ends.

    Returns
    -------
    linear, square, constant
        (2, E) each.
    """
    (t0, t1), (n0, n1) = tangents, normals
    linear = np.stack([dot(n1, t0), dot(n0, t1)])
    square = 1.5 * np.stack([-k[1], k[0]])
    return linear, square, np.stack([dot(n1, chord), dot(n0, chord)])
