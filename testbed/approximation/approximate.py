"""The adaptive loop (Mann 1992, section 5.2): sample, fit, measure, split where a bound is exceeded, and again."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np

from testbed.approximation.criteria import (
    FAR,
    Criterion,
    Distances,
    Jumps,
    distances,
    edges_that_jump,
    edges_too_distant,
    jumps,
    largest,
)
from testbed.approximation.division import Splitting
from testbed.approximation.history import Approximation, Levels, Step, Stop, control_point_counts, smallest_angle
from testbed.approximation.longest_edge import LongestEdge
from testbed.approximation.sampled import start_mesh
from testbed.errors import MeshError, Refused, TestbedError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh_checks import named
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Scheme

#: Called with the record of every mesh as it is done.
Note: TypeAlias = Callable[[Step], None]

#: A step makes progress if what exceeds its bound falls below this part of what it was: the largest angle or distance,
#: the length of the edges or the area of the faces.
PROGRESS: Final = 0.99
#: Angles below this times the size of the coordinates over the shortest edge, and distances below this times the size
#: of the coordinates, are rounding.
ROUNDING: Final = 256.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Target:
    """Bounds to reach.

    Parameters
    ----------
    epsilon
        Largest angle between the normals of neighbouring patches, radians.
    distance
        Largest distance to the exact surface; None for any.
    criterion
        Whether the angle is that of the thesis's ten samples of an edge, or the largest on the whole edge.
    """

    epsilon: float
    distance: float | None = None
    criterion: Criterion = "exact"

    def __post_init__(self) -> None:
        """Refuse bounds that are no positive numbers."""
        if not 0.0 < self.epsilon < math.pi:
            raise TestbedError(f"epsilon cannot be {math.degrees(self.epsilon):g} degrees: give more than 0, up to 180")
        if self.distance is not None and not 0.0 < self.distance < math.inf:
            raise TestbedError(f"the distance cannot be {self.distance:g}: give a positive number")


@dataclass(frozen=True)
class Limits:
    """Where to give up.

    Parameters
    ----------
    steps
        Most refinements.
    faces
        Most faces of a mesh.
    angle
        Smallest angle of a refined mesh's faces, radians.
    patience
        Refinements in a row without progress.
    """

    steps: int = 40
    faces: int = 50_000
    angle: float = math.radians(0.5)
    patience: int = 8


@dataclass(frozen=True, eq=False)
class Measured:
    """A surface and where it exceeds the bounds.

    Parameters
    ----------
    surface
        The surface.
    jumps, distances
        What was measured on its edges and faces.
    target
        The bounds.
    """

    surface: Surface
    jumps: Jumps
    distances: Distances
    target: Target

    @cached_property
    def angles(self) -> Float:
        """What counts as the angles on the edges between patches."""
        return self.jumps.values(self.target.criterion)

    @cached_property
    def jumping(self) -> Bool:
        """Which of these edges exceed their bound; what is not a number does."""
        return ~(self.angles <= self.target.epsilon)

    @cached_property
    def distant(self) -> Bool:
        """(F,) which faces exceed their bound, if there is one; what is not a number does."""
        allowed = self.target.distance
        return np.zeros(len(self.distances.low), np.bool_) if allowed is None else ~(self.distances.values <= allowed)

    @cached_property
    def far(self) -> Bool:
        """(F,) which faces exceed it many times over."""
        return self.distant & ~(self.distances.low <= FAR * (self.target.distance or math.inf))

    @property
    def edge_angles(self) -> Float:
        """(E,) largest angle of the normals across each edge of the mesh, radians; 0 where there are no two faces."""
        mesh, edges = self.surface.mesh, self.jumps.edges
        left, right = mesh.face_edges[edges.left.face], mesh.face_edges[edges.right.face]
        shared = (left[:, :, None] == right[:, None, :]).any(axis=2) & ~edges.within_face[:, None]
        result = np.zeros(len(mesh.edges))
        values = np.broadcast_to(self.angles[:, None], shared.shape)
        np.maximum.at(result, left[shared], values[shared])
        return result

    @property
    def marked(self) -> Bool:
        """(E,) edges of the mesh to split."""
        mesh = self.surface.mesh
        return edges_that_jump(mesh, self.jumps.edges, self.jumping) | edges_too_distant(mesh, self.distant, self.far)

    @property
    def exceeding(self) -> tuple[float, float, float, float]:
        """The largest angle and distance above their bounds, minus infinity where none is, and where this is so.

        The latter as the length of the jumping edges between faces and the area of the distant faces.
        """
        angle, distance = self.angles[self.jumping], self.distances.values[self.distant]
        mesh = self.surface.mesh
        ends = mesh.points[mesh.edges[edges_that_jump(mesh, self.jumps.edges, self.jumping)]]
        corners = mesh.corner_points()[self.distant]
        return (
            float(angle.max(initial=-math.inf)),
            float(distance.max(initial=-math.inf)),
            float(norm(ends[:, 1] - ends[:, 0]).sum()),
            float(norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).sum() / 2.0),
        )


def approximate(
    dataset: Dataset,
    scheme: Scheme,
    target: Target,
    *,
    splitting: Splitting | None = None,
    limits: Limits | None = None,
    note: Note | None = None,
) -> Approximation:
    """Refine a mesh on a dataset's exact surface until a scheme's surface over it is within the bounds.

    Parameters
    ----------
    dataset
        Level 0 is the start; new vertices come from the dataset's charts, or by projection onto its surface.
    scheme
        Builds the surface over every mesh.
    target
        The bounds.
    splitting
        How triangles are split; at longest edges if not given. The thesis's templates make up to a third fewer faces
        where all goes well (80 instead of 112 on the ellipsoid to 0.4 degrees, 1280 instead of 1904 on the branch
        surface to 0.04), and triangles with angles of a degree, over which patches fold, on the offset surface.
    limits
        Where to give up.
    note
        Called with the record of every mesh.

    Returns
    -------
    approximation
        The last surface, with the history; bounds that were not reached are no error.

    Raises
    ------
    Refused
        The dataset cannot be refined: no exact surface, no triangles, or a boundary that projection would leave.
    """
    sampled, exact = start_mesh(dataset), dataset.surface
    if exact is None:
        raise Refused(f"{dataset} has charts and no exact surface to measure distances from: give it one")
    if 3 not in scheme.domain:
        raise Refused(f"{scheme} takes no triangles, and only these are split: choose a scheme for triangles")
    splitting, limits = splitting or LongestEdge(), limits or Limits()
    mesh = sampled.mesh
    levels, worst = Levels.of_start(mesh), list[tuple[float, ...]]()
    result = Approximation.of_start(mesh, levels)
    while True:
        began = time.perf_counter()
        try:
            surface = scheme.fit(mesh)
        except Refused as refusal:
            return result.ended("refused", f"{_mesh_after(len(worst))} is refused: {refusal}")
        measured = measure(surface, exact, target)
        split = splitting.closed(mesh, measured.marked)
        record = _record(measured, len(worst), int(split.sum()), began)
        result = result.with_surface(surface, levels, measured.edge_angles, measured.distances.values, record)
        if note is not None:
            note(record)
        worst.append(measured.exceeding)
        ending = _ending(measured, worst, limits)
        if ending is not None:
            return result.ended(*ending)
        try:
            middles = sampled.middles(np.flatnonzero(split))
            division = splitting.divide(mesh, split, middles)
            if len(division.faces) > limits.faces:
                return result.ended(
                    "most faces",
                    f"{_mesh_after(len(worst))} would have {len(division.faces)} faces: {_place(measured)}",
                )
            sampled = sampled.divided(division, middles)
            finer = sampled.mesh
        except (MeshError, Refused) as error:
            return result.ended("refused", f"{_mesh_after(len(worst))} cannot be made: {error}")
        angle = math.degrees(smallest_angle(finer))
        if angle < math.degrees(limits.angle):
            return result.ended(
                "smallest angle",
                f"{_mesh_after(len(worst))} would have an angle of {angle:.3g} degrees: {_place(measured)}",
            )
        mesh, levels = finer, levels.refined(mesh, division, finer)


def measure(surface: Surface, exact: ExactSurface, target: Target) -> Measured:
    """Measure a surface against the bounds."""
    return Measured(surface, jumps(surface), distances(surface, exact, target.distance), target)


def _ending(measured: Measured, worst: Sequence[tuple[float, ...]], limits: Limits) -> tuple[Stop, str] | None:
    """Return why to stop at a surface, if there is a reason; ``worst`` is what exceeded the bounds on every surface."""
    refinements = len(worst) - 1
    if not (measured.jumping.any() or measured.distant.any()):
        return "reached", f"all bounds are reached after {refinements} refinements"
    angle, distance = worst[-1][:2]
    if math.isnan(angle) or math.isnan(distance):
        return "not finite", _not_finite(measured)
    mesh = measured.surface.mesh
    size, ends = float(np.abs(mesh.points).max()), mesh.points[mesh.edges]
    shortest = float(norm(ends[:, 1] - ends[:, 0]).min())
    if angle <= ROUNDING * size / shortest and distance <= ROUNDING * size:
        return "rounding", "what exceeds the bounds is rounding: give larger bounds"
    before, lately = worst[: -limits.patience], worst[-limits.patience :]
    if before and all(
        min(now) >= PROGRESS * was for now, was in zip(zip(*lately, strict=True), before[-1], strict=True)
    ):
        return "no progress", (
            f"the last {limits.patience} refinements did not lower what exceeds the bounds: {_place(measured)}"
        )
    if refinements >= limits.steps:
        return "most steps", f"{limits.steps} refinements are done: {_place(measured)}"
    return None


def _place(measured: Measured) -> str:
    """Return where a surface exceeds its bounds most, in words."""
    mesh, words = measured.surface.mesh, []
    if measured.jumping.any():
        angles = measured.angles
        worst = int(angles.argmax())
        left, right = (side.face[worst] for side in (measured.jumps.edges.left, measured.jumps.edges.right))
        words.append(f"epsilon is {math.degrees(angles[worst]):.3g} degrees between faces {left} and {right}")
    if measured.distant.any():
        apart = measured.distances
        face = int(np.where(measured.distant, apart.low, -1.0).argmax())
        bounds = f"{apart.low[face]:.3g}" + (f" to {apart.high[face]:.3g}" if math.isfinite(apart.high[face]) else "")
        words.append(f"the distance is {bounds} in {named(mesh.faces, face)}")
    return " and ".join(words)


def _not_finite(measured: Measured) -> str:
    angles = measured.angles
    if np.isnan(angles).any():
        edges, bad = measured.jumps.edges, int(np.isnan(angles).argmax())
        return (
            f"the normal has no direction on the edge between faces {edges.left.face[bad]} and {edges.right.face[bad]}"
        )
    face = int(np.isnan(measured.distances.values).argmax())
    return (
        f"face {face} has a point with no foot on the exact surface: the mesh may be too far away from it there, start "
        "from a finer one"
    )


def _mesh_after(refinements: int) -> str:
    return f"the mesh after {refinements} refinements" if refinements else "the start mesh"


def _record(measured: Measured, step: int, split: int, began: float) -> Step:
    surface, angles, apart = measured.surface, measured.jumps, measured.distances
    mesh = surface.mesh
    control_points, shared = control_point_counts(surface)
    return Step(
        step=step,
        faces=len(mesh.faces),
        vertices=len(mesh.points),
        patches=surface.patch_count,
        control_points=control_points,
        shared_control_points=shared,
        epsilon_deg=math.degrees(largest(angles.values("exact"))),
        epsilon_found_deg=math.degrees(largest(angles.low)),
        epsilon_sampled_deg=math.degrees(largest(angles.sampled)),
        epsilon_certified=angles.certified,
        distance=apart.largest[1] if apart.certified else apart.largest[0],
        distance_found=apart.largest[0],
        distance_certified=apart.certified,
        smallest_angle_deg=math.degrees(smallest_angle(mesh)),
        edges_jumping=int(measured.jumping.sum()),
        faces_distant=int(measured.distant.sum()),
        edges_split=split,
        fallbacks=sum(surface.notes.values()),
        seconds=time.perf_counter() - began,
    )
