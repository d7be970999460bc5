"""Triangular patches that combine control points with any basis: the same functions for all patches, tabulated once.

A patch whose blending functions depend on the parameters alone, such as Gregory's, is linear in its control points: its
jets are the table of the basis functions and their derivatives times the control points, one matrix product for all
patches. The functions are written once in array notation and differentiated by Taylor arithmetic.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np

from testbed.geometry.domain import barycentric, corner_distance
from testbed.geometry.evaluation import apply_table
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.patches import PatchBatch, polynomial_work
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Bool, Float, Int, as_float

#: ``basis(b0, b1, b2)``: n functions of the barycentric coordinates, in array notation.
Basis: TypeAlias = Callable[[Any, Any, Any], Sequence[Any]]

#: Points evaluated together where every patch has its own; the jets of the functions are 6 n numbers a point.
RUN = 1024
#: Functions at no more shared points than this are remembered.
REMEMBERED = 1024


@dataclass(frozen=True, eq=False)
class TabulatedTriangles(PatchBatch):
    """Triangular patches sum_r basis_r(b0, b1, b2) P_r; derivatives are exact.

    Parameters
    ----------
    basis
        The n functions, called as ``basis(b0, b1, b2)`` with arrays or Taylors. Write b_j + b_k for 1 - b_i, or the
        edges lose their exactness.
    control_points
        (P, n, 3).
    corner_table
        (3, 3, n): value and derivatives along u and v of the functions (last axis) at corners 0, 1, 2 (middle axis),
        where a blend is 0/0 and is not evaluated.
    corner_margin
        How near to a corner second derivatives can be trusted.
    """

    basis: Basis
    control_points: Float
    corner_table: Float
    corner_margin: float
    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "triangle with blended control points"

    def __post_init__(self) -> None:
        points = as_float(self.control_points).view()
        points.flags.writeable = False
        if points.ndim != 3 or points.shape[2] != 3 or np.shape(self.corner_table) != (3, 3, points.shape[1]):
            raise ValueError(
                f"control points are (P, n, 3) and the corner table (3, 3, n), not {points.shape} and "
                f"{np.shape(self.corner_table)}"
            )
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def work(self) -> float:
        """By its control points; see :class:`PatchBatch`."""
        return polynomial_work(self.control_points.shape[1])

    def functions(self, at: Float, order: int) -> Float:
        """Jets of the n functions at points (..., 2), (n, 1 | 3 | 6, ...); second derivatives are NaN at corners."""
        # 1 - max(b) rounds to zero for all that cannot be told from a corner in double precision
        at_corner = np.asarray(corner_distance(3, at) == 0.0)
        b1, b2 = Taylor.variables(np.where(at_corner[..., None], 1.0 / 3.0, at), order)
        jets = np.stack([function.coefficients for function in self.basis(1.0 - (b1 + b2), b1, b2)])
        if at_corner.any():
            corner = barycentric(at[at_corner]).argmax(axis=-1)
            jets[:, :, at_corner] = np.nan
            jets[:, :3, at_corner] = np.moveaxis(self.corner_table[: ROWS[order], corner], -1, 0)
        return jets

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        if at.ndim == 2:
            return Jet(apply_table(np.moveaxis(self._shared(at, order), 0, -1), self.control_points))
        # memory runs along the samples, one component after the other
        result = np.zeros((ROWS[order], 3, *at.shape[:2]))
        run = max(1, RUN // max(at.shape[1], 1))
        with np.errstate(invalid="ignore", over="ignore"):  # a patch that is not finite stays so
            for start in range(0, len(self), run):
                patches = slice(start, start + run)
                net = self.control_points[patches].transpose(1, 2, 0)[..., None]
                for jet, points in zip(self.functions(at[patches], order), net, strict=True):
                    result[:, :, patches] += jet[:, None] * points
        return Jet(result.transpose(0, 2, 3, 1))

    def _shared(self, at: Float, order: int) -> Float:
        """Functions at points shared by all patches, which a batch that comes in chunks asks for again and again."""
        remembered = _functions if len(at) <= REMEMBERED else _functions.__wrapped__
        table = np.ascontiguousarray(self.corner_table)
        return remembered(self.basis, table.tobytes(), order, np.asarray(at, dtype=np.float64).tobytes())

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return dataclasses.replace(self, control_points=self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2)))


@lru_cache(maxsize=16)
def _functions(basis: Basis, corner_table: bytes, order: int, points: bytes) -> Float:
    table = np.frombuffer(corner_table).reshape(3, 3, -1)
    batch = TabulatedTriangles(basis, np.zeros((0, table.shape[2], 3)), table, 0.0)
    functions = batch.functions(np.frombuffer(points).reshape(-1, 2), order)
    functions.flags.writeable = False
    return functions
