"""Quintic Hermite curves as deviations from their chords, like the cubic ones of :mod:`mathematics.side_vertex`.

A curve is an array (..., 5, 3): its chord, its first derivatives at both ends, and its second derivatives there, all
along the curve. Complements of parameters are given, never computed as one minus. The formulas are for arrays, hence
for Taylors too.
"""

from testbed.geometry.composed import weighted_sum
from testbed.geometry.vectors import Float


def quintic_weights(t: Float, rest: Float, mu: float) -> tuple[Float, Float, Float, Float, Float]:
    """Weights (...) in the deviation of the curve from its chord, at ``t`` = 1 - ``rest``.

    Of the chord, of the first tangent and, subtracted, of the last, and of the second derivatives at the first end and
    the last. Where second derivatives have a tangential part, ``mu`` times the tangent away from the end, the weights
    of the tangents include it, and the last two are those of the remaining parts.
    """
    product = t * rest
    square = product**2
    bend0, bend1 = 0.5 * square * rest, 0.5 * square * t
    along = product * (t - rest) * (1.0 + 3.0 * product)
    first, last = product * rest**2 * (rest + 4.0 * t), product * t**2 * (t + 4.0 * rest)
    return along, first + mu * bend0, last + mu * bend1, bend0, bend1


def quintic_deviation(curve: Float, t: Float, rest: Float) -> Float:
    """How far the curve is from its chord at ``t`` = 1 - ``rest``, (..., 3)."""
    along, first, last, bend0, bend1 = quintic_weights(t, rest, 0.0)
    return combined(curve, (along, first, -last, bend0, bend1))


def quintic_derivatives(curve: Float, t: Float, rest: Float) -> tuple[Float, Float]:
    """First and second derivatives of the curve at ``t`` = 1 - ``rest``, (..., 3) each."""
    product = t * rest
    first = (
        30.0 * product**2,
        rest**2 * (rest - 2.0 * t) * (rest + 6.0 * t),
        t**2 * (t - 2.0 * rest) * (t + 6.0 * rest),
        0.5 * product * rest * (2.0 * rest - 3.0 * t),
        0.5 * product * t * (3.0 * rest - 2.0 * t),
    )
    second = (
        60.0 * product * (rest - t),
        -12.0 * product * (3.0 * rest - 2.0 * t),
        12.0 * product * (3.0 * t - 2.0 * rest),
        rest * (rest**2 - 6.0 * product + 3.0 * t**2),
        t * (t**2 - 6.0 * product + 3.0 * rest**2),
    )
    return combined(curve, first), combined(curve, second)


def combined(curve: Float, weights: tuple[Float, ...]) -> Float:
    """Sum of the rows of ``curve`` (..., n, 3), weighted (...), one after the other."""
    total: Float = weighted_sum(weights, [curve[..., row, :] for row in range(len(weights))])
    return total
