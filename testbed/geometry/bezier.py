"""Bezier patches in batches: triangles of any degree, rational triangles, tensor-product patches.

How they are evaluated is in :mod:`testbed.geometry.evaluation`.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from testbed.geometry.bernstein import triangle_degree
from testbed.geometry.evaluation import project, tensor_jets, triangle_jets
from testbed.geometry.jets import Jet
from testbed.geometry.patches import PatchBatch, polynomial_work
from testbed.geometry.vectors import Bool, Float, Int, as_float


def _frozen(values: Any) -> Float:
    """Read-only float64 array: a copy, unless nobody can write to the values anyway."""
    array = as_float(values)
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class BezierTriangles(PatchBatch):
    """Polynomial Bezier triangles of one degree.

    Parameters
    ----------
    control_points
        (P, n, 3), n = (d + 1)(d + 2) / 2, multi-indices by decreasing i, then decreasing j (see
        :mod:`testbed.geometry.bernstein`).
    """

    control_points: Float
    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "Bézier triangle"

    def __post_init__(self) -> None:
        points = _frozen(self.control_points)
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ValueError(f"control points of triangles are (P, n, 3), not {points.shape}")
        triangle_degree(points.shape[1])
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> int:
        """Degree of the patches."""
        return triangle_degree(self.control_points.shape[1])

    @property
    def convex_components(self) -> tuple[PatchBatch, ...]:
        """The patches themselves."""
        return (self,)

    @property
    def work(self) -> float:
        """By its control points; see :class:`PatchBatch`."""
        return polynomial_work(self.control_points.shape[1])

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        return Jet(triangle_jets(self.control_points, at, order))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class RationalBezierTriangles(PatchBatch):
    """Rational Bezier triangles of one degree, sum w B P / sum w B.

    Parameters
    ----------
    control_points
        (P, n, 3) in space.
    weights
        (P, n).
    """

    control_points: Float
    weights: Float
    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "rational Bézier triangle"

    def __post_init__(self) -> None:
        points, weights = _frozen(self.control_points), _frozen(self.weights)
        if points.ndim != 3 or points.shape[-1] != 3 or weights.shape != points.shape[:2]:
            raise ValueError(
                f"rational triangles need control points (P, n, 3) and weights (P, n), "
                f"not {points.shape} and {weights.shape}"
            )
        triangle_degree(points.shape[1])
        object.__setattr__(self, "control_points", points)
        object.__setattr__(self, "weights", weights)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> int:
        """Degree of numerator and denominator."""
        return triangle_degree(self.control_points.shape[1])

    @property
    def homogeneous(self) -> Float:
        """Control points (w x, w y, w z, w), (P, n, 4)."""
        return np.concatenate([self.control_points * self.weights[..., None], self.weights[..., None]], axis=-1)

    @property
    def work(self) -> float:
        """By its control points, and the division; see :class:`PatchBatch`."""
        return 1.3 * polynomial_work(self.control_points.shape[1])

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        return Jet(project(triangle_jets(self.homogeneous, at, order)))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches], self.weights[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate and weight is finite."""
        return np.asarray(np.isfinite(self.homogeneous).all(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class BezierQuads(PatchBatch):
    """Tensor-product Bezier patches of one bidegree over the unit square.

    Parameters
    ----------
    control_points
        (P, m + 1, n + 1, 3): axis 1 along u, axis 2 along v.
    """

    control_points: Float
    sides: ClassVar[int] = 4
    kind: ClassVar[str] = "tensor-product Bézier patch"

    def __post_init__(self) -> None:
        points = _frozen(self.control_points)
        if points.ndim != 4 or points.shape[-1] != 3 or 0 in points.shape[1:3]:
            raise ValueError(f"control points of tensor-product patches are (P, m + 1, n + 1, 3), not {points.shape}")
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> tuple[int, int]:
        """Degrees (m, n) along u and v."""
        return self.control_points.shape[1] - 1, self.control_points.shape[2] - 1

    @property
    def convex_components(self) -> tuple[PatchBatch, ...]:
        """The patches themselves."""
        return (self,)

    @property
    def work(self) -> float:
        """By its control points; see :class:`PatchBatch`."""
        return polynomial_work(self.control_points.shape[1] * self.control_points.shape[2])

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        return Jet(tensor_jets(self.control_points, at, order))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2, 3)))
