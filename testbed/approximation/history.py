"""What an adaptive approximation did: a record a step, levels of refinement, and how it ended."""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from testbed.approximation.division import Division
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between

#: Why an approximation stopped.
Stop: TypeAlias = Literal[
    "reached", "most steps", "most faces", "smallest angle", "refused", "no progress", "rounding", "not finite"
]


@dataclass(frozen=True)
class Step:
    """One mesh of an approximation and what was measured on it.

    Parameters
    ----------
    step
        How often the mesh was refined before.
    faces, vertices
        Size of the mesh.
    patches, control_points, shared_control_points
        Patches of the surface, their control points, and these with equal ones counted once; None where patches have no
        control points.
    epsilon_deg
        Largest angle between the normals of neighbouring patches: the guaranteed upper bound if there is one, else the
        largest that was found.
    epsilon_found_deg
        The lower bound of it: an angle that was found.
    epsilon_sampled_deg
        The same at ten places of each edge.
    epsilon_certified
        Whether ``epsilon_deg`` is guaranteed.
    distance, distance_found, distance_certified
        The largest distance of the surface to the exact one, likewise.
    smallest_angle_deg
        Smallest angle of the mesh's triangles.
    edges_jumping, faces_distant
        Edges and faces that exceed their bounds.
    edges_split
        Edges that were split next, those that a conforming mesh of good angles demands included.
    fallbacks
        What the scheme or its curves had to do differently, counted.
    seconds
        Time it took.
    """

    step: int
    faces: int
    vertices: int
    patches: int
    control_points: int | None
    shared_control_points: int | None
    epsilon_deg: float
    epsilon_found_deg: float
    epsilon_sampled_deg: float
    epsilon_certified: bool
    distance: float
    distance_found: float
    distance_certified: bool
    smallest_angle_deg: float
    edges_jumping: int
    faces_distant: int
    edges_split: int
    fallbacks: int
    seconds: float


@dataclass(frozen=True, eq=False)
class Levels:
    """How often each face and each edge was refined.

    Parameters
    ----------
    faces
        (F,) divisions that a face comes from, one a step at most.
    edges
        (E,) halvings that an edge comes from; an edge that was drawn within a face has that of the new faces.
    """

    faces: Int
    edges: Int

    @classmethod
    def of_start(cls, mesh: HermiteMesh) -> "Levels":
        """Return the levels of a mesh that was not refined: zeros."""
        return cls(np.zeros(len(mesh.faces), dtype=np.int64), np.zeros(len(mesh.edges), dtype=np.int64))

    def refined(self, mesh: HermiteMesh, division: Division, finer: HermiteMesh) -> "Levels":
        """Return the levels of a division of a mesh.

        Parameters
        ----------
        mesh
            The mesh that these are the levels of.
        division
            Its division.
        finer
            The mesh of the division's faces.
        """
        faces = (self.faces + division.divided_parents(len(mesh.faces)))[division.parent]
        # edges drawn within a face, until found to be an edge of before or half of one
        edges = faces[finer.edge_faces.max(axis=1)]
        kept = np.ones(len(mesh.edges), dtype=np.bool_)
        kept[division.split] = False
        middle = len(mesh.points) + np.arange(len(division.split))
        start, end = mesh.edges[division.split].T
        low = np.concatenate([mesh.edges[kept, 0], start, end])
        high = np.concatenate([mesh.edges[kept, 1], middle, middle])
        level = np.concatenate([self.edges[kept], np.tile(self.edges[division.split] + 1, 2)])
        count = len(finer.points)
        # finer.edges are in lexicographic order
        place = np.searchsorted(finer.edges @ np.array([count, 1]), low * count + high)
        edges[place] = level
        return Levels(faces, edges)


@dataclass(frozen=True, eq=False)
class Approximation:
    """How an adaptive approximation ended.

    Parameters
    ----------
    stop
        Why it stopped.
    reason
        The same in a sentence.
    surface
        The last surface; None if there was none, because the scheme refused the start mesh.
    mesh
        The mesh of that surface, or the start mesh that the scheme refused.
    levels
        Levels of refinement of its faces and edges.
    edge_jumps_deg
        (E,) largest angle of the normals across each edge of the mesh, 0 on the boundary; NaN without a surface.
    face_distances
        (F,) largest distance of each face's patches; NaN without a surface.
    history
        A record for each mesh that had a surface.
    """

    stop: Stop
    reason: str
    surface: Surface | None
    mesh: HermiteMesh
    levels: Levels
    edge_jumps_deg: Float
    face_distances: Float
    history: tuple[Step, ...]

    @classmethod
    def of_start(cls, mesh: HermiteMesh, levels: Levels) -> "Approximation":
        """Return the approximation that has no surface yet."""
        edges, faces = np.full(len(mesh.edges), np.nan), np.full(len(mesh.faces), np.nan)
        return cls("refused", "", None, mesh, levels, edges, faces, ())

    def with_surface(
        self, surface: Surface, levels: Levels, angles: Float, apart: Float, step: Step
    ) -> "Approximation":
        """Return the approximation by a surface with angles (E,) in radians on its mesh's edges and distances (F,)."""
        return replace(
            self,
            surface=surface,
            mesh=surface.mesh,
            levels=levels,
            edge_jumps_deg=np.degrees(angles),
            face_distances=apart,
            history=(*self.history, step),
        )

    def ended(self, stop: Stop, reason: str) -> "Approximation":
        """Return the approximation as it ended, and why."""
        return replace(self, stop=stop, reason=reason)

    @property
    def reached(self) -> bool:
        """Whether all bounds were reached."""
        return self.stop == "reached"


def smallest_angle(mesh: HermiteMesh) -> float:
    """Return the smallest angle of the faces, radians."""
    corners = mesh.corner_points()
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return float(angle_between(ahead, back).min())


def control_point_counts(surface: Surface) -> tuple[int | None, int | None]:
    """Return the control points of all patches, and these with equal ones counted once; None where there are none."""
    nets = [getattr(batch, "control_points", None) for batch in surface.batches]
    known = [net.reshape(-1, 3) for net in nets if isinstance(net, np.ndarray)]
    if len(known) < len(nets):
        return None, None
    points = np.concatenate([np.empty((0, 3)), *known])
    # neighbours share their curves to the last bit; -0.0 is 0.0
    return len(points), len(np.unique(points + 0.0, axis=0))
