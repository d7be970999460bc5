"""Rays that meet the zero set of a function on tetrahedra: what A-patches over triangles and edges have in common.

A ray from a point q to the apex of a tetrahedron meets F = 0 where a cubic in the ray's parameter is zero, the shooting
polynomial (Xu, Huang and Bajaj 2001, equations 4.8 and 4.9). Its coefficients are known with their derivatives along
(u, v), and so is its root, by implicit differentiation.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from testbed.geometry.cubic_roots import bernstein_slope, extended_roots, first_roots
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.patches import PatchBatch
from testbed.geometry.simplex_bernstein import simplex_multi_indices
from testbed.geometry.taylor import Taylor
from testbed.geometry.tetrahedral import (
    QuotientTerm,
    implicit_curvatures,
    in_space,
    rational_cubic,
)
from testbed.geometry.vectors import Bool, Float, Int, as_float, stack_components

#: Points evaluated together: a few nets' worth of numbers stays in the cache.
CHUNK = 4000
#: Places of the control points with s_3 = s in the net of a tetrahedron; they are in the order of Bezier triangles.
LAYERS = tuple(np.flatnonzero(simplex_multi_indices(4, 3)[:, 3] == s) for s in range(4))

# a ray without a root, a root that is double, a patch that is not finite: NaN, which every measure reports
_expected = np.errstate(invalid="ignore", divide="ignore", over="ignore")


@dataclass(frozen=True)
class Hits:
    """Where rays meet the surface: the tetrahedra (corners, nets, rational terms) and coordinates there."""

    corners: Float
    nets: Float
    rational: Float
    alpha: Float


class Shooting(PatchBatch):
    """What patches met by rays have in common: tetrahedra on the positive and on the negative side; a dataclass.

    Attributes
    ----------
    apexes
        (P, 2, ..., 3) where rays of the positive and of the negative side end; NaN where a side has no tetrahedron.
    nets
        (P, 2, 20) Bernstein coefficients of F, positive outside, on the tetrahedra; the order is that of
        ``simplex_multi_indices(4, 3)``.
    rational
        (P, 2, 3 | 4) coefficients of the rational terms.
    """

    apexes: Float
    nets: Float
    rational: Float
    corner_margin = 1e-6

    term: ClassVar[QuotientTerm]

    def __len__(self) -> int:
        return len(self.nets)

    @property
    def present(self) -> Bool:
        """(P, 2) true where a side has a tetrahedron."""
        return self._present(slice(None))

    def _present(self, patch: Int | slice) -> Bool:
        """Sides (n, 2) that patches have a tetrahedron on."""
        apexes = self.apexes[patch]
        there: Bool = np.asarray(~np.isnan(apexes).any(axis=tuple(range(2, apexes.ndim))))
        return there

    def take(self, patches: Int | slice) -> Self:
        """Return the batch of the chosen patches, in the order chosen; repeats allowed."""
        return type(self)(**{name: values[patches] for name, values in self._arrays().items()})

    @property
    def finite(self) -> Bool:
        """(P,) true where every number that defines the patch is finite, on one side at least."""
        count, present = len(self), self.present
        result: Bool = np.asarray(present.any(axis=1))
        for name, values in self._arrays().items():
            if name in ("apexes", "nets", "rational"):
                there = np.isfinite(values).reshape(count, 2, -1).all(axis=2)
                result = result & (there | ~present).all(axis=1)
            else:
                result = result & np.isfinite(values).reshape(count, -1).all(axis=1)
        return result

    @abstractmethod
    def _arrays(self) -> dict[str, Float]:
        """Return the fields by name, patch axis first."""

    @_expected
    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at domain points (S, 2) or (P, S, 2), by implicit differentiation of the shooting polynomial."""
        return Jet(self._in_chunks(at, (ROWS[order],), lambda patch, points: self._jets(patch, points, order)))

    @_expected
    def gradient(self, at: Float) -> Float:
        """Gradients of F in space (P, S, 3) at the points of the surface over ``at``; outward, of any length."""
        return self._in_chunks(at, (), lambda patch, points: self._implicit(patch, points)[0])

    @_expected
    def curvatures(self, at: Float) -> tuple[Float, Float]:
        """Gaussian curvature and mean of the principal curvatures, (P, S) each, from the Hessian of F.

        Independent of the jets but for the roots. NaN where F has no second derivatives.
        """

        def both(patch: Int, points: Float) -> Float:
            gauss, mean = implicit_curvatures(*self._implicit(patch, points))
            return stack_components(gauss, mean, gauss)

        values = self._in_chunks(at, (), both)
        return values[..., 0], values[..., 1]

    def _in_chunks(self, at: Float, rows: tuple[int, ...], compute: Callable[[Int, Float], Float]) -> Float:
        """Return (*rows, P, S, 3) from a function of patches (n,) and points (n, 2) that gives (*rows, n, 3)."""
        samples = at.shape[-2]
        result = np.empty((*rows, len(self) * samples, 3))
        for start in range(0, len(self) * samples, CHUNK):
            stop = min(start + CHUNK, len(self) * samples)
            patch, sample = np.divmod(np.arange(start, stop), samples)
            result[..., start:stop, :] = compute(patch, at[sample] if at.ndim == 2 else at[patch, sample])
        return result.reshape(*rows, len(self), samples, 3)

    def _implicit(self, patch: Int, points: Float) -> tuple[Float, Float]:
        hits = self._hits(patch, points)
        return in_space(rational_cubic(hits.nets, self.term, hits.rational, hits.alpha), hits.corners)

    @abstractmethod
    def _jets(self, patch: Int, points: Float, order: int) -> Float:
        """Jets (rows, n, 3) of patches (n,) at points (n, 2)."""

    @abstractmethod
    def _hits(self, patch: Int, points: Float) -> Hits:
        """Where the rays of patches (n,) at points (n, 2) meet the surface."""


