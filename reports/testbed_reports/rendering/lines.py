"""Lines on surfaces: the edges between patches, as far as they are seen, with the angle between normals along them."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, angle_between
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.visibility import GRID, Buffer

#: Pieces that an edge is drawn in.
PIECES = 24
#: How far behind what a pixel sees a line may lie and still be seen, in pixels.
BEHIND = 2.5


@dataclass(frozen=True, eq=False)
class Lines:
    """Pieces of edges in a picture.

    Parameters
    ----------
    ends
        (N, 2, 2) where each begins and ends, in pixels to the right and downwards.
    angle_deg
        (N,) angle between the normals of the patches on both sides, in the middle; NaN on the boundary.
    inner
        (N,) true on edges within a face of the mesh.
    """

    ends: Float
    angle_deg: Float
    inner: Bool


def edge_lines(surface: Surface, camera: Camera, buffer: Buffer) -> Lines:
    """Return the visible pieces of all edges between patches and on the boundary."""
    size = len(buffer.facet) // GRID
    edges = surface.edges
    t = np.arange(PIECES + 1) / PIECES
    points = surface.side_jets(edges.left, t, 0).f
    middles = 0.5 * (t[1:] + t[:-1])
    angle = np.full((len(edges), PIECES), np.nan)
    interior = edges.interior
    if interior.any():
        left, right = surface.edge_jets(edges[interior], middles, 1)
        with np.errstate(invalid="ignore"):
            angle[interior] = np.degrees(angle_between(left.normal, right.normal))
    screen = camera.screen(points.reshape(-1, 3), size).reshape(len(edges), PIECES + 1, 3)
    seen = _seen(0.5 * (screen[:, 1:] + screen[:, :-1]), buffer)
    ends = np.stack([screen[:, :-1, :2], screen[:, 1:, :2]], axis=2)
    inner = np.broadcast_to(edges.within_face[:, None], seen.shape)
    return Lines(ends[seen], angle[seen], inner[seen])


def _seen(screen: Float, buffer: Buffer) -> Bool:
    """(...) true where points (..., 3) in pixels are not behind what their samples see."""
    samples = len(buffer.facet)
    with np.errstate(invalid="ignore"):
        column, row = (np.nan_to_num(screen[..., i] * GRID).clip(0, samples - 1).astype(np.int64) for i in (0, 1))
    seen: Bool = screen[..., 2] >= _nearby(buffer.depth)[row, column] - BEHIND
    return seen


def _nearby(depth: Float) -> Float:
    """The least depth of a sample and its neighbours, so that lines on silhouettes are seen."""
    padded = np.pad(depth, 1, constant_values=-np.inf)
    count = len(depth)
    least: Float = np.minimum.reduce([padded[i : i + count, j : j + count] for i in range(3) for j in range(3)])
    return least
