"""Cubics in space with given end tangents that match given normal curvatures (Mann 1992, section 2.4.4).

A cubic with Bezier legs d0, d1 along given unit tangents t0, t1 has at its ends the normal curvatures k0, k1 if, with
the unit normals n0, n1 and the chord a = p1 - p0,

    <n1, t0> d0 = <n1, a> + 3/2 k1 d1^2,    <n0, t1> d1 = <n0, a> - 3/2 k0 d0^2.

**Corrected**: the printed first equation has the other sign on its right.
"""

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Bool, Float, dot, norm, quadratic_form
from testbed_schemes.mathematics.crossed_parabolas import positive_solutions
from testbed_schemes.mathematics.geometric_hermite import Root, chosen_legs
from testbed_schemes.mathematics.planar_frame import STRAIGHT, curve_from_legs, edge_normals, edge_second_forms


def space_curves(
    edges: EdgeData, tangents: tuple[Float, Float], root: Root, guard: tuple[float, ...]
) -> tuple[Float, Bool]:
    """Cubics along given tangents whose normal curvature at both ends is that of the data, k = -II(t, t).

    Parameters
    ----------
    edges
        E edges with normals and second forms.
    tangents
        t0 and t1, (E, 3) unit vectors of the tangent planes.
    root, guard
        Which of several solutions; least and greatest leg, in chords, of one that counts.

    Returns
    -------
    control_points
        (E, 4, 3); legs of L / 3 where there is no solution.
    solved
        (E,) true where there is one.
    """
    chord = edges.p1 - edges.p0
    length = norm(chord)
    with np.errstate(invalid="ignore", divide="ignore"):  # no chord: NaN, and the row is refused
        along = chord / length[:, None]
    k = np.stack([-quadratic_form(t, W, t) for t, W in zip(tangents, edge_second_forms(edges), strict=True)])
    linear, square, constant = end_equations(tangents, edge_normals(edges), along, k * length)
    solutions = positive_solutions(linear, square, constant, *guard)
    # every leg matches straight data
    straight = np.max(np.abs([linear, square, constant]), axis=(0, 1)) <= STRAIGHT
    t0, t1 = tangents
    chosen = chosen_legs(solutions, t0.T, t1.T, along.T, root)
    legs: Float = np.where(straight, 1.0 / 3.0, chosen)
    solved: Bool = np.logical_and(*np.isfinite(legs))
    d0, d1 = np.where(solved, legs, 1.0 / 3.0) * length
    return curve_from_legs(edges, tangents, d0, d1), solved


def followed_tangents(edges: EdgeData, otherwise: tuple[Float, Float]) -> tuple[Float, Float]:
    """Tangents (E, 3) each of the curves that the surface has to follow, and others where it has none to follow."""
    if edges.t0 is None or edges.t1 is None:
        return otherwise
    given = np.isfinite(edges.t0).all(axis=1, keepdims=True)
    t0, t1 = (np.where(given, t, other) for t, other in zip((edges.t0, edges.t1), otherwise, strict=True))
    return t0, t1


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
