"""What a batch of patches is, whatever the kind: a family of maps from one domain to space with exact derivatives."""

from abc import ABC, abstractmethod
from typing import ClassVar, Self

from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Bool, Float, Int


class PatchBatch(ABC):
    """Patches of one kind over one domain (see :mod:`testbed.geometry.domain`); immutable.

    Attributes
    ----------
    sides
        3: parameters (u, v) = (b1, b2) on the triangle; 4: (u, v) on the unit square.
    kind
        What a patch is, in words.
    corner_margin
        How near to a corner or a collapsed side (``domain.corner_distance``) second derivatives can be trusted: 0 for
        polynomial patches; blended patches are 0/0 at their corners, where value and normal have limits and curvature
        depends on direction.
    collapsed
        Sides that are a single point in space, where two curves meet in a vertex at an angle. The derivative along such
        a side vanishes on it; exactly there its limit direction stands in its place, the derivative divided by the
        distance from the side, so that there is a normal. Second derivatives are NaN there.
    work
        What it takes to measure one patch, in cubic triangles, roughly; used to plan runs.
    """

    sides: ClassVar[int]
    kind: ClassVar[str] = "patch"
    corner_margin: float = 0.0
    collapsed: ClassVar[tuple[int, ...]] = ()

    @property
    def convex_components(self) -> tuple["PatchBatch", ...]:
        """Bezier batches of which each point of a patch is a convex combination, at the same parameters.

        What holds for all points of these on one side of a plane holds for the patch. Empty where none are known.
        """
        return ()

    @property
    def work(self) -> float:
        """See above; a blend of a few patches unless a kind says otherwise."""
        return 8.0

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of patches, P."""

    @abstractmethod
    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at the domain points ``at``: (S, 2), the same for every patch, or (P, S, 2), each patch its own.

        Returns coefficients (1 | 3 | 6, P, S, 3) for order 0 | 1 | 2. Results do not depend on how patches or samples
        are divided over calls. At a corner, value and first derivatives are exact also where the formula is 0/0; second
        derivatives are NaN there if they have no limit.
        """

    @abstractmethod
    def take(self, patches: Int | slice) -> Self:
        """Return the batch of the chosen patches, in the order chosen; repeats allowed."""

    @property
    @abstractmethod
    def finite(self) -> Bool:
        """(P,) true where every number that defines the patch is finite."""


def polynomial_work(control_points: int) -> float:
    """Return the work of a patch with so many control points: half of a cubic triangle's is there without any."""
    return 0.5 + 0.05 * control_points
