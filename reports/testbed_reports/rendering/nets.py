"""Control nets in pictures, as far as they are not hidden by the surface."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from testbed.geometry.bernstein import multi_indices, triangle_degree
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.lines import in_front
from testbed_reports.rendering.visibility import GRID, Buffer

#: Pieces that a line between two control points is drawn in.
PIECES = 16


@dataclass(frozen=True, eq=False)
class Net:
    """Control nets as a picture shows them.

    Parameters
    ----------
    ends
        (N, 2, 2) where visible pieces of its lines begin and end, in pixels to the right and downwards.
    points
        (M, 2) visible control points.
    """

    ends: Float
    points: Float

    def __len__(self) -> int:
        return len(self.points)


def control_net(surface: Surface, camera: Camera, buffer: Buffer) -> Net | None:
    """Return what is seen of the control nets of all Bezier patches; None where no patch is a Bezier patch."""
    size = len(buffer.facet) // GRID
    nets = _nets(surface)
    if not nets:
        return None
    # what two patches share is drawn twice: sorting it out costs more
    ends = np.concatenate([net[:, pairs].reshape(-1, 2, 3) for net, pairs in nets])
    t = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
    along = ends[:, :1] * (1.0 - t) + ends[:, 1:] * t
    screen = camera.screen(along.reshape(-1, 3), size).reshape(*along.shape)
    seen = in_front(0.5 * (screen[:, 1:] + screen[:, :-1]), buffer)
    pieces = np.stack([screen[:, :-1, :2], screen[:, 1:, :2]], axis=2)[seen]
    places = camera.screen(control_points(surface), size)
    return Net(pieces, places[in_front(places, buffer)][:, :2])


def control_points(surface: Surface) -> Float:
    """Control points (N, 3) of all Bezier patches of a surface, shared ones repeated."""
    return np.concatenate([net.reshape(-1, 3) for net, _ in _nets(surface)] or [np.empty((0, 3))])


def _nets(surface: Surface) -> list[tuple[Float, Int]]:
    """Nets (P, n, 3) of the parts that have any, with the pairs (L, 2) of neighbours in each."""
    nets: list[tuple[Float, Int]] = []
    for part in surface.parts:
        match part.batch:
            case BezierTriangles() | RationalBezierTriangles() as batch:
                nets.append((batch.control_points, _triangle_pairs(triangle_degree(batch.control_points.shape[1]))))
            case BezierQuads() as batch:
                rows, columns = batch.control_points.shape[1:3]
                nets.append((batch.control_points.reshape(len(batch), -1, 3), _quad_pairs(rows, columns)))
    return nets


@cache
def _triangle_pairs(degree: int) -> Int:
    """Neighbours (L, 2) in the net of a triangle."""
    indices = multi_indices(degree)
    apart = np.abs(indices[:, None] - indices[None]).sum(axis=-1)
    pairs: Int = np.argwhere(np.triu(apart == 2))
    return pairs


@cache
def _quad_pairs(rows: int, columns: int) -> Int:
    """Neighbours (L, 2) in the net of a quadrilateral."""
    place = np.arange(rows * columns).reshape(rows, columns)
    down = np.stack([place[:-1], place[1:]], axis=-1).reshape(-1, 2)
    right = np.stack([place[:, :-1], place[:, 1:]], axis=-1).reshape(-1, 2)
    return np.concatenate([down, right])
