"""Bezier triangles cut off at the plane z = 0: what lies below it is put onto it."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.jets import Jet
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Bool, Float, Int


@dataclass(frozen=True, eq=False)
class ClippedTriangles(PatchBatch):
    """Points (x, y, max(z, 0)) of Bezier triangles; continuous, with a crease along z = 0, which derivatives jump over.

    Parameters
    ----------
    whole
        The Bezier triangles. Where z is zero, derivatives are theirs.
    """

    whole: BezierTriangles
    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "clipped Bézier triangle"

    def __len__(self) -> int:
        return len(self.whole)

    @property
    def work(self) -> float:
        """That of the Bezier triangles."""
        return self.whole.work

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return self.whole.finite

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.whole.take(patches))

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        coefficients = self.whole.jets(at, order).coefficients.copy()
        coefficients[..., 2][:, coefficients[0, ..., 2] < 0.0] = 0.0
        return Jet(coefficients)

    @property
    def convex_components(self) -> tuple[PatchBatch, ...]:
        """The shadow on the plane, and the triangle of the ordinates that are not negative: the patch lies between."""
        net = self.whole.control_points
        return tuple(
            BezierTriangles(np.concatenate([net[..., :2], heights], axis=-1))
            for heights in (np.zeros_like(net[..., 2:]), np.maximum(net[..., 2:], 0.0))
        )
