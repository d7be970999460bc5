"""Bodies close above a plane: other datasets, turned and moved."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, cross, unit
from testbed.plugins.dataset import Dataset
from testbed_datasets.icosahedron import Icosahedron
from testbed_datasets.parameters import finite, positive

#: Lengths that directions may have.
LENGTHS = (1e-100, 1e100)


@dataclass(frozen=True)
class Lifted(Dataset):
    """A mesh turned and moved until its lowest vertex is a little above a plane.

    A smooth surface through the vertices of a closed mesh usually reaches lower than they do, and so does the surface
    they are of. A scheme that keeps to one side of the plane has to change what it would do without it. Only of the
    mesh of ``level`` the lowest vertex has the clearance; vertices of finer levels may be below the plane, as the
    surface is.

    Parameters
    ----------
    of
        What is lifted.
    level
        Its level that is level 0 here.
    plane
        a, b, c, d of the plane a x + b y + c z + d = 0; the positive side is above it.
    up
        The direction of ``of`` that is turned into the plane's normal (a, b, c).
    clearance
        Distance of the lowest vertex from the plane, relative to the longest extent of the mesh along an axis.
    """

    of: Dataset = Icosahedron()
    level: int = 1
    plane: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 0.0)
    up: tuple[float, float, float] = (0.36, 0.48, 0.8)
    clearance: float = 0.005

    name = "lifted"
    title = "A body close above a plane"
    reference = "Not in the thesis: made for Si Ping 2015, planes below closed meshes"
    closed = None
    finest = 0
    # the surfaces are those of other datasets
    compared = False

    def __post_init__(self) -> None:
        positive(self.name, clearance=self.clearance)
        if self.level < 0:
            raise SpecError(f"parameter level of lifted cannot be {self.level}: levels start at 0")
        for parameter, vector in (("plane", self.plane[:3]), ("up", self.up)):
            if not LENGTHS[0] < math.hypot(*vector) < LENGTHS[1]:
                raise SpecError(
                    f"parameter {parameter} of lifted cannot have the direction {vector}: give one of a length between "
                    f"{LENGTHS[0]:g} and {LENGTHS[1]:g}"
                )
        finite(self.name, plane=self.plane[3] / math.hypot(*self.plane[:3]))

    @cached_property
    def _placement(self) -> tuple[Float, Float]:
        """Rotation (3, 3) and translation (3,)."""
        length = math.hypot(*self.plane[:3])
        normal = np.array(self.plane[:3]) / length
        rotation = turning(np.array(self.up) / math.hypot(*self.up), normal)
        points = self.of.mesh(self.level).points
        room = self.clearance * float(np.ptp(points, axis=0).max())
        lowest = float(rotated(rotation, points).dot(normal).min()) + self.plane[3] / length
        return rotation, (room - lowest) * normal

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level; Refused where what is lifted has none."""
        if level < 0:
            raise Refused(f"{self.name} has no level {level}: levels start at 0")
        try:
            mesh = self.of.mesh(self.level + level)
        except Refused as error:
            raise Refused(f"level {level} of {self.name} is level {self.level + level}: {error.reason}") from error
        return mesh.transformed(*self._placement)

    @property
    def surface(self) -> ExactSurface | None:
        """The exact surface, turned and moved, or None where there is none."""
        surface = self.of.surface
        return None if surface is None else MovedSurface(surface, *self._placement)


class MovedSurface(ExactSurface):
    """An exact surface, rotated and then translated.

    Parameters
    ----------
    surface
        The surface before.
    rotation, translation
        (3, 3) and (3,).
    """

    def __init__(self, surface: ExactSurface, rotation: Float, translation: Float) -> None:
        self._surface = surface
        self._rotation = rotation
        self._translation = translation

    def _back(self, points: Float) -> Float:
        return rotated(self._rotation.T, points - self._translation)

    def _there(self, points: Float) -> Float:
        return rotated(self._rotation, points) + self._translation

    def closest(self, points: Float) -> Float:
        """Feet (N, 3) of the surface before, moved."""
        known = np.isfinite(points).all(axis=1)
        feet = np.full(points.shape, np.nan)
        feet[known] = self._there(self._surface.closest(self._back(points[known])))
        return feet

    def normal(self, points: Float) -> Float:
        """Unit normals (N, 3), turned."""
        return rotated(self._rotation, self._surface.normal(self._back(points)))

    def second_form(self, points: Float) -> Float:
        """Second fundamental forms (N, 3, 3), turned; symmetric to the last bit."""
        R = self._rotation
        turned = np.einsum("ij,njk,lk->nil", R, self._surface.second_form(self._back(points)), R)
        symmetric: Float = 0.5 * (turned + turned.swapaxes(-1, -2))
        return symmetric

    def middles(self, start: Float, end: Float, boundary: Bool) -> Float:
        """Points (E, 3) of the surface between points of it, as the surface before has them."""
        return self._there(self._surface.middles(self._back(start), self._back(end), boundary))

    def sampled_gradients(self, points: Float) -> Float | None:
        """Gradients (V, 3), turned; None without such."""
        gradients = self._surface.sampled_gradients(self._back(points))
        return None if gradients is None else rotated(self._rotation, gradients)


def rotated(rotation: Float, vectors: Float) -> Float:
    """Vectors (N, 3) turned by a rotation (3, 3), each by itself to the last bit."""
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in rotation], axis=-1)


def turning(start: Float, end: Float) -> Float:
    """Rotation (3, 3) that turns a unit vector (3,) into another by the smallest angle, at most half a turn.

    Two reflections make a rotation: the first turns the start about, the second, across start + end, the rest of the
    way. That loses digits where the two are nearly opposite; there half a turn about the same axis comes before it.
    """
    before = np.eye(3)
    if start.dot(end) < 0.0:
        axis = cross(start, end)
        axis = axis if axis.any() else np.eye(3)[np.abs(start).argmin()]
        axis = unit(axis)
        # a short product of vectors is not quite perpendicular
        axis = unit(axis - axis.dot(start) * start)
        before = 2.0 * np.outer(axis, axis) - np.eye(3)
        start = -start
    return reflection(start + end) @ reflection(start) @ before


def reflection(across: Float) -> Float:
    """Reflection (3, 3) in the plane through the origin across a vector (3,)."""
    matrix: Float = np.eye(3) - 2.0 * np.outer(across, across) / across.dot(across)
    return matrix
