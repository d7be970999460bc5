"""Optimized boundary curves (Mann 1994, section 3): end curvatures traded against uniform end speeds.

In the plane of the chord and n0 + n1, over the unit chord, with end speeds s0, s1 along the unit tangents (Bezier legs
s / 3) and end curvatures kappa0, kappa1, the cubic minimises

    F(s0, s1) = (s0 - 1)^2 + (s1 - 1)^2 + (kappa0 - k0)^2 + (kappa1 - k1)^2    (equations 8 to 10),

    kappa0 = 2 (3 t0 x a - s1 t0 x t1) / s0^2,    kappa1 = 2 (3 a x t1 - s0 t0 x t1) / s1^2,

x the cross product in the plane. Unlike the geometric Hermite curve it always exists and has no short end tangent, and
meets the curvatures only nearly. Derivatives as in equations 11 to 14; **corrected**: the f''(1) above them has
alpha_2 for alpha_1. **Fill**: the optimiser, damped Newton from nine starts, and which minimum: the lowest one found
with speeds above zero. On contradictory data F can fall further towards a vanishing speed, where it has no minimum;
short end tangents are what this curve is there to avoid.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Bool, Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import (
    curve_from_legs,
    edge_normals,
    edge_second_forms,
    planar_coefficients,
    planar_frame,
    plane_curvatures,
)

#: Starts (s0, s1): short, uniform and long at either end.
STARTS = np.array([(s0, s1) for s0 in (0.3, 1.0, 2.5) for s1 in (0.3, 1.0, 2.5)])
#: Newton steps allowed; most starts need fewer than ten.
STEPS = 100
#: Length of the gradient by log s at which a minimum is found, against one plus the squared curvatures.
GRADIENT = 1e-12


@dataclass(frozen=True)
class Optimized(BoundaryCurve):
    """Planar cubics with end curvatures near the data's and end speeds near the chord's length."""

    name = "optimized"
    title = "Optimized"
    reference = "Mann 1994, section 3"
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS
    formula = (
        "End speeds s0, s1 least in (s0 - 1)^2 + (s1 - 1)^2 + (kappa0 - k0)^2 + (kappa1 - k1)^2 over the unit chord."
    )
    status = (
        "As printed, equations 6 to 10 and 11 to 14; corrected: an index in f''(1). Fill: the optimiser and its starts."
    )
    failures = (
        "Meets the data's curvature only nearly; on contradictory data the lowest minimum found may not be the lowest "
        "value, which a vanishing speed can approach."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the curves at the lowest minimum found, (E, 4, 3); planar curves, counted, where none was."""
        frame = planar_frame(edges)
        turn, offsets = planar_coefficients(frame)
        k = plane_curvatures(frame, edge_normals(edges), edge_second_forms(edges)) * frame.length
        speeds, converged = best_speeds(turn, offsets, k)
        d0, d1 = speeds / 3.0 * frame.length
        control_points = curve_from_legs(edges, (frame.t0, frame.t1), d0, d1)
        missing = ~converged & np.isfinite(control_points).all(axis=(1, 2))
        return control_points, {"curves not converged": int(missing.sum())} if missing.any() else {}


def best_speeds(turn: Float, offsets: Float, k: Float) -> tuple[Float, Bool]:
    """Return the speeds (2, E) at the lowest minimum found, one where none was, and whether it was found, (E,).

    Parameters
    ----------
    turn, offsets
        t0 x t1, (E,), and t0 x a, a x t1, (2, E), over the unit chord.
    k
        Curvatures asked for, times the chord's length, (2, E).
    """
    wide = [np.repeat(a[..., None, :], len(STARTS), axis=-2).reshape(*a.shape[:-1], -1) for a in (turn, offsets, k)]
    s = np.repeat(STARTS.T[:, :, None], len(turn), axis=2).reshape(2, -1)
    s, value, done = _minimise(wide[0], wide[1], wide[2], s)
    value = np.where(done, value, np.inf).reshape(len(STARTS), -1)
    # a minimum that several starts find is the same to rounding only: take the first that is within rounding
    best = np.argmax(value <= value.min(axis=0) + 1e-9, axis=0)[None]
    found = np.take_along_axis(s.reshape(2, len(STARTS), -1), best[None], axis=1)[:, 0]
    converged: Bool = np.logical_or.reduce(done.reshape(len(STARTS), -1), axis=0)
    return np.where(converged, found, 1.0), converged


