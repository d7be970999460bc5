"""The zero set of a polynomial as an exact surface: projection, closest points, bounds of its curvature."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm, unit
from testbed_datasets.polynomial import Evaluated, PolynomialJet
from testbed_datasets.polynomial_boxes import bounds
from testbed_datasets.polynomial_zeros import Boxes, occupied

if TYPE_CHECKING:
    from scipy.spatial import KDTree

#: Newton's method along the gradient has converged after about five steps near the surface.
PROJECTION_STEPS: Final = 60
#: Newton's method along the surface takes about five steps from a near sample, more about centres of curvature.
MOST_STEPS: Final = 100
#: After a step below this, relative to the box, the next error is below rounding.
LAST_STEP: Final = 1e-9
#: Samples looked at for each point, and how many other starts at most are taken among them.
NEAREST, MORE_STARTS = 24, 3
#: Points projected at once, so that all that belongs to them stays in the processor's cache.
CHUNK: Final = 4096
#: A Hessian is relied on if the ratio of its eigenvalues is above the first; else no eigenvalue's modulus is taken for
#: less than the second times the other's.
UNRELIABLE, SINGULAR = 1e-10, 1e-6

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class AlgebraicSurface(PolynomialLevelSet):
    """The zero set of a polynomial, normals along its gradient; regular in a box, and taken to go on beyond it.

    Parameters
    ----------
    evaluated
        The polynomial.
    low, high
        Corners of the box of interest, in which closest points are sought; they may lie outside it near its sides.
    """

    evaluated: Evaluated
    low: Corner
    high: Corner

    @cached_property
    def polynomial(self) -> Trivariate:
        """The polynomial of x, y, z over its largest coefficient, for guaranteed distances."""
        terms = self.evaluated.polynomial.terms
        largest = max(abs(value) for _, value in terms)
        return Trivariate(tuple((powers, float(value / largest)) for powers, value in terms))

    @property
    def size(self) -> float:
        """Length of the box's diagonal."""
        return float(norm(np.array(self.high) - np.array(self.low)))

    def gradient(self, points: Float) -> Float:
        """Gradients of the polynomial over its largest coefficient in the box, (N, 3)."""
        return self.evaluated.jets(points).gradient

    def hessian(self, points: Float) -> Float:
        """Second derivatives of the polynomial over its largest coefficient in the box, (N, 3, 3)."""
        return self.evaluated.jets(points).hessian

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the moduli of the principal curvatures within boxes (N, 3); 0 where there is none."""
        over = bounds(self.evaluated, low, high)
        return np.where(over.may_vanish, over.curvature, 0.0)

    @cached_property
    def boxes(self) -> Boxes:
        """Small boxes that cover the surface in the box of interest; none where there is no surface."""
        return occupied(self.evaluated, np.array(self.low), np.array(self.high))

    @cached_property
    def samples(self) -> Float:
        """Points (S, 3) of the surface near the centres of ``boxes``."""
        feet = self.projected(self.boxes.centre)
        reach = 2.0 * norm(self.boxes.high - self.boxes.low)
        near: Bool = norm(feet - self.boxes.centre) <= reach  # NaN is not near
        return feet[near]

    @cached_property
    def spacing(self) -> float:
        """How far a point of the surface in the box is from the nearest sample, about."""
        return float(norm(self.boxes.high - self.boxes.low).max(initial=0.0))

    @cached_property
    def _tree(self) -> "KDTree":
        from scipy.spatial import KDTree  # slow to import: only where closest points are sought

        return KDTree(self.samples)

    def projected(self, points: Float, held: Bool | None = None) -> Float:
        """Points (N, 3) moved along the gradient onto the surface, p <- p - P g / |g|^2; NaN where that fails.

        Parameters
        ----------
        points
            (N, 3) points near the surface.
        held
            (N, 3) coordinates that stay as they are, or None; g is then the gradient along the others.
        """
        feet = np.full(points.shape, np.nan)
        active = np.flatnonzero(np.isfinite(points).all(axis=1))
        p, before = points[active], np.full(len(active), np.inf)
        with np.errstate(all="ignore"):  # far points may overflow: they end as NaN, as promised
            for _ in range(PROJECTION_STEPS):
                if not len(active):
                    break
                jet = self.evaluated.jets(p)
                gradient = jet.gradient if held is None else np.where(held[active], 0.0, jet.gradient)
                step = gradient * (jet.value / dot(gradient, gradient))[:, None]
                length = norm(step)
                p = p - step * np.minimum(1.0, 0.1 * self.size / length)[:, None]
                # the error is squared with each step: it ends where rounding keeps steps from falling
                done = (length <= 1e-15 * self.size) | ((length <= LAST_STEP * self.size) & ~(length < 0.5 * before))
                feet[active[done]] = p[done]
                go_on = ~done & np.isfinite(p).all(axis=1)
                active, p, before = active[go_on], p[go_on], length[go_on]
        return feet

    def middles(self, start: Float, end: Float, boundary: Bool) -> Float:
        """Points (E, 3) of the surface, by projection of the chords' middles along the gradient.

        Those of boundary edges stay on the side of the box that both ends lie on.
        """
        held = self.on_sides(start) & self.on_sides(end) & (start == end) & boundary[:, None]
        return self.projected(0.5 * (start + end), held)

    def on_sides(self, points: Float) -> Bool:
        """(N, 3) true for coordinates in which points (N, 3) lie on a side of the box."""
        there: Bool = (points == self.low) | (points == self.high)
        return there

    def sample(self, points: Float, faces: Int, centres: Float | None = None) -> HermiteMesh:
        """Return the mesh of points (V, 3) on the surface with its data, and tangents of its boundary.

        On a side of the box the boundary runs along e x n, where e is perpendicular to that side.
        """
        mesh = super().sample(points, faces, centres)
        on_boundary = mesh.boundary_edges[mesh.face_edges]
        if not on_boundary.any():
            return mesh
        face, side = np.nonzero(on_boundary)
        ends = np.stack([mesh.faces[face, side], mesh.faces[face, (side + 1) % 3]], axis=-1)
        start, end = np.moveaxis(mesh.points[ends], 1, 0)
        shared = self.on_sides(start) & self.on_sides(end) & (start == end)
        perpendicular = np.where(shared.any(axis=1), np.eye(3)[shared.argmax(axis=1)].T, np.nan).T
        along = unit(cross(perpendicular[:, None], self.normal(mesh.points[ends].reshape(-1, 3)).reshape(-1, 2, 3)))
        ahead = dot(along, (end - start)[:, None]) > 0.0
        along[~np.isfinite(along).all(axis=(1, 2))] = np.nan  # the surface touches the side at an end
        tangents = np.full((*mesh.faces.shape, 2, 3), np.nan)
        tangents[face, side] = np.where(ahead[..., None], along, -along)
        data = replace(mesh.face_data, side_tangents=tangents)
        return HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms, face_data=data)

    def closest(self, points: Float) -> Float:
        """Nearest points of the surface, (N, 3), as far as samples in the box tell; NaN where none was found.

        Newton's method along the surface from the nearest sample, and where other samples are about as near as the foot
        but elsewhere, from these too. The nearest point for all points nearer to the surface than its smallest radius
        of curvature and half the distance of its sheets; farther away a foot that is nearest among its neighbours, and
        by no more than the distance of samples farther than the nearest.
        """
        chunks = range(0, len(points), CHUNK)
        return np.concatenate([np.empty((0, 3)), *(self._feet(points[start : start + CHUNK]) for start in chunks)])

    def _feet(self, points: Float) -> Float:
        feet = np.full(points.shape, np.nan)
        known = np.flatnonzero((np.abs(points) <= 1e3 * (self.size + np.abs(np.array(self.low)).max())).all(axis=1))
        if not len(known) or not len(self.samples):
            return feet
        p = points[known]
        found, ids = self._tree.query(p, k=np.arange(1, 1 + min(NEAREST, len(self.samples))))
        distances, starts = np.array(found), self.samples[ids]
        best = self._descended(p, starts[:, 0])
        for _ in range(MORE_STARTS):
            distance = np.where(np.isnan(best).any(axis=1), np.inf, norm(best - p))
            # a sample near the foot leads to the same foot
            elsewhere = ~(norm(starts - best[:, None]) <= 3.0 * self.spacing)
            promising = elsewhere & (distances <= distance[:, None] + self.spacing)
            again = np.flatnonzero(promising.any(axis=1))
            if not len(again):
                break
            first = promising[again].argmax(axis=1)
            other = self._descended(p[again], starts[again, first])
            distances[again, first] = np.inf
            nearer = norm(other - p[again]) < distance[again]
            best[again[nearer]] = other[nearer]
        feet[known] = best
        return feet

    def _descended(self, p: Float, start: Float) -> Float:
        """Feet (N, 3) reached from starts (N, 3) on the surface by minimising the distance from points (N, 3)."""
        feet = np.full(p.shape, np.nan)
        x, active = start.copy(), np.arange(len(p))
        with np.errstate(all="ignore"):  # steps that overflow are not taken
            for _ in range(MOST_STEPS):
                if not len(active):
                    break
                step, definite = self._newton_step(p[active], x[active])
                moved, whole = self._retracted(p[active], x[active], step)
                x[active] = moved
                last = definite & whole & (norm(step) <= LAST_STEP * self.size)
                feet[active[last]] = moved[last]
                active = active[~last & np.isfinite(step).all(axis=1)]
            found = np.flatnonzero(np.isfinite(feet).all(axis=1))
            feet[found] = self._polished(p[found], feet[found])
        return feet

    def _newton_step(self, p: Float, x: Float) -> tuple[Float, Bool]:
        """Steps (N, 3) in the tangent planes at x, and whether the second derivative of the distance is definite there.

        Along the surface half the squared distance has the derivative T (x - p) and the second derivative
        T (I + m H) T, m = -<x - p, g>/|g|^2. Where that is not positive definite, its eigenvalues' moduli serve, and at
        a saddle the direction of its negative eigenvalue: the step still leads downhill.
        """
        jet = self.evaluated.jets(x)
        g = jet.gradient
        first, second = tangent_frame(unit(g))
        away = x - p
        m = -dot(away, g) / dot(g, g)
        a = 1.0 + m * _form(first, jet, first)
        b = m * _form(first, jet, second)
        c = 1.0 + m * _form(second, jet, second)
        slope_first, slope_second = dot(away, first), dot(away, second)
        middle, radius = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
        low, high = middle - radius, middle + radius
        flat = np.hypot(slope_first, slope_second) <= 1e-13 * self.size
        size = np.maximum(np.maximum(np.abs(low), np.abs(high)), 1.0)
        regular = low > UNRELIABLE * size
        definite = regular | (flat & (low >= -UNRELIABLE * size))
        floor = SINGULAR * size
        low_modulus, high_modulus = np.maximum(np.abs(low), floor), np.maximum(np.abs(high), floor)
        # |H| = slope H + shift I has the eigenvalues |low|, |high|, neither too near to zero
        slope = np.where(regular | (radius == 0.0), 1.0, (high_modulus - low_modulus) / (2.0 * radius))
        shift = np.where(regular, 0.0, low_modulus - slope * low)
        A, B, C = slope * a + shift, slope * b, slope * c + shift
        determinant = A * C - B * B
        along_first = (B * slope_second - C * slope_first) / determinant
        along_second = (B * slope_first - A * slope_second) / determinant
        # off a saddle: (b, low - a) and (low - c, b) are multiples of the eigenvector of the lower eigenvalue
        saddle = flat & ~definite
        longer = np.abs(low - a) > np.abs(low - c)
        off_first, off_second = np.where(longer, b, low - c), np.where(longer, low - a, b)
        away_by = 0.25 * self.spacing / np.maximum(np.hypot(off_first, off_second), 1e-300)
        along_first = np.where(saddle, off_first * away_by, along_first)
        along_second = np.where(saddle, off_second * away_by, along_second)
        still = definite & flat & ~regular  # centres of curvature: any direction is as good as none
        step = along_first[:, None] * first + along_second[:, None] * second
        return np.where(still[:, None], 0.0, step), definite

    def _retracted(self, p: Float, x: Float, step: Float) -> tuple[Float, Bool]:
        """Points (N, 3) on the surface near x + f step, f = 1, 1/4, 1/16... that are not farther from p than x.

        Also whether f is 1. Steps are not longer than a few samples are apart.
        """
        step = step * np.minimum(1.0, 4.0 * self.spacing / np.maximum(norm(step), 1e-300))[:, None]
        now = norm(x - p)
        allowed = now + 1e-13 * (self.size + now)
        factor = np.ones(len(p))
        moved = self.projected(x + step)
        for _ in range(20):
            # far projections are other sheets
            bad = ~((norm(moved - p) <= allowed) & (norm(moved - x) <= 2.0 * factor * norm(step) + 1e-12 * self.size))
            if not bad.any():
                break
            factor[bad] *= 0.25
            moved[bad] = self.projected(x[bad] + factor[bad, None] * step[bad])
        lost = ~np.isfinite(moved).all(axis=1)
        moved[lost] = x[lost]
        return moved, factor == 1.0

    def _polished(self, p: Float, x: Float) -> Float:
        """Feet after two steps more, with which their errors are those of rounding."""
        for _ in range(2):
            step, _ = self._newton_step(p, x)
            short = norm(step) <= 1e-6 * self.size
            x = np.where(short[:, None], self.projected(x + np.where(short[:, None], step, 0.0)), x)
        return x


def _form(u: Float, jet: PolynomialJet, v: Float) -> Float:
    """Scalars u . H v (N,), summed in a fixed order."""
    return dot(u, np.stack([dot(jet.hessian[:, row], v) for row in range(3)], axis=-1))


def tangent_frame(n: Float) -> tuple[Float, Float]:
    """Two unit vectors (N, 3), (N, 3) perpendicular to unit vectors (N, 3) and to each other."""
    axis: Int = np.abs(n).argmin(axis=1)
    first = unit(cross(n, np.eye(3)[axis]))
    return first, cross(n, first)
