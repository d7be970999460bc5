"""Blended triangular patches: a formula in the barycentric coordinates, evaluated in Taylor arithmetic."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np

from testbed.geometry.domain import barycentric, corner_distance
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.patches import PatchBatch
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Bool, Float, Int, as_float

#: ``formula(b0, b1, b2, **data)``: points (..., 3) from barycentric coordinates and data, in array notation.
Formula: TypeAlias = Callable[..., Float]

#: Points evaluated together to second order, twice as many to first: a few vectors with their derivatives stay in the
#: cache.
CHUNK = 4000


def _frozen(values: Float) -> Float:
    array = as_float(values).view()
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class BlendedTriangles(PatchBatch):
    """Triangular patches given by a formula; derivatives are exact, never finite differences.

    Parameters
    ----------
    formula
        Called as ``formula(b0, b1, b2, **data)``; returns points (..., 3). It is written for arrays and may be called
        with arrays; here b0, b1, b2 are Taylors that broadcast against (patches, samples). On the edges it is taken at
        its word: it uses b_j + b_k where a formula on paper has 1 - b_i.
    data
        Arrays by name, patch axis first, (P, ...). The formula receives (P, 1, ...): a sample axis has been put in.
    corner_points
        (P, 3, 3) points at the corners, where the formula is 0/0 and is not evaluated.
    corner_tangents
        (P, 3, 2, 3) derivatives at corner i along the boundary curves to corner i + 1 and to corner i + 2, each with
        respect to the parameter that runs from 0 at corner i to 1 at the other corner.
    corner_margin
        How near to a corner second derivatives can be trusted: what rounding leaves of them depends on the formula.

    Notes
    -----
    Results do not depend, to the last bit, on the division into chunks, if the formula combines the data among
    themselves with elementwise operations only (sums over data alone belong outside, once per patch).
    """

    formula: Formula
    data: Mapping[str, Float]
    corner_points: Float
    corner_tangents: Float
    corner_margin: float = 1e-6

    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "blended triangle"

    def __post_init__(self) -> None:
        count = len(self.corner_points)
        shapes = np.shape(self.corner_points), np.shape(self.corner_tangents)
        if shapes != ((count, 3, 3), (count, 3, 2, 3)):
            raise ValueError(f"corner points are (P, 3, 3) and corner tangents (P, 3, 2, 3), not {shapes}")
        for name, values in self.data.items():
            if len(values) != count:
                raise ValueError(
                    f"data {name!r} has {len(values)} entries for {count} patches: put the patch axis first"
                )
        object.__setattr__(self, "data", {name: _frozen(values) for name, values in self.data.items()})
        object.__setattr__(self, "corner_points", _frozen(self.corner_points))
        object.__setattr__(self, "corner_tangents", _frozen(self.corner_tangents))

    def __len__(self) -> int:
        return len(self.corner_points)

    def take(self, patches: Int | slice) -> Self:
        """Return the batch of the chosen patches, in the order chosen; repeats allowed."""
        return dataclasses.replace(
            self,
            data={name: values[patches] for name, values in self.data.items()},
            corner_points=self.corner_points[patches],
            corner_tangents=self.corner_tangents[patches],
        )

    @property
    def finite(self) -> Bool:
        """(P,) true where every number that defines the patch is finite."""
        arrays = (*self.data.values(), self.corner_points, self.corner_tangents)
        finite = [np.isfinite(values).reshape(len(self), -1).all(axis=1) for values in arrays]
        everything: Bool = np.logical_and.reduce(finite)
        return everything

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at domain points (S, 2) or (P, S, 2); at a corner, second derivatives are NaN."""
        shared = at.ndim == 2
        points = at[None] if shared else at
        # 1 - max(b) rounds to zero for everything that cannot be told from a corner in double precision
        at_corner = corner_distance(3, points) == 0.0
        away = np.where(at_corner[..., None], 1.0 / 3.0, points)
        # points run along the patches in memory, as they do inside a Taylor
        planes = np.empty((ROWS[order], 3, points.shape[1], len(self)))
        for patches, samples in self._chunks(points.shape[1], CHUNK * ROWS[2] // ROWS[order]):
            here = away[:, samples] if shared else away[patches, samples]
            # where a formula has no value its points are NaN, which every measure reports
            with np.errstate(invalid="ignore", divide="ignore"):
                planes[:, :, samples, patches] = self._evaluate(patches, here, order)
        coefficients = planes.transpose(0, 3, 2, 1)
        patch, sample = np.nonzero(np.broadcast_to(at_corner, coefficients.shape[1:3]))
        if len(patch):
            corner = barycentric(points[0 if shared else patch, sample]).argmax(axis=-1)
            coefficients[:, patch, sample] = self._corner_jets(patch, corner)[: ROWS[order]]
        return Jet(coefficients)

    def _chunks(self, samples: int, most: int) -> Iterator[tuple[slice, slice]]:
        """Yield runs of patches and samples, at most ``most`` points together."""
        step = max(1, most // max(samples, 1))
        for patch in range(0, len(self), step):
            for sample in range(0, samples, most):
                yield slice(patch, patch + step), slice(sample, sample + most)

    def _evaluate(self, patches: slice, at: Float, order: int) -> Float:
        """Values of the formula, (rows, 3, samples, patches)."""
        b1, b2 = Taylor.variables(at, order)
        b0: Any = 1.0 - (b1 + b2)
        # component-planar in memory, like the Taylors they meet
        data = {name: np.ascontiguousarray(values[patches, None].T).T for name, values in self.data.items()}
        point: Any = self.formula(b0, b1, b2, **data)
        return np.transpose(point.coefficients, (0, 3, 2, 1))

    def _corner_jets(self, patch: Int, corner: Int) -> Float:
        """Jets (6, N, 3) at corners of patches: derivatives along u and v from those along the two boundary curves."""
        onward, back = np.moveaxis(self.corner_tangents[patch, corner], 1, 0)
        which = corner[:, None]
        # (u, v) runs along (1, 0), (0, 1) from corner 0; (-1, 1), (-1, 0) from corner 1; (0, -1), (1, -1) from corner 2
        fu = np.choose(which, [onward, -back, back - onward])
        fv = np.choose(which, [back, onward - back, -onward])
        second = np.full((3, *fu.shape), np.nan)
        return np.concatenate([np.stack([self.corner_points[patch, corner], fu, fv]), second])
