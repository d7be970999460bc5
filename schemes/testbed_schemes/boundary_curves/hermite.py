"""Geometric Hermite boundary curves (de Boor, Hollig and Sabin 1987; Mann 1992, sections 2.4.4 and 3.2).

A planar cubic in the plane of the chord and n0 + n1 that matches end points, tangent planes and, in its own direction,
the normal curvature of the data at both ends. With Bezier legs d0, d1 along unit tangents t0, t1 and the plane
curvatures k0, k1, all in the plane, a = p1 - p0 and x the cross product there,

    (t0 x t1) d0 = (a x t1) - 3/2 k1 d1^2,    (t0 x t1) d1 = (t0 x a) - 3/2 k0 d0^2,

which has none to three admissible solutions. On short edges all three come together at d0 = d1 = L / 3, and rounding
shows in the legs, relative to L about as 1e-15 (L k)^-4; the curve then slides along itself, its distance to the data
and its end curvatures keep their digits. Equations: as printed; **corrected** wording: d is the Bezier leg, a third
of the derivative's length, so that without a solution "the length of the chord" means a leg of L / 3.

On edges where the mesh says which curve to follow, a boundary or the edge of an S-patch, the curve starts and ends
along that one's tangents instead, and is the one in space of section 2.4.4 (see section 5.2).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Bool, Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.crossed_parabolas import positive_solutions
from testbed_schemes.mathematics.geometric_hermite import Root, check_guard, chosen_legs
from testbed_schemes.mathematics.planar_frame import (
    STRAIGHT,
    PlanarFrame,
    curve_from_legs,
    edge_normals,
    edge_second_forms,
    planar_coefficients,
    planar_frame,
    plane_curvatures,
)
from testbed_schemes.mathematics.space_hermite import space_curves


@dataclass(frozen=True)
class Hermite(BoundaryCurve):
    """Planar cubics that match the data's normal curvature at both ends.

    Parameters
    ----------
    root
        Which of several solutions to take: ``best``, the most uniform speed (least standard deviation of |C'| over its
        mean), or ``worst``, the least uniform. On a circle's arc the two non-uniform solutions are mirror images; there
        ``worst`` takes the one with the longer leg at the lower vertex id, which is the one choice here that a reversal
        of the edge changes.
    guard
        Least and greatest leg, in chords, of a solution that counts. The default leaves out the spurious ones next to
        zero and infinity only. (0.15 0.75) also leaves out those on which interpolants explode, though they stay G1; a
        fill.
    """

    root: Root = "best"
    guard: tuple[float, ...] = (1e-4, 1e4)

    name = "hermite"
    title = "Geometric Hermite"
    reference = "de Boor, Hollig and Sabin 1987; Mann 1992, sections 2.4.4 and 3.2"
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    formula = (
        "Legs d0, d1 > 0 in the plane of the chord and n0 + n1 with (t0 x t1) d0 = (a x t1) - 3/2 k1 d1^2, "
        "(t0 x t1) d1 = (t0 x a) - 3/2 k0 d0^2; k by Meusnier from II, a = p1 - p0."
    )
    status = "As printed; corrected: d is the Bezier leg. Fill: the guard."
    failures = (
        "Data whose normals and curvatures disagree have no root (19 of 30 edges of an icosahedron with normals turned "
        "by ten degrees). Short legs on long asymmetric edges make patches explode: K from -9e3 to 1.6e4 on a torus of "
        "50 points, -8 to 6 with guard=(0.15 0.75)."
    )

    def __post_init__(self) -> None:
        """Check the guard."""
        check_guard(self.name, self.guard)

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the matching curves, (E, 4, 3); curves with legs of L / 3, counted, where there is none."""
        frame = planar_frame(edges)
        legs, solved = self.legs(edges, frame)
        d0, d1 = np.where(solved, legs, 1.0 / 3.0) * frame.length
        control_points = curve_from_legs(edges, (frame.t0, frame.t1), d0, d1)
        if edges.t0 is not None and edges.t1 is not None:
            (followed,) = np.nonzero(np.isfinite(edges.t0).all(axis=1))
            own = edges[followed]
            tangents = edges.t0[followed], edges.t1[followed]
            control_points[followed], solved[followed] = space_curves(own, tangents, self.root, self.guard)
        missing = ~solved & np.isfinite(control_points).all(axis=(1, 2))
        return control_points, {"curves without a root": int(missing.sum())} if missing.any() else {}

    def legs(self, edges: EdgeData, frame: PlanarFrame) -> tuple[Float, Bool]:
        """Return d0 / L and d1 / L, (2, E), and where there is a solution, (E,)."""
        turn, offsets = planar_coefficients(frame)
        bends = 1.5 * plane_curvatures(frame, edge_normals(edges), edge_second_forms(edges)) * frame.length
        solutions = positive_solutions(np.stack([turn, turn]), bends[::-1], offsets[::-1], *self.guard)
        # every leg matches straight data
        straight = np.max(np.abs([turn, *offsets, *bends]), axis=0) <= STRAIGHT
        t0, t1 = frame.components(frame.t0).T, frame.components(frame.t1).T
        chosen = chosen_legs(solutions, t0, t1, np.array([[1.0], [0.0]]), self.root)
        legs: Float = np.where(straight, 1.0 / 3.0, chosen)
        solved: Bool = np.logical_and(*np.isfinite(legs))
        return legs, solved
