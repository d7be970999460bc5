"""Triangles divided at the middles of their sides: what comes of a mesh when some of its edges are split."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int, norm

#: Triangles that one triangle is divided into, by local points: corners 0, 1, 2 and the middle 3 + s of side s.
Pattern: TypeAlias = tuple[tuple[int, int, int], ...]

#: Lengths that differ relatively by less count as equal, so that rounding does not decide between them.
TIE: Final = 1e-9

#: Barycentric coordinates of the local points.
LOCAL_POINTS: Final = np.array(
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]]
)


@dataclass(frozen=True, eq=False)
class Division:
    """A triangulation whose triangles are parts of another's.

    Parameters
    ----------
    split
        (M,) the edges of the old mesh that are split, ascending; the middle of ``split[m]`` is vertex V + m.
    faces
        (N, 3) vertex ids of the children, each oriented as its parent; ordered by parent.
    parent
        (N,) the face that each child is a part of, or all of.
    bary
        (N, 3, 3) barycentric coordinates in the parent of the child's corners.
    """

    split: Int
    faces: Int
    parent: Int
    bary: Float

    def divided_parents(self, count: int) -> Bool:
        """(count,) true for the parents that have more than one child."""
        divided: Bool = np.bincount(self.parent, minlength=count) > 1
        return divided


class Splitting(ABC):
    """A rule by which a mesh of triangles is divided where edges are marked; conforming, orientation kept.

    Attributes
    ----------
    name
        What the command line calls it.
    """

    name: str

    @abstractmethod
    def closed(self, mesh: HermiteMesh, marked: Bool) -> Bool:
        """Return the edges (E,) that have to be split so that the marked ones (E,) can be."""

    @abstractmethod
    def divide(self, mesh: HermiteMesh, split: Bool, middles: Float) -> Division:
        """Divide a mesh at the middles (M, 3) of its split edges (E,), which are closed under the rule."""


def rotated(pattern: Pattern, side: int) -> Pattern:
    """Return a pattern that does at side ``side`` what the given one does at side 0."""
    turned = [*((corner + side) % 3 for corner in range(3)), *(3 + (middle + side) % 3 for middle in range(3))]
    return tuple((turned[a], turned[b], turned[c]) for a, b, c in pattern)


def divide_by(mesh: HermiteMesh, split: Bool, code: Int, patterns: Mapping[int, Pattern]) -> Division:
    """Divide every face (F,) by the pattern that its code (F,) names.

    Parameters
    ----------
    mesh
        The mesh.
    split
        (E,) the edges that are split; patterns use the middles of these only.
    code
        (F,) a key of ``patterns`` for each face.
    patterns
        The patterns.
    """
    chosen = np.flatnonzero(split)
    middle = np.full(len(mesh.edges), -1, dtype=np.int64)
    middle[chosen] = len(mesh.points) + np.arange(len(chosen))
    points = np.concatenate([mesh.faces, middle[mesh.face_edges]], axis=1)  # (F, 6) ids of the local points
    children = np.zeros(len(mesh.faces), dtype=np.int64)
    for key, pattern in patterns.items():
        children[code == key] = len(pattern)
    first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(children)])
    local = np.empty((int(first[-1]), 3), dtype=np.int64)
    for key, pattern in patterns.items():
        (own,) = np.nonzero(code == key)
        local[first[own][:, None] + np.arange(len(pattern))] = np.array(pattern)
    parent = np.repeat(np.arange(len(mesh.faces)), children)
    faces = np.take_along_axis(points[parent], local, axis=1)
    return Division(chosen, faces, parent, LOCAL_POINTS[local])


def side_mask(mesh: HermiteMesh, split: Bool) -> Int:
    """(F,) which sides of a face are split: bit s for side s."""
    mask: Int = split[mesh.face_edges] @ np.array([1, 2, 4])
    return mask


def longest_sides(mesh: HermiteMesh) -> Int:
    """(F,) the longest side of each face; of equally long ones that with the smallest edge id.

    The order of the edges by length is one for all faces, so that a chain of ever longer edges ends.
    """
    ends = mesh.points[mesh.edges]
    size = np.round(np.log(norm(ends[:, 1] - ends[:, 0])) / TIE)
    order = np.lexsort((-np.arange(len(size)), size))
    rank = np.empty(len(size), dtype=np.int64)
    rank[order] = np.arange(len(size))
    longest: Int = rank[mesh.face_edges].argmax(axis=1)
    return longest
