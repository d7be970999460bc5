"""Surfaces as facets fine enough to tell what shows where; every facet knows its patch and its place in it."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int

#: Facets of a picture, about, and the least and the most steps that the sides of a patch are divided into.
BUDGET = 50_000
STEPS = (4, 48)
#: Points evaluated at once.
CHUNK = 65_536


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles on a surface.

    Parameters
    ----------
    points
        (N, 3) points on the patches; neighbouring patches have their own.
    corners
        (T, 3) ids of points.
    part, patch
        (T,) which patch each lies on.
    at
        (T, 3, 2) parameters of the corners.
    """

    points: Float
    corners: Int
    part: Int
    patch: Int
    at: Float

    def __len__(self) -> int:
        return len(self.corners)


def lattice_facets(sides: int, steps: int) -> Int:
    """Triangles (T, 3) between the points of ``domain.lattice(sides, steps)``, counterclockwise."""
    i, j = (axis.ravel() for axis in np.indices((steps, steps)))
    if sides == 4:
        corner = i * (steps + 1) + j
        lower = np.stack([corner, corner + steps + 1, corner + 1], axis=-1)
        upper = np.stack([corner + steps + 1, corner + steps + 2, corner + 1], axis=-1)
        return np.concatenate([lower, upper])
    i, j = i[i + j < steps], j[i + j < steps]

    def place(i: Int, j: Int) -> Int:
        return i * (steps + 1) - i * (i - 1) // 2 + j

    lower = np.stack([place(i, j), place(i + 1, j), place(i, j + 1)], axis=-1)
    i, j = i[i + j < steps - 1], j[i + j < steps - 1]
    upper = np.stack([place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)], axis=-1)
    return np.concatenate([lower, upper])


def steps_of(surface: Surface, budget: int = BUDGET) -> int:
    """Return the steps a side that keep the facets of all patches within a budget, where ``STEPS`` allow that."""
    squares = sum(len(part.batch) * (part.batch.sides - 2) for part in surface.parts)
    return int(np.clip(np.sqrt(budget / max(squares, 1)), *STEPS))


def facets_of(surface: Surface, budget: int = BUDGET) -> Facets:
    """Divide every patch of a surface into facets."""
    steps = steps_of(surface, budget)
    points: list[Float] = [np.empty((0, 3))]
    corners: list[Int] = [np.empty((0, 3), dtype=np.int64)]
    places: list[Float] = [np.empty((0, 3, 2))]
    parts, patches = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    first = 0
    for index, part in enumerate(surface.parts):
        at, triangles = lattice(part.batch.sides, steps), lattice_facets(part.batch.sides, steps)
        count = len(part.batch)
        run = max(1, CHUNK // len(at))
        for start in range(0, count, run):
            some = part.batch.take(slice(start, min(start + run, count)))
            points.append(some.jets(at, 0).f.reshape(-1, 3))
        corners.append((first + len(at) * np.arange(count)[:, None, None] + triangles).reshape(-1, 3))
        places.append(np.tile(at[triangles], (count, 1, 1)))
        parts.append(np.full(count * len(triangles), index))
        patches.append(np.repeat(np.arange(count), len(triangles)))
        first += count * len(at)
    return Facets(
        np.concatenate(points),
        np.concatenate(corners),
        np.concatenate(parts),
        np.concatenate(patches),
        np.concatenate(places),
    )
