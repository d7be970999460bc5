"""Networks of tangents over random heights, and what the restriction promises for them, for tests."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.inverse_area_normals import inverse_area_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, dot, tangential, unit
from testbed_datasets.scattered import Scattered
from testbed_schemes.mathematics.linear_g1 import LinearG1, SharedEdge, linear_g1
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate
from testbed_schemes.mathematics.range_restriction import RestrictedEdges, restrict_range
from testbed_schemes.mathematics.range_restriction_network import LegNetwork

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Problem:
    """A mesh with normals, legs from chords projected along a direction, and a plane below it."""

    mesh: HermiteMesh
    legs: Float
    direction: Float
    heights: Float

    @classmethod
    def over(
        cls, mesh: HermiteMesh, direction: Float = UP, offset: float = 0.0, along: Float | None = None
    ) -> "Problem":
        assert mesh.normals is not None
        ends, normals = mesh.edges, mesh.normals[mesh.edges]
        chord = mesh.points[ends[:, ::-1]] - mesh.points[ends]
        if along is None:
            legs = tangential(chord, normals) / 4.0
        else:
            legs = (chord - (dot(chord, normals) / dot(along, normals))[..., None] * along) / 4.0
        return cls(mesh, legs, direction, dot(mesh.points, direction) + offset)

    @property
    def network(self) -> LegNetwork:
        return LegNetwork.of_mesh(self.mesh)

    @property
    def bounds(self) -> Float:
        return lower_ordinate(*self.heights[self.mesh.faces].T)

    def solve(self, restricted: bool = True) -> RestrictedEdges:
        """Restrict it to the plane's upper side, or to nothing."""
        bounds = self.bounds if restricted else np.full(len(self.mesh.faces), np.inf)
        assert self.mesh.normals is not None
        return restrict_range(
            self.network, self.mesh.points, self.mesh.normals, self.legs, self.direction, self.heights, bounds
        )

    def above(self, points: Float) -> Float:
        """Heights (E, n) of points (E, n, 3) that belong to edges."""
        start = self.mesh.edges[:, 0]
        return self.heights[start, None] + dot(points - self.mesh.points[start][:, None], self.direction)

    def shared(self, found: RestrictedEdges) -> tuple[SharedEdge, LinearG1]:
        """Return the interior edges as they were found, and their condition."""
        network, mesh = self.network, self.mesh
        inside = network.interior
        left, right = (beside[inside] for beside in network.beside(found.legs))
        c, ends = found.boundary[inside], mesh.edges[inside]
        assert mesh.normals is not None
        n0, n1 = mesh.normals[ends[:, 0]], mesh.normals[ends[:, 1]]
        start, end = c[:, 0], c[:, 4]
        beside = start + left[:, 0], end + left[:, 1], start + right[:, 0], end + right[:, 1]
        edge = SharedEdge(c, *beside, found.kappa[inside], n0, n1)
        return edge, linear_g1(edge)


def noise(seed: int, height: float = 0.5, ground: float = 0.01) -> Problem:
    """Independent heights over 34 sites."""
    mesh = Scattered(field="noise", seed=seed, normals="estimated", height=height, ground=ground).mesh(0)
    return Problem.over(mesh, along=UP)


def dry(seed: int) -> Problem:
    """Heights of which many are zero, with the plane's normal there."""
    return Problem.over(Scattered(field="rainfall", seed=seed).mesh(0), along=UP)


def surrounded(heights: Float, centre: float, fall: float | None = None) -> Problem:
    """A vertex with upright normal in the middle of a regular polygon of others, with heights.

    The surface falls towards the middle at the polygon's vertices as steeply as told, or as the normals by areas say.
    """
    count = len(heights)
    angles = 2.0 * np.pi * np.arange(count) / count
    points = np.column_stack(
        [np.append(np.cos(angles), 0.0), np.append(np.sin(angles), 0.0), np.append(heights, centre)]
    )
    ids = np.arange(count)
    faces = np.column_stack([np.full(count, count), ids, np.roll(ids, -1)])
    normals = inverse_area_normals(points, faces)
    if fall is not None:
        normals = unit(UP - fall * points * (1.0 - UP))
    normals[count] = UP
    return Problem.over(HermiteMesh(points, faces, normals), along=UP)
