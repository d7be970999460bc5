"""Surfaces as triangles: points of every patch with exact normals and curvatures, and which of them are one place.

All patches are divided alike, so that the points of neighbours on their common side pair up. Two of them are one place
where the surface says that they belong together (a common corner, a common side of patches) and where they agree to
:data:`AGREEMENT`; they then have the same coordinates to the last bit. Where patches leave a gap, the gap stays.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.errors import TestbedError
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float, Int, norm
from testbed.harness.claims import CLOSED
from testbed_reports.rendering.facets import lattice_facets

#: Triangles of a tessellation, about, unless asked for otherwise.
TRIANGLES: Final = 50_000
#: Distance up to which points of neighbours are one place, relative to the diagonal of the box around the mesh.
AGREEMENT: Final = CLOSED
#: Points evaluated at once.
CHUNK: Final = 16_384


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Triangles on a surface; every patch has points of its own, with its own values there.

    Parameters
    ----------
    points
        (N, 3); those of one place are equal to the last bit.
    normals
        (N, 3) unit normals of the patch; NaN where it has none.
    gauss, mean
        (N,) curvatures of the patch; NaN where it has none, as at the corners of blended patches.
    distance
        (N,) distance from the exact surface, NaN where that was not found; None where no surface is known.
    place
        (N,) which place each point is at, 0 to M - 1 in the order of their first points.
    triangles
        (T, 3) ids of points, counterclockwise seen from the side of the normal; none has two corners at one place.
    part, patch, face
        (T,) which patch each triangle lies on, and the mesh face that came from.
    """

    points: Float
    normals: Float
    gauss: Float
    mean: Float
    distance: Float | None
    place: Int
    triangles: Int
    part: Int
    patch: Int
    face: Int

    @property
    def scalars(self) -> dict[str, Float]:
        """The scalar fields by name, (N,) each."""
        found = {"gauss": self.gauss, "mean": self.mean}
        return found if self.distance is None else {**found, "distance": self.distance}


def tessellate(surface: Surface, triangles: int = TRIANGLES, exact: ExactSurface | None = None) -> Tessellation:
    """Divide a surface into triangles.

    Parameters
    ----------
    surface
        The surface.
    triangles
        How many, about and at most; a triangular patch has at least one, and one of four sides at least two.
    exact
        The surface that distances are taken from.

    Raises
    ------
    TestbedError
        A patch has a point that is no number; the message names the face.
    PluginError
        The patches make no surface.
    """
    steps = steps_within(surface, triangles)
    jets = [_values(part, steps) for part in surface.parts]
    points, normals, gauss, mean = (np.concatenate(columns) for columns in zip(*jets, strict=True))
    first = _first_points(surface, steps)
    rows, parts, patches, faces = [], [], [], []
    for index, part in enumerate(surface.parts):
        count, pattern = len(part.batch), lattice_facets(part.batch.sides, steps)
        size = len(lattice(part.batch.sides, steps))
        rows.append((first[index] + size * np.arange(count)[:, None, None] + pattern).reshape(-1, 3))
        parts.append(np.full(count * len(pattern), index))
        patches.append(np.repeat(np.arange(count), len(pattern)))
        faces.append(np.repeat(part.faces, len(pattern)))
    place = places(surface, steps, points)
    leader = np.unique(place, return_index=True)[1]
    points = points[leader][place]
    corners = np.concatenate(rows)
    at = place[corners]
    # what is left of a triangle on a side that is a single point
    whole = (at != np.roll(at, 1, axis=1)).all(axis=1)
    distance = None if exact is None else _distances(points[leader], exact)[place]
    of_patches = (np.concatenate(column)[whole] for column in (parts, patches, faces))
    return Tessellation(points, normals, gauss, mean, distance, place, corners[whole], *of_patches)


def steps_within(surface: Surface, triangles: int) -> int:
    """Return the parts a side of every patch is divided into, so that there are no more triangles, if one allows it."""
    squares = sum(len(part.batch) * (part.batch.sides - 2) for part in surface.parts)
    return max(1, int(np.sqrt(triangles / max(squares, 1))))


