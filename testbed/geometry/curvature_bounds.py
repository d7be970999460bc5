"""Guaranteed enclosures of the extremes of Gaussian and mean curvature over Bezier patches, by branch and bound.

Each extreme comes as two numbers that it lies between, rounding included. The inner one is attained: a lower bound of
the curvature at some point. The outer one bounds the curvature over all pieces that the patches were cut into (see
:mod:`testbed.geometry.quotient_bounds`). Pieces that cannot change the result by more than the tolerance are not cut
further; when the work allowed is done, the rest stays as it is, and the enclosure is wider but as true.

Where a parametrisation is singular, or cannot be told from a singular one, curvature is not bounded: the outer numbers
are infinite. The inner ones are still curvatures at regular points, or infinite where there are none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.geometry.branch_and_bound import Front, Search, scaled
from testbed.geometry.curvature_polynomials import KINDS, curvature_polynomials, numerator_degrees
from testbed.geometry.enclosed_nets import exponents
from testbed.geometry.patches import PatchBatch
from testbed.geometry.quotient_bounds import Cells, lower_quotient, values_at
from testbed.geometry.vectors import Float, Int

#: Gap between the two numbers of an enclosure that is aimed at, relative to the largest absolute curvature.
TOLERANCE = 1e-6
#: Halvings of a patch, one after the other, at most; they cut triangles and squares to 2^-24 of their size.
ROUNDS = 48
#: Pieces that are cut for each of the two curvatures at most: so many, and so many a patch, of a surface as a whole and
#: of patches each by itself.
CUTS, CUTS_OF_SURFACE, CUTS_OF_PATCHES = 10_000, 16, 200
#: Patches that are first bounded at once, and products of their coefficients, at most, so that these stay in the cache.
BLOCK, PRODUCTS = 256, 1_000_000
#: Powers of m.m that the numerators of K and of H are divided by, and how the two scale with length.
POWERS, SCALING = (2.0, 1.5), (2, 1)


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Two numbers that another lies between: (P,) of patches, or one of a surface.

    Parameters
    ----------
    low, high
        Lower and upper bounds, infinite where there is none.
    """

    low: Float
    high: Float


@dataclass(frozen=True, eq=False)
class CurvatureBounds:
    """Enclosures of the extremes of Gaussian and mean curvature, signs as in :mod:`testbed.geometry.curvature`.

    Parameters
    ----------
    gauss_min, gauss_max, mean_min, mean_max
        Smallest and largest of each.
    """

    gauss_min: Enclosure
    gauss_max: Enclosure
    mean_min: Enclosure
    mean_max: Enclosure


@dataclass(frozen=True, eq=False)
class Places:
    """Points at which curvature is looked at before anything else, where it is thought to be extreme.

    Parameters
    ----------
    patch, at
        (N,) patches of a batch and (N, 2) points of their domain.
    """

    patch: Int
    at: Float


def certifiable(batch: PatchBatch) -> bool:
    """Whether the patches are polynomial or rational all over, so that :func:`patch_bounds` can enclose them."""
    return isinstance(batch, KINDS) and batch.corner_margin == 0.0


def numerator_size(batch: PatchBatch) -> int:
    """Bernstein coefficients of the numerator of K on one patch, of degree 2 or more; the work grows with them.

    Raises
    ------
    TypeError
        The patches are of another kind.
    """
    return len(exponents(numerator_degrees(batch)))


def patch_bounds(
    batch: PatchBatch, *, tolerance: float = TOLERANCE, rounds: int = ROUNDS, cuts: int | None = None
) -> CurvatureBounds:
    """Enclose the curvature extremes of each patch by itself, (P,).

    Parameters
    ----------
    batch
        Bezier triangles of any degree, rational ones, or tensor-product patches.
    tolerance
        Gap to aim at, relative to the largest absolute curvature of the patch.
    rounds
        Halvings of a patch, one after the other, at most.
    cuts
        Pieces to be cut for each of the two curvatures, of a batch, at most; by default in proportion to the number of
        patches.

    Raises
    ------
    TypeError
        The patches are of another kind.
    """
    count = len(batch)
    start = np.full((4, count), -np.inf)
    allowed = CUTS + CUTS_OF_PATCHES * count if cuts is None else cuts
    return _enclosed([batch], [np.arange(count)], start, tolerance, rounds, allowed)


