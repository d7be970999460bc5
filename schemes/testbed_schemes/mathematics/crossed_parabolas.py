"""Positive solutions of two crossed parabolas, the equations behind every cubic geometric Hermite curve.

    a0 x + b0 y^2 = e0,    a1 y + b1 x^2 = e1

Eliminating y leaves f(x) = b0 (e1 - b1 x^2)^2 + a0 a1^2 x - e0 a1^2, a quartic without a cubic term, so its second
derivative has at most one positive zero. That isolates the zeros of f' and then of f: at most three, each in an
interval where the function is monotone, so none is missed. Where a0 and a1 are small, pairs of zeros of f merge
although only one has y > 0; there x = sqrt(e1 / b1), y = sqrt(e0 / b0) is near the solution and is a start of its own.
Newton's method on the two equations then gives both unknowns to rounding.
"""

import numpy as np

from testbed.geometry.vectors import Float

#: Newton steps on the pair; quadratic from isolated starts, the last ones only confirm.
POLISH_STEPS = 6
#: Residual of a solution against the largest term of its equation.
RESIDUAL = 1e-12


def positive_solutions(a: Float, b: Float, e: Float, least: float, most: float) -> Float:
    """Return all solutions with both unknowns between ``least`` and ``most``.

    Parameters
    ----------
    a, b, e
        (2, N) coefficients; every solution stands for itself, whatever the other columns are.
    least, most
        Bounds, 0 < least < most.

    Returns
    -------
    solutions
        (2, 4, N): x and y of up to four solutions in each column, NaN where there are fewer. The same solution may
        stand there twice.
    """
    # where a coefficient is zero some of the starts do not exist: they become NaN, and so does an equation 0 = 0
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # the solutions stay the same, and thresholds become relative
        size = np.max(np.abs([a, b, e]), axis=0)
        return _scaled_solutions(a / size, b / size, e / size, least, most)


def _scaled_solutions(a: Float, b: Float, e: Float, least: float, most: float) -> Float:
    starts = np.concatenate([_starts_by_elimination(a, b, e, least, most), _starts_without_linear_terms(b, e)], axis=1)
    x, y = _polish(a[:, None], b[:, None], e[:, None], *starts)
    inside = (x > least) & (x < most) & (y > least) & (y < most)
    terms = np.stack([a[:, None] * np.stack([x, y]), b[:, None] * np.stack([y, x]) ** 2])
    residual = np.abs(terms.sum(axis=0) - e[:, None])
    size = np.abs(terms).sum(axis=0) + np.abs(e)[:, None]
    solved = (residual <= RESIDUAL * size).all(axis=0)
    return np.where(inside & solved, np.stack([x, y]), np.nan)


def _starts_by_elimination(a: Float, b: Float, e: Float, least: float, most: float) -> Float:
    """Zeros of the quartic between the bounds and the y that belong to them, (2, 3, N); NaN where there is none."""
    zero = np.zeros_like(a[0])
    quartic = np.stack(
        [b[0] * b[1] ** 2, zero, -2.0 * b[0] * b[1] * e[1], a[0] * a[1] ** 2, b[0] * e[1] ** 2 - e[0] * a[1] ** 2]
    )
    slope = quartic[:-1] * np.array([4.0, 3.0, 2.0, 1.0])[:, None]
    bottom, top = np.full_like(zero, least), np.full_like(zero, most)
    inflection = np.clip(np.nan_to_num(np.sqrt(e[1] / (3.0 * b[1])), nan=least, posinf=most), least, most)
    below = bracketed_zero(slope, bottom, inflection)
    above = bracketed_zero(slope, inflection, top)
    # without a zero of the slope the quartic is monotone up to the interval's outer end
    first, last = np.where(np.isnan(below), bottom, below), np.where(np.isnan(above), top, above)
    ends = np.stack([bottom, first, last, top])
    repeated = np.repeat(quartic[:, None], 3, axis=1).reshape(5, -1)
    x = bracketed_zero(repeated, ends[:-1].ravel(), ends[1:].ravel()).reshape(3, -1)
    starts: Float = np.stack([x, (e[1] - b[1] * x**2) / a[1]])
    return starts


def _starts_without_linear_terms(b: Float, e: Float) -> Float:
    """Return the solution for a0 = a1 = 0, (2, 1, N)."""
    start: Float = np.sqrt(np.stack([e[1] / b[1], e[0] / b[0]]))
    return start[:, None]


def _polish(a: Float, b: Float, e: Float, x: Float, y: Float) -> tuple[Float, Float]:
    """Newton's method on both equations; a step is taken only where it lowers the residual."""

    def residuals(x: Float, y: Float) -> tuple[Float, Float]:
        return a[0] * x + b[0] * y**2 - e[0], a[1] * y + b[1] * x**2 - e[1]

    f, g = residuals(x, y)
    for _ in range(POLISH_STEPS):
        fy, gx = 2.0 * b[0] * y, 2.0 * b[1] * x
        determinant = a[0] * a[1] - fy * gx
        new_x, new_y = x - (a[1] * f - fy * g) / determinant, y - (a[0] * g - gx * f) / determinant
        new_f, new_g = residuals(new_x, new_y)
        better = np.hypot(new_f, new_g) < np.hypot(f, g)
        x, y = np.where(better, new_x, x), np.where(better, new_y, y)
        f, g = np.where(better, new_f, f), np.where(better, new_g, g)
    return x, y


def bracketed_zero(coefficients: Float, left: Float, right: Float) -> Float:
    """Zero of each polynomial in an interval where it is monotone; NaN where its signs at the ends are equal.

    Newton's method, kept inside a shrinking bracket; where a step leaves it, the geometric mean of the ends instead,
    for a zero may be of any size.

    Parameters
    ----------
    coefficients
        (n + 1, N), highest power first.
    left, right
        (N,) positive ends.
    """
    at_left, at_right = _horner(coefficients, left)[0], _horner(coefficients, right)[0]
    result = np.where(at_left == 0.0, left, np.where(at_right == 0.0, right, np.nan))
    active = np.flatnonzero(at_left * at_right < 0.0)
    low, high, rising = left[active], right[active], at_right[active] > 0.0
    c = coefficients[:, active]
    x = np.sqrt(low * high)
    for _ in range(200):
        value, slope = _horner(c, x)
        beyond = (value > 0.0) == rising
        low, high = np.where(beyond, low, x), np.where(beyond, x, high)
        step = np.where(value == 0.0, x, x - value / slope)
        new = np.where((step >= low) & (step <= high), step, np.sqrt(low * high))
        done = np.abs(new - x) <= 1e-9 * x
        if done.any():
            result[active[done]] = new[done]
            keep = ~done
            active, low, high, rising, new = active[keep], low[keep], high[keep], rising[keep], new[keep]
            c = c[:, keep]
        if not len(active):
            break
        x = new
    return result


def _horner(coefficients: Float, x: Float) -> tuple[Float, Float]:
    """Values and derivatives of polynomials (n + 1, N) at x (N,)."""
    value, slope = coefficients[0], np.zeros_like(x)
    for c in coefficients[1:]:
        slope = slope * x + value
        value = value * x + c
    return value, slope
