"""Exact surfaces in charts: feet by Newton's method in the parameters, from the nearest of tabulated samples."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from testbed.geometry.charted import Charts, triangle_fan
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.jets import Jet
from testbed.geometry.polygon_descent import Foot, descend
from testbed.geometry.vectors import Bool, Float, Int, norm

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

#: Samples near a point among which starts are chosen, and samples near a foot among which charts are looked for.
NEAR, NEAR_OTHERS = 16, 24
#: Feet this near, in steps of the samples, are the nearest.
CLOSE = 0.05
#: Starts in other parts of the surface that are as near as the nearest sample, or nearly so.
APART_STARTS = 2
#: Samples farther apart than this many lattice steps may lead to different feet.
APART = 4.0
#: Charts tried besides the one in which a foot lies on a side.
NEIGHBOURS = 7
#: Points projected at once, so that all that belongs to them stays in the processor's cache.
CHUNK = 4096
#: Boxes compared with all others at once, likewise.
BOXES = 512


@dataclass(frozen=True, eq=False)
class CurvedBoxes:
    """Boxes that together contain a surface, with bounds of its principal curvatures there.

    Parameters
    ----------
    low, high
        (B, 3) corners of the boxes.
    bound
        (B,) upper bounds of the moduli of the principal curvatures of the piece of surface in each box, rounding
        included.
    """

    low: Float
    high: Float
    bound: Float


class BoundedCharts(Charts):
    """Charts whose curvature is bounded piece by piece."""

    @abstractmethod
    def boxes(self) -> CurvedBoxes:
        """Return boxes of pieces that cover the surface, each with a true bound of the curvatures on its piece."""

    def rim(self) -> tuple[Float, Float] | None:
        """Corners (R, 3) of boxes that together contain the surface's boundary; None if nothing is known of it."""
        return None


@dataclass(frozen=True)
class ChartedSurface(ExactSurface):
    """The surface that charts cover, as far as their polygons reach.

    Parameters
    ----------
    charts
        The surface's pieces; hashable by value, for their samples are remembered.
    steps
        Lattice steps of the samples between a polygon's centre and its sides: enough for every foot to be downhill from
        the sample nearest to the point.

    Notes
    -----
    Where a surface ends, the foot of a point beyond is the nearest point of its rim: nearest, but not perpendicular.
    """

    charts: Charts
    steps: int = 12

    def locate(self, points: Float) -> Foot:
        """Charts, parameters and positions of the nearest points of the surface, chart -1 and NaN where none was found.

        Nearest to points nearer to the surface than its smallest radius of curvature; farther away a foot that is
        nearest among its neighbours, and the nearest of several.
        """
        result = Foot.none(len(points))
        known = np.flatnonzero(np.isfinite(points).all(axis=1))
        for start in range(0, len(known), CHUNK):
            chosen = known[start : start + CHUNK]
            result.put(chosen, located(self, np.ascontiguousarray(points[chosen]).tobytes()))
        return result

    def _nearest(self, points: Float) -> Foot:
        """Feet of finite points."""
        table = samples(self.charts, self.steps)
        first = table.nearest(points, 1)[:, 0]
        feet = self._from(points, first)
        # a nearer foot than one that is near would be on another sheet, too close to this one for samples to tell
        far = np.flatnonzero(~(norm(feet.points - points) < CLOSE * table.step[first]))
        self._improve(feet, points, far, table.apart(table.nearest(points[far], NEAR)))
        if len(self.charts) > 1:
            # the foot on a side may be the rim's, or the way to a neighbouring chart
            on_side = np.flatnonzero(feet.on_side)
            starts = table.in_other_charts(feet.points[on_side], feet.chart[on_side])
            self._improve(feet, points, on_side, starts)
        return feet

    def _from(self, points: Float, starts: Int) -> Foot:
        table = samples(self.charts, self.steps)
        known = table.jets[:, starts]
        return descend(self.charts, table.polygons, points, table.chart[starts], table.at[starts], known)

    def _improve(self, feet: Foot, points: Float, rows: Int, starts: Sequence[Int]) -> None:
        """Replace some rows of feet by nearer ones, if there are, found from samples (N,) each; -1 is no start."""
        for start in starts:
            tried = rows[start >= 0]
            found = self._from(points[tried], start[start >= 0])
            before, now = norm(feet.points[tried] - points[tried]), norm(found.points - points[tried])
            better = (now < before) | (np.isnan(before) & ~np.isnan(now))
            feet.put(tried[better], Foot(*(values[better] for values in vars(found).values())))

    def closest(self, points: Float) -> Float:
        """Nearest points of the surface, (N, 3); see :meth:`locate`."""
        return self.locate(points).points

    def _jets(self, points: Float, order: int) -> Jet:
        """Jets (rows, N, 3) at the places of points of the surface; NaN where the place was not found."""
        feet = self.locate(points)
        found = np.flatnonzero(feet.chart >= 0)
        known = self.charts.jets(feet.chart[found], feet.at[found], order).coefficients
        coefficients = np.full((len(known), len(points), 3), np.nan)
        coefficients[:, found] = known
        return Jet(coefficients)

    def normal(self, points: Float) -> Float:
        """Unit normals (N, 3) at points (N, 3) on the surface."""
        return self._jets(points, 1).normal

    def second_form(self, points: Float) -> Float:
        """Second fundamental forms W (N, 3, 3) at points on the surface; on a side between charts, that of one."""
        return second_form_matrix(self._jets(points, 2))

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Bounds (N,) within boxes, those of the pieces of surface whose boxes meet them; see ``ExactSurface``.

        Zero where no part of the surface is; infinite if the charts are not bounded.
        """
        if not isinstance(self.charts, BoundedCharts):
            return super().curvature_bound(low, high)
        pieces = bounded_pieces(self.charts)
        first = first_met(low, high, pieces.low, pieces.high)
        return np.where(first < 0, 0.0, pieces.bound[first])

    def may_end(self, low: Float, high: Float) -> Bool:
        """(N,) true for boxes that meet those of the surface's rim; for all boxes if its place is not known."""
        rim = bounded_rim(self.charts) if isinstance(self.charts, BoundedCharts) else None
        if rim is None:
            return super().may_end(low, high)
        met: Bool = first_met(low, high, *rim) >= 0
        return met


