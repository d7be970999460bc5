"""Levels by halving: every edge is split at its middle, every triangle in four."""

from collections.abc import Callable

import numpy as np

from testbed.errors import Refused
from testbed.geometry.vectors import Bool, Float, Int

#: Meshes with more faces than this are refused.
MOST_FACES = 4_000_000


def halved(
    coordinates: Float, faces: Int, level: int, *, name: str, middle: Callable[[Float, Float], Float]
) -> tuple[Float, Int]:
    """Split every triangle in four, ``level`` times.

    Parameters
    ----------
    coordinates
        (V, k) vertices, in space or in a parameter domain.
    faces
        (F, 3) vertex ids.
    level
        How often every edge is halved; 0 returns the mesh as it is.
    name
        The dataset, for the message of a refusal.
    middle
        Middle points (E, k) of edges from (E, k) to (E, k).

    Returns
    -------
    coordinates
        The vertices of the coarser level first, then the middles of its edges.
    faces
        (4^level F, 3), oriented as before; children 4 f, 4 f + 1, 4 f + 2 stand at the corners of face f, child 4 f + 3
        in its middle.

    Raises
    ------
    Refused
        The level is negative, or its mesh would have more than ``MOST_FACES`` faces.
    """
    check_level(level, len(faces), name)
    for _ in range(level):
        edges, _, faces = split_in_four(faces, len(coordinates))
        coordinates = np.concatenate([coordinates, middle(coordinates[edges[:, 0]], coordinates[edges[:, 1]])])
    return coordinates, faces


def check_level(level: int, faces: int, name: str) -> None:
    """Check a level of a dataset whose level 0 has so many faces, each of which every level splits in four.

    Raises
    ------
    Refused
        The level is negative, or its mesh would have more than ``MOST_FACES`` faces.
    """
    if level < 0:
        raise Refused(f"{name} has no level {level}: levels start at 0")
    highest = int(np.log2(MOST_FACES / faces) // 2)
    if level > highest:
        raise Refused(f"level {level} of {name} would have more than {MOST_FACES} faces: take a level up to {highest}")


def split_in_four(faces: Int, count: int) -> tuple[Int, Bool, Int]:
    """Split every triangle at the middles of its edges, which become vertices from ``count`` on.

    Returns
    -------
    edges
        (E, 2) vertex ids, the lower first; edge e has the middle ``count + e``.
    boundary
        (E,) true for edges of one face.
    faces
        (4 F, 3), as :func:`halved` orders them.
    """
    start, end = faces, np.roll(faces, -1, axis=1)
    # one integer an edge: sorting them is ten times faster than sorting pairs
    keys, side, uses = np.unique(
        np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True, return_counts=True
    )
    side = count + side.reshape(faces.shape)
    after, before = side, np.roll(side, 1, axis=1)
    corners = np.stack([faces, after, before], axis=-1)  # (F, corner, 3)
    children = np.concatenate([corners, side[:, None, :]], axis=1).reshape(-1, 3)
    return np.stack([keys // count, keys % count], axis=-1), uses == 1, children


def straight(start: Float, end: Float) -> Float:
    """Middle points of straight edges, (E, k)."""
    return 0.5 * (start + end)
