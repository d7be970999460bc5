"""Surfaces sampled for a viewer: exact points, normals, curvatures and distances on a lattice in every patch."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.geometry.curvature import analyse
from testbed.geometry.domain import CORNERS, corner_distance, lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int, angle_between, norm

#: Points evaluated at once.
CHUNK: Final = 16_384
#: Share of the way to the middle of a patch that a place moves where the patch has no normal or curvature.
INWARD: Final = 1e-3


@dataclass(frozen=True, eq=False)
class PartSamples:
    """Samples of P patches with the same lattice of S points, ``domain.lattice(sides, steps)``.

    Parameters
    ----------
    sides
        3 or 4.
    faces
        (P,) mesh faces.
    corners
        (P, sides, 2) where the patches' corners are in their faces.
    points, normals
        (P, S, 3); NaN where a patch has none.
    gauss, mean
        (P, S) curvatures; NaN where a patch has none.
    distance
        (P, S) distances from the exact surface; NaN where there is none.
    """

    sides: int
    faces: Int
    corners: Float
    points: Float
    normals: Float
    gauss: Float
    mean: Float
    distance: Float


@dataclass(frozen=True, eq=False)
class SampledSurface:
    """Samples of a surface.

    Parameters
    ----------
    steps
        Steps along the sides of the lattice in each patch.
    parts
        The samples of its parts.
    edge_patch, edge_side
        (E,) patch, counted through all parts, and its side, of each edge between patches and on the boundary.
    edge_angle
        (E, steps + 1) angle between the normals on both sides in degrees, as the side runs; NaN on the boundary.
    """

    steps: int
    parts: tuple[PartSamples, ...]
    edge_patch: Int
    edge_side: Int
    edge_angle: Float

    @property
    def points(self) -> Float:
        """All points that are known, (N, 3)."""
        every = np.concatenate([np.empty((0, 3)), *(part.points.reshape(-1, 3) for part in self.parts)])
        known: Float = every[np.isfinite(every).all(axis=-1)]
        return known

    def values(self, field: str) -> Float:
        """All values of ``gauss``, ``mean``, ``distance`` or ``jump``, (N,)."""
        if field == "jump":
            return self.edge_angle.ravel()
        return np.concatenate([np.empty(0), *(getattr(part, field).ravel() for part in self.parts)])

    @property
    def triangles(self) -> int:
        """How many triangles the lattices make."""
        return sum(len(part.faces) * (part.sides - 2) for part in self.parts) * self.steps**2


def sampled(surface: Surface, steps: int, exact: ExactSurface | None = None) -> SampledSurface:
    """Evaluate a surface on lattices.

    Parameters
    ----------
    steps
        Steps along the sides of patches.
    exact
        The surface that distances are asked from, or None.
    """
    parts = tuple(
        _part(part.batch, part.faces, part.corners_in_face, lattice(part.batch.sides, steps), exact)
        for part in surface.parts
    )
    first = np.cumsum([0, *(len(part.batch) for part in surface.parts)])
    left = surface.edges.left
    patch = first[left.part] + left.patch
    order = np.lexsort((left.side, patch))
    return SampledSurface(steps, parts, patch[order], left.side[order], _angles(surface, steps)[order])


def _part(batch: PatchBatch, faces: Int, corners: Float, at: Float, exact: ExactSurface | None) -> PartSamples:
    """Sample a batch on a lattice (S, 2)."""
    shape = (len(batch), len(at))
    points, normals = np.empty((*shape, 3)), np.empty((*shape, 3))
    gauss, mean, distance = np.full((3, *shape), np.nan)
    for some in _chunks(*shape):
        jet = batch.take(some).jets(at, 2)
        # a patch without a normal at a place has NaN there
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            analysis = analyse(jet)
        points[some], normals[some] = jet.f, analysis.normal
        gauss[some], mean[some] = analysis.gauss, analysis.mean
        if exact is not None:
            places = jet.f.reshape(-1, 3)
            distance[some] = norm(places - exact.closest(places)).reshape(jet.f.shape[:-1])
    # where the formula is singular the limits depend on the direction: that from the middle is taken
    unsure = np.isnan(normals).any(axis=-1) | np.isnan(gauss) | np.isnan(mean) | _near_corners(batch, at)
    _look_inward(batch, at, unsure, normals, gauss, mean)
    return PartSamples(batch.sides, faces, corners, points, normals, gauss, mean, distance)


def _near_corners(batch: PatchBatch, at: Float) -> Bool:
    """(S,) true where curvature is not to be asked for, nearer to a corner than the margin."""
    near: Bool = corner_distance(batch.sides, at, batch.collapsed) < batch.corner_margin
    return near


def _look_inward(batch: PatchBatch, at: Float, unsure: Bool, normals: Float, gauss: Float, mean: Float) -> None:
    """Fill in normals and curvatures of the places (P, S) that are unsure from a little inside the patch."""
    patch, place = np.nonzero(unsure)
    if not len(patch):
        return
    share = max(INWARD, 4.0 * batch.corner_margin)
    moved = (1.0 - share) * at[place] + share * CORNERS[batch.sides].mean(axis=0)
    for some in np.array_split(np.arange(len(patch)), -(-len(patch) // CHUNK)):
        jet = batch.take(patch[some]).jets(moved[some][:, None], 2)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            analysis = analyse(jet)
        here = patch[some], place[some]
        lost = np.isnan(normals[here])
        normals[here] = np.where(lost, analysis.normal[:, 0], normals[here])
        gauss[here], mean[here] = analysis.gauss[:, 0], analysis.mean[:, 0]


def _angles(surface: Surface, steps: int) -> Float:
    """Angles (E, steps + 1) in degrees between the normals along all edges; NaN on the boundary."""
    edges = surface.edges
    t = np.arange(steps + 1) / steps
    angle = np.full((len(edges), steps + 1), np.nan)
    (interior,) = np.nonzero(edges.interior)
    for some in np.array_split(interior, max(1, -(-len(interior) * len(t) // CHUNK))):
        left, right = surface.edge_jets(edges[some], t, 1)
        with np.errstate(invalid="ignore"):
            angle[some] = np.degrees(angle_between(left.normal, right.normal))
    return angle


def _chunks(patches: int, points: int) -> Iterator[slice]:
    """Slices of patches with at most ``CHUNK`` points, or one patch."""
    run = max(1, CHUNK // points)
    return (slice(start, min(start + run, patches)) for start in range(0, patches, run))