def first_met(low: Float, high: Float, others_low: Float, others_high: Float) -> Int:
    """First of other boxes (B, 3) that each box (N, 3) meets, (N,); -1 if it meets none."""
    first = np.full(len(low), -1)
    if not len(others_low):
        return first
    for start in range(0, len(low), BOXES):
        some = slice(start, start + BOXES)
        apart = np.zeros((len(low[some]), len(others_low)), dtype=np.bool_)
        for axis in range(3):
            apart |= low[some, axis, None] > others_high[:, axis]
            apart |= high[some, axis, None] < others_low[:, axis]
        # written so that a NaN meets everything: it is never a pass
        met = apart.argmin(axis=1)
        first[some] = np.where(apart[np.arange(len(met)), met], -1, met)
    return first


@lru_cache(maxsize=64)
def located(surface: ChartedSurface, points: bytes) -> Foot:
    """Locate finite points given by their bytes, so that normals and second forms of the same points cost no more."""
    return surface._nearest(np.frombuffer(points).reshape(-1, 3))


@lru_cache(maxsize=8)
def bounded_pieces(charts: BoundedCharts) -> CurvedBoxes:
    """Return the boxes of charts, those with the largest bounds first; remembered."""
    pieces = charts.boxes()
    bound = np.where(np.isnan(pieces.bound), np.inf, pieces.bound)
    order = np.argsort(-bound, kind="stable")
    return CurvedBoxes(pieces.low[order], pieces.high[order], bound[order])


@lru_cache(maxsize=8)
def bounded_rim(charts: BoundedCharts) -> tuple[Float, Float] | None:
    """Return the boxes of the rim, remembered."""
    return charts.rim()


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a surface in charts.

    Parameters
    ----------
    tree
        Finds the nearest samples.
    jets
        (6, M, 3) positions and derivatives.
    chart, at
        (M,) and (M, 2) charts and parameters.
    step
        (M,) bounds of the distances to the next samples in the chart.
    polygons
        (C, n, 2) domains of the charts; those with fewer than n corners repeat the last.
    """

    tree: "cKDTree"
    jets: Float
    chart: Int
    at: Float
    step: Float
    polygons: Float

    @property
    def points(self) -> Float:
        """(M, 3) places."""
        places: Float = self.jets[0]
        return places

    def nearest(self, points: Float, count: int) -> Int:
        """Samples (N, count) nearest to points, the nearest first; fewer if there are not so many."""
        _, near = self.tree.query(points, k=np.arange(1, min(count, len(self.points)) + 1))
        ids: Int = np.asarray(near, dtype=np.int64)
        return ids

    def apart(self, near: Int) -> list[Int]:
        """Second and third starts (N,) among near samples (N, k): the nearest that are far from the starts before.

        Where two feet are about as near, so are samples about both; -1 where all are together.
        """
        allowed = np.ones(near.shape, dtype=np.bool_)
        last, starts = near[:, 0], []
        for _ in range(APART_STARTS):
            beyond = APART * np.maximum(self.step[last][:, None], self.step[near])
            allowed = allowed & (norm(self.points[near] - self.points[last][:, None]) > beyond)
            one = np.where(allowed.any(axis=1), near[np.arange(len(near)), allowed.argmax(axis=1)], -1)
            starts.append(one)
            last = np.where(one < 0, last, one)
        return starts

    def in_other_charts(self, points: Float, chart: Int) -> list[Int]:
        """Starts (N,) in charts other than ``chart`` (N,), nearest first, each in another; -1 where there is none."""
        near = self.nearest(points, NEAR_OTHERS)
        of = self.chart[near]
        allowed = of != chart[:, None]
        starts = []
        for _ in range(NEIGHBOURS):
            if not allowed.any():
                break
            first = allowed.argmax(axis=1)
            rows = np.arange(len(near))
            starts.append(np.where(allowed.any(axis=1), near[rows, first], -1))
            allowed &= of != of[rows, first][:, None]
        return starts


@lru_cache(maxsize=8)
def samples(charts: Charts, steps: int) -> Samples:
    """Tabulate charts: a function of its arguments alone, remembered."""
    from scipy.spatial import cKDTree  # takes longer to import than all else here

    corners = [charts.polygon(chart) for chart in range(len(charts))]
    most = max(len(polygon) for polygon in corners)
    polygons = np.stack([polygon[np.minimum(np.arange(most), len(polygon) - 1)] for polygon in corners])
    weights = barycentric(lattice(3, steps))
    at = [np.unique(np.einsum("sk,tkx->tsx", weights, triangle_fan(one)[0]).reshape(-1, 2), axis=0) for one in corners]
    chart = np.repeat(np.arange(len(charts)), [len(one) for one in at])
    everywhere = np.concatenate(at)
    jet = charts.jets(chart, everywhere, 2)
    extent = np.ptp(polygons, axis=1)[chart] / steps
    step = extent[:, 0] * norm(jet.fu) + extent[:, 1] * norm(jet.fv)
    return Samples(cKDTree(jet.f), jet.coefficients, chart, everywhere, step, polygons)