def surface_bounds(
    batches: Sequence[PatchBatch],
    places: Sequence[Places] = (),
    *,
    tolerance: float = TOLERANCE,
    rounds: int = ROUNDS,
    cuts: int | None = None,
) -> CurvatureBounds:
    """Enclose the curvature extremes of all patches together, one number each.

    Patches that cannot reach the extremes known so far are bounded once and not cut.

    Parameters
    ----------
    batches
        See :func:`patch_bounds`, as for the other parameters.
    places
        For each batch, places where to find extremes; they save work and have no other influence.

    Raises
    ------
    TypeError
        Some patches are of another kind.
    """
    start = np.full((4, 1), -np.inf)
    for batch, where in zip(batches, places, strict=bool(places)):
        start = np.maximum(start, _attained_at(batch, where))
    groups = [np.zeros(len(batch), dtype=np.int64) for batch in batches]
    allowed = CUTS + CUTS_OF_SURFACE * sum(len(batch) for batch in batches) if cuts is None else cuts
    return _enclosed(batches, groups, start, tolerance, rounds, allowed)


def _attained_at(batch: PatchBatch, where: Places) -> Float:
    """Lower bounds (4, 1) on the largest K, -K, H, -H at places."""
    if not len(where.patch):
        return np.full((4, 1), -np.inf)
    forms = curvature_polynomials(batch.take(where.patch))
    square, of_square = values_at(forms.square, where.at)
    found = []
    for numerator, power, scaling in zip((forms.gauss, forms.mean), POWERS, SCALING, strict=True):
        value, error = values_at(numerator, where.at)
        for sign in (1.0, -1.0):
            low = lower_quotient(sign * value, error, square, of_square, power)
            low = np.where(forms.regular, low, -np.inf)
            found.append(scaled(low, forms.exponent * scaling, -1.0).max(keepdims=True))
    return np.stack(found)


def _enclosed(
    batches: Sequence[PatchBatch],
    groups: Sequence[Int],
    start: Float,
    tolerance: float,
    rounds: int,
    cuts: int,
) -> CurvatureBounds:
    """Enclose the extremes of groups of patches; ``start`` (4, G) are attained K, -K, H, -H."""
    searches = [Search(best.copy(), np.full_like(best, -np.inf), tolerance) for best in (start[:2], start[2:])]
    for batch, group in zip(batches, groups, strict=True):
        fronts: tuple[list[Front], list[Front]] = ([], [])
        for block in _blocks(batch):
            forms = curvature_polynomials(batch.take(block))
            for which, numerator in enumerate((forms.gauss, forms.mean)):
                cells = Cells.whole(numerator, forms.square, POWERS[which])
                front = Front.of(cells, forms.exponent * SCALING[which], group[block], ~forms.regular)
                # what cannot compete with its own block needs no memory
                fronts[which].append(searches[which].entered(front))
        for search, found in zip(searches, fronts, strict=True):
            search.run(Front.joined(found), rounds, cuts)
    enclosures = []
    for search in searches:
        high = np.maximum(search.settled, search.best)
        largest = Enclosure(search.best[0] + 0.0, high[0] + 0.0)
        enclosures += [Enclosure(-high[1] + 0.0, -search.best[1] + 0.0), largest]
    return CurvatureBounds(*enclosures)


def _blocks(batch: PatchBatch) -> list[slice]:
    # the longest list of products of coefficients is about so long
    patches = max(1, min(BLOCK, int(PRODUCTS / numerator_size(batch) ** 1.5)))
    return [slice(first, min(first + patches, len(batch))) for first in range(0, len(batch), patches)]
