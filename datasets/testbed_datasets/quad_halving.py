"""Levels by halving quadrilaterals: every edge is split at its middle, every face in four."""

from collections.abc import Callable

import numpy as np

from testbed.geometry.vectors import Float, Int
from testbed_datasets.halving import check_level


def halved_quads(
    coordinates: Float, faces: Int, level: int, *, name: str, middle: Callable[[Float, Float], Float]
) -> tuple[Float, Int]:
    """Split every quadrilateral in four, ``level`` times.

    Parameters
    ----------
    coordinates
        (V, k) vertices, in space or in a parameter domain.
    faces
        (F, 4) vertex ids.
    level
        How often every edge is halved; 0 returns the mesh as it is.
    name
        The dataset, for the message of a refusal.
    middle
        Middle points (E, k) of edges from (E, k) to (E, k).

    Returns
    -------
    coordinates
        The vertices of the coarser level first, then the middles of its edges, then those of its faces.
    faces
        (4^level F, 4), oriented as before; child 4 f + c stands at corner c of face f and starts there.

    Raises
    ------
    Refused
        The level is negative, or its mesh would have too many faces.
    """
    check_level(level, len(faces), name)
    for _ in range(level):
        count = len(coordinates)
        start, end = faces, np.roll(faces, -1, axis=1)
        # one integer an edge: sorting them is ten times faster than sorting pairs
        keys, side = np.unique(np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True)
        middles = middle(coordinates[keys // count], coordinates[keys % count])
        after = count + side.reshape(faces.shape)
        centre = np.broadcast_to((count + len(keys) + np.arange(len(faces)))[:, None], faces.shape)
        coordinates = np.concatenate([coordinates, middles, quad_centres(coordinates, faces, middle)])
        faces = np.stack([faces, after, centre, np.roll(after, 1, axis=1)], axis=-1).reshape(-1, 4)
    return coordinates, faces


def quad_centres(coordinates: Float, faces: Int, middle: Callable[[Float, Float], Float]) -> Float:
    """Middles (F, k) of quadrilaterals: half-way between the middles of sides 0 and 2."""
    a, b, c, d = np.moveaxis(coordinates[faces], 1, 0)
    return middle(middle(a, b), middle(d, c))
