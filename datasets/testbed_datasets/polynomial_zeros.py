"""Where a polynomial's zero set lies in a box, and whether it is regular there: branch and prune with true bounds."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.geometry.vectors import Bool, Float, norm
from testbed_datasets.polynomial import Evaluated
from testbed_datasets.polynomial_boxes import ROUNDING, Support, bounds

#: Boxes are halved as often at most; then they are as small as rounding.
MOST_HALVINGS: Final = 60
#: More boxes than this are left only where the gradient nearly vanishes along a curve or a surface, as between sheets
#: whose distance is a hundredth of their size; fewer for polynomials of a high degree, whose boxes hold more
#: coefficients than this together.
MOST_BOXES, MOST_COEFFICIENTS = 40_000, 20_000_000
#: Singular points are sought from the centres of as many boxes, those with the smallest gradient, after each halving.
STARTS: Final = 32
#: Steps of Newton's method towards a singular point; where derivatives up to a high order vanish, it converges slowly.
MOST_STEPS: Final = 100
#: A point counts as in the box up to this, relative to the box.
ON_BOX: Final = 1e-9
#: Sine of the angle by which the gradient turns within a box from that at its centre.
STRAIGHT: Final = 0.7
#: Boxes wanted along the longest side of what bounds the zero set.
FINENESS: Final = 32


@dataclass(frozen=True)
class Boxes:
    """N boxes, axis-parallel.

    Attributes
    ----------
    low, high
        (N, 3) corners.
    """

    low: Float
    high: Float

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, chosen: Bool) -> "Boxes":
        """Return some of the boxes."""
        return Boxes(self.low[chosen], self.high[chosen])

    @property
    def corners(self) -> tuple[Float, Float]:
        """``low`` and ``high``."""
        return self.low, self.high

    @property
    def centre(self) -> Float:
        """(N, 3) centres."""
        middle: Float = 0.5 * self.low + 0.5 * self.high
        return middle

    def halved(self) -> "Boxes":
        """Return the 8 N halves along all axes; sides shared by boxes are the same numbers in both."""
        upper = np.indices((2, 2, 2)).reshape(3, 8).T.astype(bool)  # (8, 3)
        middle = self.centre[:, None]
        low = np.where(upper, middle, self.low[:, None])
        high = np.where(upper, self.high[:, None], middle)
        return Boxes(low.reshape(-1, 3), high.reshape(-1, 3))


@dataclass(frozen=True)
class Doubt:
    """Why a zero set is not regular in a box.

    Attributes
    ----------
    place
        (3,) a point where the polynomial and its gradient vanish, or a place near to which this cannot be told.
    proved
        Whether they vanish there, to rounding.
    """

    place: Float
    proved: bool


def most_boxes(polynomial: Evaluated) -> int:
    """Return how many boxes are worked on at once at most."""
    return min(MOST_BOXES, MOST_COEFFICIENTS // len(Support.of(polynomial).exponents))


def singular_place(polynomial: Evaluated, low: Float, high: Float) -> Doubt | None:
    """Return a place in the closed box (3,), (3,) where the polynomial and its gradient vanish, or None.

    None is guaranteed: boxes are halved until in each the polynomial or a derivative has one sign. Otherwise a point is
    found by Newton's method where both vanish to rounding, or they are so small on so many boxes that this is not told
    from a singular surface.
    """
    boxes = Boxes(low[None], high[None])
    for _ in range(MOST_HALVINGS):
        over = bounds(polynomial, boxes.low, boxes.high)
        open_ = over.may_vanish & ~(over.least_gradient > 0.0)
        boxes = boxes[open_]
        if not len(boxes):
            return None
        smallest = np.argsort(norm(over.gradient[open_]), kind="stable")[:STARTS]
        place = _polished(polynomial, boxes.centre[smallest], low, high)
        if place is not None:
            return Doubt(place, proved=True)
        if len(boxes) > most_boxes(polynomial):
            break
        boxes = boxes.halved()
    return Doubt(boxes.centre[np.argmin(norm(polynomial.jets(boxes.centre).gradient))], proved=False)


def _polished(polynomial: Evaluated, starts: Float, low: Float, high: Float) -> Float | None:
    """Return a singular point (3,) in the box that Newton's method for a vanishing gradient reaches, or None.

    Where several are reached, the one with the smallest gradient from the first start.
    """
    points = starts.copy()
    size = norm(high - low)
    for _ in range(MOST_STEPS):
        jet = polynomial.jets(points)
        known = np.isfinite(jet.hessian).all(axis=(1, 2)) & np.isfinite(jet.gradient).all(axis=1)
        if not known.any():
            return None
        points, hessian, gradient = points[known], jet.hessian[known], jet.gradient[known]
        # least squares: where a curve or a surface is singular the Hessian is too
        step = np.einsum("nij,nj->ni", np.linalg.pinv(hessian, rcond=1e-12, hermitian=True), gradient)
        length = norm(step)
        points = points - step * np.minimum(1.0, 0.25 * size / np.maximum(length, 1e-300))[:, None]
        if (length <= 1e-15 * size).all():
            break
    reached = bounds(polynomial, points, points)  # radii are what rounding can make of zero there
    curved = ROUNDING * np.sqrt(np.sum(reached.hessian**2, axis=(1, 2))) * size
    inside = ((points >= low - ON_BOX * size) & (points <= high + ON_BOX * size)).all(axis=1)
    vanishes = (np.abs(reached.value) <= reached.value_radius) & (
        norm(reached.gradient) <= norm(reached.gradient_radius) + curved
    )
    found = points[inside & vanishes]
    return found[0] if len(found) else None


def occupied(polynomial: Evaluated, low: Float, high: Float) -> Boxes:
    """Return small boxes in a box (3,), (3,) that cover the zero set there; none where it is proved to be empty.

    At least ``FINENESS`` of the largest of them stand along the longest side of their bounding box, as far as that is
    found. In each the gradient turns by less than a right angle, so none has a piece of the zero set in its inside;
    only where the gradient nearly vanishes their number is reached before.
    """
    boxes, small = Boxes(low[None], high[None]), Boxes(np.empty((0, 3)), np.empty((0, 3)))
    for _ in range(MOST_HALVINGS):
        over = bounds(polynomial, boxes.low, boxes.high)
        left = over.may_vanish
        boxes = boxes[left]
        extent = np.concatenate([boxes.high, small.high]).max(axis=0, initial=-np.inf)
        extent -= np.concatenate([boxes.low, small.low]).min(axis=0, initial=np.inf)
        if len(boxes) and (len(small) or extent.max() >= FINENESS * (boxes.high[0] - boxes.low[0]).max()):
            straight = over.turn[left] <= STRAIGHT
            small = Boxes(*(np.concatenate(pair) for pair in zip(small.corners, boxes[straight].corners, strict=True)))
            boxes = boxes[~straight]
        if not len(boxes) or len(boxes) + len(small) > most_boxes(polynomial):
            break
        boxes = boxes.halved()
    return Boxes(*(np.concatenate(pair) for pair in zip(small.corners, boxes.corners, strict=True)))