def _minimise(turn: Float, offsets: Float, k: Float, s: Float) -> tuple[Float, Float, Bool]:
    """Damped Newton by log s, which keeps s > 0, from s (2, N): where it ends, F there, and whether it converged."""
    damping = np.zeros_like(turn)
    value, gradient, hessian = _derivatives(turn, offsets, k, s)
    small = GRADIENT * (1.0 + (k**2).sum(axis=0))
    result, values, done = s.copy(), value.copy(), np.zeros(turn.shape, dtype=np.bool_)
    active = np.arange(len(turn))
    for _ in range(STEPS):
        finished = np.hypot(*gradient) <= small
        if finished.any():
            ids = active[finished]
            result[:, ids], values[ids], done[ids] = s[:, finished], value[finished], True
            keep = ~finished
            active, turn, offsets, k, s = active[keep], turn[keep], offsets[:, keep], k[:, keep], s[:, keep]
            damping, small = damping[keep], small[keep]
            value, gradient, hessian = value[keep], gradient[:, keep], hessian[:, keep]
        if not len(active):
            break
        new = s * np.exp(-np.clip(_newton_step(gradient, hessian, damping), -1.0, 1.0))
        new_value, new_gradient, new_hessian = _derivatives(turn, offsets, k, new)
        better = new_value <= value
        damping = np.where(better, np.where(damping > 1e-6, damping / 8.0, 0.0), np.maximum(4.0 * damping, 1e-3))
        s = np.where(better, new, s)
        value, gradient = np.where(better, new_value, value), np.where(better, new_gradient, gradient)
        hessian = np.where(better, new_hessian, hessian)
    result[:, active], values[active] = s, value
    return result, values, done


def _newton_step(gradient: Float, hessian: Float, damping: Float) -> Float:
    """Solve for the step, (2, N), with the eigenvalues of the Hessian made positive and raised by the damping."""
    h00, h01, h11 = hessian
    middle, half, radius = (h00 + h11) / 2.0, (h00 - h11) / 2.0, np.hypot((h00 - h11) / 2.0, h01)
    floor = 1e-12 * (np.abs(middle) + radius)
    raised = damping * (np.abs(middle) + radius)
    upper = np.maximum(np.abs(middle + radius), floor) + raised
    lower = np.maximum(np.abs(middle - radius), floor) + raised
    # cosine and sine of twice the angle of the upper eigenvector
    with np.errstate(invalid="ignore"):
        c, s = np.where(radius > 0.0, np.stack([half, h01]) / radius, np.array([[1.0], [0.0]]))
    mean, difference = (1.0 / upper + 1.0 / lower) / 2.0, (1.0 / upper - 1.0 / lower) / 2.0
    return np.stack(
        [
            (mean + c * difference) * gradient[0] + s * difference * gradient[1],
            s * difference * gradient[0] + (mean - c * difference) * gradient[1],
        ]
    )


def _derivatives(turn: Float, offsets: Float, k: Float, s: Float) -> tuple[Float, Float, Float]:
    """F (N,), and by log s its gradient (2, N) and its Hessian 00, 01, 11 (3, N); equations 8 to 14."""
    (s0, s1), inverse = s, 1.0 / s
    q0, q1 = inverse**2
    c0, c1 = 2.0 * (3.0 * offsets[0] - s1 * turn) * q0, 2.0 * (3.0 * offsets[1] - s0 * turn) * q1
    r0, r1 = c0 - k[0], c1 - k[1]
    c00, c01 = -2.0 * c0 * inverse[0], -2.0 * turn * q0  # by s0, s1
    c10, c11 = -2.0 * turn * q1, -2.0 * c1 * inverse[1]
    value = (s0 - 1.0) ** 2 + (s1 - 1.0) ** 2 + r0**2 + r1**2
    gradient = 2.0 * np.stack([s0 - 1.0 + r0 * c00 + r1 * c10, s1 - 1.0 + r0 * c01 + r1 * c11])
    hessian = 2.0 * np.stack(
        [
            1.0 + c00**2 + c10**2 + 6.0 * r0 * c0 * q0,
            c00 * c01 + c10 * c11 + 4.0 * turn * (r0 * q0 * inverse[0] + r1 * q1 * inverse[1]),
            1.0 + c01**2 + c11**2 + 6.0 * r1 * c1 * q1,
        ]
    )
    gradient = s * gradient
    hessian = np.stack([s0**2, s0 * s1, s1**2]) * hessian + np.stack([gradient[0], np.zeros_like(s0), gradient[1]])
    return value, gradient, hessian
