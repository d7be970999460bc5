"""Parameter domains of patches: the triangle and the square, their corners, sides and sample lattices.

A triangle has parameters (u, v) = (b1, b2), b0 = 1 - u - v, so that u runs from corner 0 to corner 1 and v from corner
0 to corner 2. A square has (u, v) in [0, 1]^2 with corners 0 (0, 0), 1 (1, 0), 2 (1, 1), 3 (0, 1). In both the corners
run counterclockwise seen from the side the normal f_u x f_v points to, and side s runs from corner s to corner s + 1.
"""

import numpy as np

from testbed.geometry.vectors import Float, Int

CORNERS: dict[int, Float] = {
    3: np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    4: np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}


def side_points(sides: int, side: Int, t: Float) -> Float:
    """Domain points at parameter ``t`` in [0, 1] of sides; ``side`` (N,) and ``t`` (S,) or (N, S) give (N, S, 2)."""
    corners = CORNERS[sides]
    start, end = corners[side][:, None, :], corners[(side + 1) % sides][:, None, :]
    t = np.broadcast_to(t, (len(side), t.shape[-1]))[..., None]
    # symmetric in start and end, so that t and 1 - t from the other side are the same point to the last bit
    points: Float = (1.0 - t) * start + t * end
    return points


def lattice(sides: int, steps: int) -> Float:
    """Regular sample lattice, the boundary included, (S, 2); S = (n+1)(n+2)/2 or (n+1)^2 for n steps a side."""
    i, j = np.meshgrid(np.arange(steps + 1), np.arange(steps + 1), indexing="ij")
    points = np.stack([i.ravel(), j.ravel()], axis=-1) / steps
    inside = i.ravel() + j.ravel() <= steps
    return points[inside] if sides == 3 else points


def barycentric(at: Float) -> Float:
    """Barycentric coordinates (..., 3) of triangle parameters (..., 2)."""
    return np.concatenate([1.0 - at.sum(axis=-1, keepdims=True), at], axis=-1)


def corner_distance(sides: int, at: Float, collapsed: tuple[int, ...] = ()) -> Float:
    """How near the nearest corner is, (...): 1 - max(b) on a triangle, the larger of |du|, |dv| on a square.

    A side of a square that is ``collapsed`` to a point in space counts as a corner, with the distance to it.
    """
    if sides == 3:
        return np.asarray(1.0 - barycentric(at).max(axis=-1))
    offsets = np.abs(at[..., None, :] - CORNERS[4]).max(axis=-1)
    nearest: Float = offsets.min(axis=-1)
    u, v = at[..., 0], at[..., 1]
    for side in collapsed:
        nearest = np.minimum(nearest, (v, 1.0 - u, 1.0 - v, u)[side])
    return nearest