def side_of(present: Bool, start_values: Callable[[Int], Float]) -> Int:
    """Side (n,) to shoot to, 0 positive or 1 negative, of rays with tetrahedra on the sides ``present`` (n, 2).

    The positive side where F <= 0 at the start; the one there is where there is only one. Values of F are asked for
    only where they count: ``start_values`` gives them for some of the rays.
    """
    side = np.where(present[:, 0], 0, 1)
    (open_cases,) = np.nonzero(present.all(axis=1))
    if len(open_cases):
        side[open_cases] = np.where(start_values(open_cases) <= 0.0, 0, 1)
    return side


def ray_roots(cubics: Float, side: Int) -> Float:
    """Parameters (n,) at which rays to a side meet the surface, shooting polynomials (4, n).

    The first root in [0, 1); the nearest one at negative parameters where the start lies beyond the surface (4.5).
    """
    # mirrored on the negative side: F grows along all rays from below zero
    b = (cubics * np.where(side == 0, 1.0, -1.0)).T
    beyond = b[:, 0] > 0.0
    t = first_roots(b)
    if beyond.any():
        t[beyond] = extended_roots(b[beyond])
    return t


def differentiated_root(cubics: Sequence[Float], t: Float) -> Taylor:
    """Root t (n,) of shooting polynomials as a function of (u, v), coefficients as jets (4 of rows, n).

    Newton's method in Taylor arithmetic: each step finds the derivatives of one order and leaves the lower ones alone,
    so that they are the same whatever order is asked for.
    """
    slope = bernstein_slope(np.stack([rows[0] for rows in cubics]), t)
    root = t[None]
    for rows in ROWS[1 : 1 + ROWS.index(len(cubics[0]))]:
        known = len(root)
        root = np.concatenate([root, np.zeros((rows - known, len(t)))])
        b0, b1, b2, b3 = (Taylor(b[:rows]) for b in cubics)
        x = Taylor(root)
        r = 1.0 - x
        value = (b0 * (r * r) + 3.0 * (b1 * (x * r))) * r + x * x * (3.0 * (b2 * r) + b3 * x)
        root[known:] = -value.coefficients[known:] / slope
    return Taylor(root)


def _frozen(values: Float) -> Float:
    array = as_float(values).view()
    array.flags.writeable = False
    return array


def frozen_fields(batch: Shooting, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Check the shapes of a batch's fields without their first axis, and make them read-only."""
    count = len(batch.nets)
    for name, shape in shapes.items():
        values = getattr(batch, name)
        if np.shape(values) != (count, *shape):
            raise ValueError(f"{name} of {count} patches has the shape {(count, *shape)}, not {np.shape(values)}")
        object.__setattr__(batch, name, _frozen(values))
