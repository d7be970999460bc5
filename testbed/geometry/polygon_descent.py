"""Nearest points of charts by Newton's method, within the convex polygons that are the charts' domains."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.charted import Charts
from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Bool, Float, Int, dot, norm

#: Newton's method takes about four steps from the nearest sample; far from the surface more.
MOST_STEPS = 100
#: After a full step below this, relative to the size of the polygon, the next error is below rounding.
LAST_STEP = 1e-8
#: No eigenvalue of the Hessian counts for less than this times the other's modulus.
SINGULAR = 1e-6
#: A step has failed when it leads away from the point however short it is made.
SHORTEST = 1e-9
#: Rounding of distances, relative to the coordinates.
ROUNDING = 1e-13


@dataclass(frozen=True, eq=False)
class Foot:
    """Nearest points on a surface in charts.

    Parameters
    ----------
    chart, at
        (N,) charts, -1 where no foot was found, and (N, 2) parameters there.
    points
        (N, 3) positions; NaN where none was found.
    on_side
        (N,) true for feet on a side of the chart's polygon.
    """

    chart: Int
    at: Float
    points: Float
    on_side: Bool

    @classmethod
    def none(cls, count: int) -> "Foot":
        """Return no feet at all."""
        at, points = np.full((count, 2), np.nan), np.full((count, 3), np.nan)
        return cls(np.full(count, -1), at, points, np.zeros(count, dtype=np.bool_))

    def put(self, rows: Int, feet: "Foot") -> None:
        """Overwrite some rows."""
        for values, new in zip(vars(self).values(), vars(feet).values(), strict=True):
            values[rows] = new


def descend(charts: Charts, polygons: Float, points: Float, chart: Int, start: Float, known: Float) -> Foot:
    """Minimise the squared distance to points over charts, downhill from parameters in their polygons.

    Each step goes to the minimum, over the polygon, of the quadratic model of half the squared distance; where the
    model is not convex its eigenvalues' moduli serve, relative to the first fundamental form, so that the
    parametrisation's scale does not matter. Steps that lead away from the point are made shorter.

    Parameters
    ----------
    charts
        The surface.
    polygons
        (C, n, 2) the charts' domains, counterclockwise; corners may be repeated.
    points
        (N, 3), finite.
    chart, start
        (N,) charts and (N, 2) parameters to start from.
    known
        (6, N, 3) jets there.
    """
    count = len(points)
    feet = Foot.none(count)
    domain, scale = polygons[chart], np.ptp(polygons, axis=1).max(axis=1)[chart]
    at, step, factor = start.copy(), np.zeros((count, 2)), np.ones(count)
    best = np.full(count, np.inf)
    active = np.arange(count)
    with np.errstate(
        all="ignore"
    ):  # far points may overflow, and where a chart is singular 0/0 is met: both end as NaN
        for rounds in range(MOST_STEPS):
            if not len(active):
                break
            trial = at[active] + factor[active, None] * step[active]
            # nothing has been evaluated before the first round but the starts
            jet = charts.jets(chart[active], trial, 2) if rounds else Jet(known)
            away = jet.f - points[active]
            distance = norm(away)
            nearer = distance <= best[active] + ROUNDING * (np.abs(points[active]).max(axis=1) + distance)
            back = active[~nearer]
            factor[back] *= 0.25
            now = active[nearer]
            at[now], best[now] = trial[nearer], np.minimum(best[now], distance[nearer])
            gradient, hessian, definite = quadratic_model(Jet(jet.coefficients[:, nearer]), away[nearer])
            target, on_side = lowest_in_polygon(at[now], gradient, hessian, domain[now])
            step[now], factor[now] = target - at[now], 1.0
            last = (definite | on_side) & (np.abs(step[now]).max(axis=1) <= LAST_STEP * scale[now])
            done = now[last]
            feet.chart[done], feet.at[done], feet.on_side[done] = chart[done], target[last], on_side[last]
            active = np.setdiff1d(active[(factor[active] > SHORTEST)], done, assume_unique=True)
        found = np.flatnonzero(feet.chart >= 0)
        feet.points[found] = charts.jets(feet.chart[found], feet.at[found], 0).f
    return feet


def quadratic_model(jet: Jet, away: Float) -> tuple[Float, Float, Bool]:
    """Gradient (N, 2) and Hessian (N, 3) as xx, xy, yy of half the squared distance, and whether it was definite.

    ``away`` (N, 3) leads from the point to the surface. In an orthonormal frame of the tangent plane the Hessian is
    I + distance W, up to the sign; its eigenvalues' moduli take their places where one is negative.
    """
    E, F, G = jet.first_form
    gradient = np.stack([dot(jet.fu, away), dot(jet.fv, away)], axis=-1)
    xx, xy, yy = dot(jet.fuu, away), dot(jet.fuv, away), dot(jet.fvv, away)
    # frame e1 = f_u / a, e2 = (f_v - b e1) / c
    a = np.sqrt(E)
    b = F / a
    c = np.sqrt(np.maximum(G - b * b, 0.0))
    p = 1.0 + xx / E
    q = (xy - b / a * xx) / (a * c)
    r = 1.0 + (yy - 2.0 * b / a * xy + (b / a) ** 2 * xx) / (c * c)
    middle, radius = 0.5 * (p + r), np.hypot(0.5 * (p - r), q)
    low, high = middle - radius, middle + radius
    floor = SINGULAR * np.maximum(np.abs(low), np.abs(high))
    definite = low > floor
    # slope M + shift I has the eigenvalues |low|, |high|, neither too near to zero
    low_modulus, high_modulus = np.maximum(np.abs(low), floor), np.maximum(np.abs(high), floor)
    slope = np.where(definite | (radius == 0.0), 1.0, (high_modulus - low_modulus) / (2.0 * radius))
    shift = np.where(definite, 0.0, low_modulus - slope * low)
    p, q, r = slope * p + shift, slope * q, slope * r + shift
    hessian = np.stack([a * a * p, a * (b * p + c * q), b * b * p + 2.0 * b * c * q + c * c * r], axis=-1)
    return gradient, hessian, definite


def lowest_in_polygon(at: Float, gradient: Float, hessian: Float, polygon: Float) -> tuple[Float, Bool]:
    """Minima (N, 2) of convex quadratic models about ``at`` over convex polygons, and whether they are on a side.

    A model is <gradient, x - at> + <x - at, hessian (x - at)> / 2, the hessian (N, 3) given as xx, xy, yy; polygons
    (N, n, 2).
    """
    xx, xy, yy = np.moveaxis(hessian, -1, 0)
    gx, gy = gradient[:, 0], gradient[:, 1]
    free = at + np.stack([xy * gy - yy * gx, xy * gx - xx * gy], axis=-1) / (xx * yy - xy * xy)[:, None]
    side = np.roll(polygon, -1, axis=1) - polygon
    across = free[:, None] - polygon
    inside = (side[..., 0] * across[..., 1] - side[..., 1] * across[..., 0] >= 0.0).all(axis=1)
    on_side = ~inside
    if not on_side.any():
        return free, on_side
    start, along = polygon[on_side] - at[on_side, None], side[on_side]
    slope = gradient[on_side, None]
    bending = hessian[on_side, None]
    downward = dot(slope, along) + applied(bending, start, along)
    upward = applied(bending, along, along)
    # a repeated corner is a side of no length
    t = np.where(upward > 0.0, np.clip(-downward / np.where(upward > 0.0, upward, 1.0), 0.0, 1.0), 0.0)
    offset = start + t[..., None] * along
    value = dot(slope, offset) + 0.5 * applied(bending, offset, offset)
    best = value.argmin(axis=1)
    rows = np.arange(len(best))
    free[on_side] = polygon[on_side][rows, best] + t[rows, best, None] * along[rows, best]
    return free, on_side


def applied(form: Float, x: Float, y: Float) -> Float:
    """Bilinear forms (..., 3) given as xx, xy, yy of vectors (..., 2)."""
    mixed = x[..., 0] * y[..., 1] + x[..., 1] * y[..., 0]
    result: Float = form[..., 0] * x[..., 0] * y[..., 0] + form[..., 1] * mixed + form[..., 2] * x[..., 1] * y[..., 1]
    return result
