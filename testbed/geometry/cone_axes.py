"""Axes of the narrowest cones about sets of directions: from there, all of them are seen as nearly as can be.

The axis h maximises the least of h . v over unit vectors v. It is decided by at most three of them, and found by
exchange: while some vector lies outside the cone of the chosen ones, it replaces one of these so that the cone of the
new ones holds the old ones, too. Cones widen from step to step, so that the last one is reached.
"""

from itertools import combinations

import numpy as np

from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, Int, cross, dot, norm, unit

#: What a vector may lie outside a cone, by the cosine: rounding.
ROUNDING = 1e-14
#: More exchanges than were ever needed; each one widens the cone.
STEPS = 1000


def cone_axes(directions: Float) -> tuple[Float, Float]:
    """Return the axes of the narrowest cones about sets of unit vectors.

    Parameters
    ----------
    directions
        (N, K, 3), K unit vectors a set; a set with fewer repeats some of them.

    Returns
    -------
    axes, cosines
        (N, 3) unit vectors h and (N,) the least h . v of each set, positive; NaN where no h has a positive one.
    """
    chosen = np.repeat(directions[:, :1], 3, axis=1)
    axes, cosines = directions[:, 0].copy(), np.ones(len(directions))
    open_ = np.arange(len(directions))
    for _ in range(STEPS):
        inside = np.vecdot(directions[open_], axes[open_, None])
        farthest = np.argmin(inside, axis=1)  # NaN, too: a set that has no cone
        outside = inside[np.arange(len(open_)), farthest] < cosines[open_] - ROUNDING
        open_, farthest = open_[outside], farthest[outside]
        if not len(open_):
            break
        chosen[open_], axes[open_], cosines[open_] = _exchange(chosen[open_], directions[open_, farthest])
    return axes, cosines


def _exchange(chosen: Float, new: Float) -> tuple[Float, Float, Float]:
    """Return the vectors that decide the cone about three chosen (N, 3, 3) and a new one, its axis and cosine."""
    four = np.concatenate([chosen, new[:, None]], axis=1)
    candidates = []
    for pick in combinations(range(3), 2):
        a, b = four[:, pick[0]], four[:, pick[1]]
        axis = unit(cross(a - new, b - new))
        candidates.append((np.stack([a, b, new], axis=1), np.where(dot(axis, new)[:, None] < 0.0, -axis, axis)))
    for i in range(3):
        a = four[:, i]
        candidates.append((np.stack([a, a, new], axis=1), unit(a + new)))
    vectors, axes = (np.stack(parts, axis=1) for parts in zip(*candidates, strict=True))
    cosines = dot(axes, new[:, None])
    holds = np.vecdot(four[:, None], axes[:, :, None]).min(axis=2) >= cosines - ROUNDING
    cosines = np.where(holds & (cosines > ROUNDING), cosines, -np.inf)
    best = np.argmax(cosines, axis=1)
    row = np.arange(len(new))
    exists = cosines[row, best] > 0.0
    axis = np.where(exists[:, None], axes[row, best], np.nan)
    return vectors[row, best], axis, np.where(exists, cosines[row, best], np.nan)


def fans(faces: Triangulation, vertices: Int) -> Int:
    """Return the faces at some vertices, (N, K) with K the most at any; others repeat the first."""
    half_edge = np.where(faces.outgoing[vertices] >= 0, faces.outgoing[vertices], 0)
    around = np.repeat(half_edge[:, None] // 3, int(faces.face_count[vertices].max(initial=1)), axis=1)
    for place in range(1, around.shape[1]):
        left = place < faces.face_count[vertices]
        half_edge[left] = faces.counterclockwise(half_edge[left])
        around[left, place] = half_edge[left] // 3
    return around


def face_normals(points: Float, faces: Int) -> tuple[Float, Float]:
    """Return the unit normals (F, 3) and the areas (F,) of triangles."""
    corners = points[faces]
    doubled = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return unit(doubled), 0.5 * norm(doubled)
