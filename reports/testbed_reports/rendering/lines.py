"""Lines on surfaces: the edges between patches, as far as they are seen, with the angle between normals along them."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from testbed.geometry.edges import PatchSides
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int, angle_between, dot
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.facets import Facets
from testbed_reports.rendering.visibility import GRID, Buffer

#: Pieces that an edge is drawn in.
PIECES = 24
#: How far behind what a pixel sees a line may lie and still be seen, in pixels, where the surface faces the viewer.
BEHIND = 2.5
#: Where it is seen edge on, its depth changes much within the two pixels around a line, but not by more than this many.
STEEP = 60.0
#: Cosine of normal and view up to which a surface that just turns away counts as seen: that far it is on the outline.
EDGE_ON = 0.1


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
    edge
        (N,) which of the surface's edges each is of, or None where that is not asked for.
    """

    ends: Float
    angle_deg: Float
    inner: Bool
    edge: Int | None = None


def edge_lines(surface: Surface, camera: Camera, facets: Facets, buffer: Buffer) -> Lines:
    """Return the visible pieces of all edges between patches and on the boundary.

    A piece is seen where the picture shows one of the patches beside it, there or next to it and about as near, or
    where nothing is nearer. So edges that run along an outline are seen as a whole or not at all.
    """
    size = len(buffer.facet) // GRID
    edges = surface.edges
    t = np.arange(PIECES + 1) / PIECES
    middles = 0.5 * (t[1:] + t[:-1])
    points = surface.side_jets(edges.left, t, 0).f
    # where a patch has no normal the line is looked for as if it faced the viewer
    with np.errstate(invalid="ignore", divide="ignore"):
        left = surface.side_jets(edges.left, middles, 1).normal
        right = surface.side_jets(edges.right, 1.0 - middles, 1).normal
        angle = np.degrees(angle_between(left, right))
    angle[edges.boundary] = np.nan
    screen = camera.screen(points.reshape(-1, 3), size).reshape(len(edges), PIECES + 1, 3)
    between = 0.5 * (screen[:, 1:] + screen[:, :-1])
    around, outer = _Around.of(between, buffer), _outer_side(facets, camera)
    with np.errstate(invalid="ignore"):
        seen = between[..., 2] >= around.depth.max(axis=-1) - BEHIND
    for sides, normals in ((edges.left, left), (edges.right, right)):
        seen |= _beside(between, sides, dot(normals, camera.towards), facets, outer, around)
    ends = np.stack([screen[:, :-1, :2], screen[:, 1:, :2]], axis=2)
    inner = np.broadcast_to(edges.within_face[:, None], seen.shape)
    number = np.broadcast_to(np.arange(len(edges))[:, None], seen.shape)
    return Lines(ends[seen], angle[seen], inner[seen], number[seen])


def in_front(screen: Float, buffer: Buffer) -> Bool:
    """(...) true where points (..., 3) in pixels are not behind what their samples see."""
    with np.errstate(invalid="ignore"):
        seen: Bool = screen[..., 2] >= buffer.depth[_samples(screen, buffer)] - BEHIND
    return seen


@dataclass(frozen=True, eq=False)
class _Around:
    """What the nine samples about points (...) see: facets (..., 9), -1 for none, and their depths.

    Parameters
    ----------
    facet, depth
        As said.
    """

    facet: Int
    depth: Float

    @classmethod
    def of(cls, screen: Float, buffer: Buffer) -> Self:
        row, column = _samples(screen, buffer)
        last = len(buffer.facet) - 1
        i, j = (axis.ravel() for axis in np.indices((3, 3)) - 1)
        at = (row[..., None] + i).clip(0, last), (column[..., None] + j).clip(0, last)
        return cls(buffer.facet[at], buffer.depth[at])


def _beside(screen: Float, sides: PatchSides, facing: Float, facets: Facets, outer: Bool, around: _Around) -> Bool:
    """(E, S) true where a sample at points (E, S, 3), or one next to it, sees the patch (E,) of their side there.

    ``facing`` (E, S) is the cosine of normal and view, ``outer`` (T,) tells of facets whether their outer side is seen.
    """
    reach = BEHIND + (3.0 / np.nan_to_num(np.abs(facing), nan=1.0).clip(1e-9, None)).clip(None, STEEP)
    own = around.facet >= 0
    own &= facets.part[around.facet] == sides.part[:, None, None]
    own &= facets.patch[around.facet] == sides.patch[:, None, None]
    with np.errstate(invalid="ignore"):
        own &= ~(np.where(outer[around.facet], facing[..., None], -facing[..., None]) < -EDGE_ON)
        own &= np.abs(around.depth - screen[..., 2:]) <= reach[..., None]
    seen: Bool = np.any(own, axis=-1)
    return seen


def _outer_side(facets: Facets, camera: Camera) -> Bool:
    """(T,) true for facets whose outer side is seen: their corners run clockwise, as pixels count downwards."""
    corners = camera.screen(facets.points, 1)[facets.corners, :2]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    outer: Bool = first[:, 0] * second[:, 1] <= first[:, 1] * second[:, 0]
    return outer


def _samples(screen: Float, buffer: Buffer) -> tuple[Int, Int]:
    """Row and column of the samples that points (..., 3) in pixels fall into."""
    last = len(buffer.facet) - 1
    with np.errstate(invalid="ignore"):
        column, row = (np.nan_to_num(screen[..., i] * GRID).clip(0, last).astype(np.int64) for i in (0, 1))
    return row, column
