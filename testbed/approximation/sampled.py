"""Meshes sampled from an exact surface, which can be refined: new vertices come from charts, or by projection."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from testbed.approximation.division import Division
from testbed.errors import Refused
from testbed.geometry.charted import ChartedMesh
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, norm
from testbed.plugins.dataset import Dataset

#: Levels of a dataset on which a projection is compared with the boundary that the dataset itself has.
COMPARED_LEVELS: Final = 2
#: A projected middle is on the boundary if it is this near to a vertex there, relative to the longest edge.
ON_BOUNDARY: Final = 1e-9


class SampledMesh(ABC):
    """A triangle mesh with its data and the surface that they were sampled from; immutable."""

    @property
    @abstractmethod
    def mesh(self) -> HermiteMesh:
        """The mesh with positions, normals and second fundamental forms."""

    @abstractmethod
    def middles(self, edges: Int) -> Float:
        """Points (M, 3) of the surface that take the middles of edges (M,) of the mesh.

        Raises
        ------
        Refused
            The surface has no such point; the message names the edge.
        """

    @abstractmethod
    def divided(self, division: Division, middles: Float) -> "SampledMesh":
        """Return the mesh of a division's faces, whose new vertices are these middles (M, 3) of the split edges."""


@dataclass(frozen=True, eq=False)
class ChartSampled(SampledMesh):
    """A mesh in the charts of a surface: the middle of an edge is that of its parameters.

    Parameters
    ----------
    charted
        The mesh in the charts.
    """

    charted: ChartedMesh

    @cached_property
    def mesh(self) -> HermiteMesh:
        """The sampled mesh."""
        return self.charted.sampled()

    def middles(self, edges: Int) -> Float:
        """Points (M, 3) at the middles of the edges' parameters, in the chart of one of their faces."""
        face = self.mesh.edge_faces[edges].max(axis=1)
        side = (self.mesh.face_edges[face] == edges[:, None]).argmax(axis=1)
        at = self.charted.at
        middle = 0.5 * (at[face, side] + at[face, (side + 1) % 3])
        return self.charted.charts.jets(self.charted.chart[face], middle, order=0).f

    def divided(self, division: Division, middles: Float) -> "ChartSampled":
        """Return the mesh of a division's faces."""
        del middles
        return ChartSampled(self.charted.split(division.faces, division.parent, division.bary))


@dataclass(frozen=True, eq=False)
class Projected(SampledMesh):
    """A mesh on a surface without charts: the middle of an edge is the foot of the perpendicular from the chord's.

    Parameters
    ----------
    exact
        The surface.
    points
        (V, 3) points on it.
    faces
        (F, 3) vertex ids.
    """

    exact: ExactSurface
    points: Float
    faces: Int

    @cached_property
    def mesh(self) -> HermiteMesh:
        """The sampled mesh."""
        return self.exact.sample(self.points, self.faces)

    def middles(self, edges: Int) -> Float:
        """Feet (M, 3) of the perpendiculars from the middles of the chords."""
        ends = self.points[self.mesh.edges[edges]]
        feet = self.exact.middles(ends[:, 0], ends[:, 1], self.mesh.boundary_edges[edges])
        lost = ~np.isfinite(feet).all(axis=1)
        if lost.any():
            start, end = self.mesh.edges[edges[lost]][0].tolist()
            raise Refused(
                f"the exact surface has no foot for the middle of the edge from vertex {start} to vertex {end}: "
                "start from a finer mesh"
            )
        return feet

    def divided(self, division: Division, middles: Float) -> "Projected":
        """Return the mesh of a division's faces."""
        return Projected(self.exact, np.concatenate([self.points, middles]), division.faces)


def start_mesh(dataset: Dataset) -> SampledMesh:
    """Return the mesh of level 0 of a dataset, ready to be refined.

    Raises
    ------
    Refused
        The dataset has no exact surface, its faces are no triangles, or it has a boundary that projection onto the
        surface would leave.
    """
    charted = dataset.charted()
    if charted is not None:
        return ChartSampled(charted)
    exact = dataset.surface
    if exact is None:
        raise Refused(
            f"{dataset} has no exact surface to take new points from: approximate a dataset that has one, or compare "
            f"schemes on this mesh with testbed run -d {dataset}"
        )
    mesh = dataset.mesh(0)
    if mesh.sides != 3:
        raise Refused(f"{dataset} has faces of {mesh.sides} sides: take a dataset of triangles, only these are split")
    result = Projected(exact, mesh.points, mesh.faces)
    if mesh.boundary_edges.any():
        _check_boundary(dataset, exact, mesh)
    return result


def _check_boundary(dataset: Dataset, exact: ExactSurface, mesh: HermiteMesh) -> None:
    """Refuse a dataset whose boundary at the next levels is not where projection puts the middles of its edges."""
    for level in range(1, COMPARED_LEVELS + 1):
        on_boundary = mesh.boundary_edges
        feet = Projected(exact, mesh.points, mesh.faces).middles(np.flatnonzero(on_boundary))
        finer = dataset.mesh(level)
        there = finer.points[finer.boundary_vertices]
        away = norm(feet[:, None] - there).min(axis=1)
        if (away > ON_BOUNDARY * mesh.h).any():
            worst = int(away.argmax())
            start, end = mesh.edges[on_boundary][worst].tolist()
            raise Refused(
                f"{dataset} has a boundary that projection would leave, by {away[worst]:.1g} at the middle of the edge "
                f"from vertex {start} to vertex {end} of level {level - 1}: give the dataset charts "
                "(Dataset.charted), or take a closed surface"
            )
        mesh = finer