def places(surface: Surface, steps: int, points: Float) -> Int:
    """Which place each point is at, (N,): numbered in the order of the first point of each.

    Parameters
    ----------
    surface
        The surface.
    steps
        The parts that sides are divided into.
    points
        (N, 3) the points of ``domain.lattice(sides, steps)`` of all patches of all parts, one after the other.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    box = surface.mesh.points.max(axis=0) - surface.mesh.points.min(axis=0)
    near = AGREEMENT * float(norm(box))
    one, other = np.concatenate(list(_meetings(surface, steps)), axis=1)
    agree = norm(points[one] - points[other]) <= near
    one, other = one[agree], other[agree]
    links = coo_array((np.ones(len(one), dtype=np.bool_), (one, other)), shape=(len(points), len(points)))
    label = np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
    first, inverse = np.unique(label, return_index=True, return_inverse=True)[1:]
    place: Int = np.argsort(np.argsort(first))[inverse]
    return place


def side_places(sides: int, steps: int) -> Int:
    """Positions in ``domain.lattice(sides, steps)`` of the points along each side, as it runs, (sides, steps + 1)."""
    k, zero = np.arange(steps + 1), np.zeros(steps + 1, dtype=np.int64)
    if sides == 4:
        i, j = np.stack([k, zero + steps, k[::-1], zero]), np.stack([zero, k, zero + steps, k[::-1]])
        return np.asarray(i * (steps + 1) + j)
    i, j = np.stack([k, k[::-1], zero]), np.stack([zero, k, k[::-1]])
    return np.asarray(i * (steps + 1) - i * (i - 1) // 2 + j)


def _first_points(surface: Surface, steps: int) -> Int:
    """Where the points of each part begin, and where the last end."""
    counts = [len(part.batch) * len(lattice(part.batch.sides, steps)) for part in surface.parts]
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _meetings(surface: Surface, steps: int) -> Iterator[Int]:
    """Pairs (2, n) of points that are the same point of the surface, if the patches there agree."""
    first = _first_points(surface, steps)
    tables = {sides: side_places(sides, steps) for sides in (3, 4)}
    sizes = {sides: len(lattice(sides, steps)) for sides in (3, 4)}
    # all patches at a corner
    ids, points = [], []
    for index, part in enumerate(surface.parts):
        sides, patch = part.batch.sides, np.arange(len(part.batch))[:, None]
        ids.append(part.corner_ids.ravel())
        points.append((first[index] + sizes[sides] * patch + tables[sides][:, 0]).ravel())
        # a side that runs from a corner to the same corner is a single point
        chosen, side = np.nonzero(part.corner_ids == np.roll(part.corner_ids, -1, axis=1))
        on_side = first[index] + sizes[sides] * chosen[:, None] + tables[sides][side]
        yield np.stack([on_side[:, 1:].ravel(), np.repeat(on_side[:, 0], steps)])
    corner, at = np.concatenate(ids), np.concatenate(points)
    _, leader, inverse = np.unique(corner, return_index=True, return_inverse=True)
    yield np.stack([at, at[leader][inverse]])
    # the two patches along an edge
    edges = surface.edges
    edges = edges[edges.interior]
    sides_of = np.array([part.batch.sides for part in surface.parts])
    along = np.empty((2, len(edges), steps + 1), dtype=np.int64)
    for which, run in enumerate((edges.left, edges.right)):
        for number in (3, 4):
            chosen = sides_of[run.part] == number
            begin = first[run.part[chosen]] + sizes[number] * run.patch[chosen]
            along[which, chosen] = begin[:, None] + tables[number][run.side[chosen]]
    yield np.stack([along[0].ravel(), along[1, :, ::-1].ravel()])


def _values(part: Part, steps: int) -> tuple[Float, Float, Float, Float]:
    """Points, normals and curvatures of a part's patches, one patch after the other."""
    at = lattice(part.batch.sides, steps)
    count = len(part.batch)
    points, normals = np.empty((2, count, len(at), 3))
    gauss, mean = np.empty((2, count, len(at)))
    run = max(1, CHUNK // len(at))
    for start in range(0, count, run):
        some = slice(start, min(start + run, count))
        jet = part.batch.take(some).jets(at, 2)
        # a patch without a normal at a place has NaN there
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            found = analyse(jet)
            points[some], normals[some] = jet.f, jet.normal
        gauss[some], mean[some] = found.gauss, found.mean
    lost = ~np.isfinite(points).all(axis=(1, 2))
    if lost.any():
        raise TestbedError(
            f"the patch on face {part.faces[lost][0]} has points that are no numbers: there is no surface to write, "
            "see what `testbed check` says of the scheme"
        )
    return points.reshape(-1, 3), normals.reshape(-1, 3), gauss.ravel(), mean.ravel()


def _distances(points: Float, exact: ExactSurface) -> Float:
    """Distances from the exact surface, (N,)."""
    result = np.empty(len(points))
    for start in range(0, len(points), CHUNK):
        some = points[start : start + CHUNK]
        result[start : start + CHUNK] = norm(some - exact.closest(some))
    return result
