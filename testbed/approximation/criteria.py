"""What decides where a mesh is split: the jump of the normal across edges, and the distance of faces.

The thesis samples the normals at ten places of an edge and says that this misses what is between them; the exact
criterion takes the largest angle wherever on the edge it is. Its measure of a jump says nothing of features that the
patches leave out on both sides, such as a bump between the vertices; the distance criterion bounds how far each face is
from the exact surface, everywhere in the face.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from testbed.approximation.division import longest_sides
from testbed.geometry.domain import lattice
from testbed.geometry.edges import PatchEdges
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int, norm
from testbed.measures.continuity import edge_jumps, grained
from testbed.measures.edge_angles import edge_angles
from testbed.measures.face_distances import Aim, face_distances, largest_distance
from testbed.measures.feet import projected
from testbed.measures.sampling import chunks

#: How the jump of the normal on an edge is found.
Criterion: TypeAlias = Literal["exact", "sampled"]

#: A face this many times too far from the exact surface is halved at all sides, others at their longest: halving all
#: gains as much where the distance is of order four. On ellipsoids and tori to 1e-4 .. 1e-6 of
#: their size, splitting all sides of every distant face makes 10 to 60 percent more faces, and splitting only longest
#: ones up to 40 percent more faces and twice as many steps.
FAR: Final = 16.0

_HALF: Final = grained(np.arange(5) / 9.0)
#: How near to each other the bounds of a distance are asked to be, relative to it or to what is allowed.
SHARPNESS: Final = 0.05
#: Steps along a side of the lattice on which distances are sampled where they cannot be bounded.
LATTICE_STEPS: Final = 8
#: Ten places of an edge, its ends included (section 5.3), symmetric under t -> 1 - t to the last bit.
TEN_SAMPLES: Final = np.concatenate([_HALF, 1.0 - _HALF[::-1]])


@dataclass(frozen=True, eq=False)
class Jumps:
    """Largest angles between the normals of neighbouring patches, radians.

    Parameters
    ----------
    edges
        The E edges between patches, inner edges of split faces included.
    sampled
        (E,) at ten places of the edge.
    low, high
        (E,) lower and upper bounds of the largest angle on the whole edge; high is infinite without a guarantee.
    """

    edges: PatchEdges
    sampled: Float
    low: Float
    high: Float

    @property
    def certified(self) -> bool:
        """Whether the upper bounds are guaranteed."""
        return bool(np.isfinite(self.high).all())

    def values(self, criterion: Criterion) -> Float:
        """(E,) what is compared with the bound: the samples, or the guaranteed bound, or the largest that was found."""
        return self.sampled if criterion == "sampled" else np.where(np.isfinite(self.high), self.high, self.low)


def jumps(surface: Surface) -> Jumps:
    """Measure the jumps of the normal on all edges between the patches of a surface."""
    found = edge_angles(surface)
    return Jumps(found.edges, edge_jumps(surface, found.edges, TEN_SAMPLES)[0].max(axis=1), found.low, found.high)


@dataclass(frozen=True, eq=False)
class Distances:
    """Largest distances of the patches of each mesh face to the exact surface.

    Parameters
    ----------
    low, high
        (F,) lower and upper bounds; high is infinite where there is no guarantee.
    largest
        Lower and upper bound of the largest of all, which may be closer to each other.
    """

    low: Float
    high: Float
    largest: tuple[float, float]

    @property
    def certified(self) -> bool:
        """Whether the upper bounds are guaranteed."""
        return math.isfinite(self.largest[1])

    @property
    def values(self) -> Float:
        """(F,) what is compared with the bound: the guaranteed bound, or the largest distance that was found."""
        return np.where(np.isfinite(self.high), self.high, self.low)


def distances(surface: Surface, exact: ExactSurface, allowed: float | None) -> Distances:
    """Bound the distances of all faces to the exact surface.

    Parameters
    ----------
    surface, exact
        The surfaces.
    allowed
        The distance that faces are compared with: bounds are refined until they tell which exceed it. None to sample
        the distances only.
    """
    found = sampled_distances(surface, exact)
    most = largest(found)
    low, high = np.zeros(len(found)), np.full(len(found), np.inf)
    if allowed is not None:
        bounds = face_distances(surface, exact, SHARPNESS * allowed, threshold=allowed)
        low, high = bounds.low, bounds.high
    if not np.isfinite(high).all():
        return Distances(np.maximum(low, found), high, (most, math.inf))
    # of faces that are too far away the bounds above may be rough
    together = largest_distance(surface, exact, Aim(0.0, SHARPNESS))
    return Distances(np.maximum(low, found), high, (max(most, together[0]), min(float(high.max()), together[1])))


def sampled_distances(surface: Surface, exact: ExactSurface) -> Float:
    """Largest distances (F,) of the faces' patches at a lattice of points; NaN where one has no foot."""
    result = np.zeros(len(surface.mesh.faces))
    for part in surface.parts:
        at = lattice(part.batch.sides, LATTICE_STEPS)
        for some in chunks(len(part.batch), len(at)):
            points = part.batch.take(some).jets(at, 0).f
            with np.errstate(invalid="ignore"):  # NaN stays
                np.maximum.at(result, part.faces[some], norm(points - projected(exact, points)).max(axis=1))
    return result


def edges_that_jump(mesh: HermiteMesh, edges: PatchEdges, above: Bool) -> Bool:
    """Return the mesh edges (E,) to split where patch edges jump too much.

    Parameters
    ----------
    mesh
        The mesh that the surface was built on.
    edges
        Edges between patches.
    above
        Which of them jump too much. One between two faces marks the mesh edge that these share, an inner edge of a face
        all sides of the face. **Fill**: a marked face whose longest side is on the boundary, where nothing can jump, is
        split there too; without that its triangles get ever flatter.
    """
    left, right = edges.left.face[above], edges.right.face[above]
    marked = edges_of_faces(mesh, left[left == right])
    left, right = left[left != right], right[left != right]
    ours, theirs = mesh.face_edges[left], mesh.face_edges[right]
    shared = (ours[:, :, None] == theirs[:, None, :]).any(axis=2)
    marked[ours[shared]] = True
    longest = np.take_along_axis(mesh.face_edges, longest_sides(mesh)[:, None], axis=1)[:, 0]
    marked[longest[marked[mesh.face_edges].any(axis=1) & mesh.boundary_edges[longest]]] = True
    return marked


def edges_too_distant(mesh: HermiteMesh, distant: Bool, far: Bool) -> Bool:
    """Return the mesh edges (E,) to split where faces are too far from the exact surface.

    Parameters
    ----------
    mesh
        The mesh that the surface was built on.
    distant
        (F,) which faces: they are halved at their longest sides.
    far
        (F,) which faces are halved at all sides.
    """
    marked = edges_of_faces(mesh, far)
    marked[np.take_along_axis(mesh.face_edges, longest_sides(mesh)[:, None], axis=1)[distant, 0]] = True
    return marked


def edges_of_faces(mesh: HermiteMesh, faces: Int | Bool) -> Bool:
    """Return the edges (E,) that are sides of some faces."""
    marked = np.zeros(len(mesh.edges), dtype=np.bool_)
    marked[mesh.face_edges[faces]] = True
    return marked


def largest(values: Float) -> float:
    """Return the largest value, NaN if one is, 0 if there are none."""
    return float(values.max(initial=0.0))
