"""A scheme under check: its surfaces over the meshes, fitted once, and the samples at which surfaces are compared."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from testbed.conformance.meshes import Case, cases
from testbed.errors import Refused
from testbed.geometry.domain import barycentric
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, norm
from testbed.plugins.scheme import Scheme

#: Parameters at which surfaces are compared: inner points, also near edges, and points on every side.
TRIANGLE_SAMPLES = np.array(
    [[0.31, 0.36], [0.12, 0.07], [0.05, 0.81], [0.83, 0.06], [0.45, 0.42], [0.4, 0.0], [0.37, 0.63], [0.0, 0.71]]
)
SQUARE_SAMPLES = np.array([[0.5, 0.5], [0.13, 0.21], [0.77, 0.34], [0.2, 0.93], [0.4, 0.0], [1.0, 0.3], [0.6, 1.0]])


class Status(Enum):
    """What came of a property."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_CLAIMED = "not claimed"
    NOT_TESTABLE = "not testable"


@dataclass(frozen=True)
class Outcome:
    """What came of one property.

    Parameters
    ----------
    property
        Its name.
    status
        Passed, failed, not claimed, or not testable (no mesh of the suite was accepted that could show it).
    detail
        The worst value seen, or the witness of a failure: mesh, face or vertex, parameter, value and bound.
    """

    property: str
    status: Status
    detail: str


@dataclass(frozen=True)
class Subject:
    """A scheme with its surfaces over the meshes it accepted.

    Parameters
    ----------
    scheme
        The scheme under check.
    accepted
        Meshes with the surfaces built on them.
    refused
        Meshes it refused, with its reasons.
    """

    scheme: Scheme
    accepted: tuple[tuple[Case, Surface], ...]
    refused: tuple[tuple[Case, str], ...]

    @classmethod
    def of(cls, scheme: Scheme) -> "Subject":
        """Fit the scheme to every mesh of the suite that has faces it takes."""
        accepted: list[tuple[Case, Surface]] = []
        refused: list[tuple[Case, str]] = []
        for case in (case for sides in scheme.domain for case in cases(sides)):
            try:
                accepted.append((case, scheme.fit(case.mesh)))
            except Refused as refusal:
                refused.append((case, refusal.reason))
        return cls(scheme, tuple(accepted), tuple(refused))


@dataclass(frozen=True)
class Worst:
    """The largest value of a property seen so far, and where.

    Parameters
    ----------
    value
        The value; NaN outranks every number.
    where
        Mesh, face or vertex, parameter.
    """

    value: float = -np.inf
    where: str = ""

    def or_worse(self, value: float, where: str) -> "Worst":
        """Return the worse of this and another value."""
        if np.isnan(self.value) or self.value >= value:
            return self
        return Worst(value, where)

    def outcome(self, name: str, bound: float, unit: str) -> Outcome:
        """Passed if the value is at most the bound; NaN fails."""
        if self.value == -np.inf:
            return Outcome(name, Status.NOT_TESTABLE, "no mesh of the suite that the scheme accepts can show it")
        passed = self.value <= bound
        relation = "at most" if passed else "above"
        detail = f"{self.value:.2g} {unit}, {relation} {bound:.2g}, on {self.where}"
        return Outcome(name, Status.PASSED if passed else Status.FAILED, detail)


def size(mesh: HermiteMesh) -> float:
    """Diagonal of the bounding box, the length that tolerances are relative to."""
    return float(norm(np.ptp(mesh.points, axis=0)))


def sample_places(mesh: HermiteMesh) -> tuple[Int, Float]:
    """Return faces (N,) and face parameters (N, 2) at which surfaces over this mesh are compared."""
    samples = TRIANGLE_SAMPLES if mesh.sides == 3 else SQUARE_SAMPLES
    face = np.repeat(np.arange(len(mesh.faces)), len(samples))
    return face, np.tile(samples, (len(mesh.faces), 1))


def points_at(surface: Surface, face: Int, at: Float) -> Float:
    """Points (N, 3) of the surface at face parameters (N, 2)."""
    bary = barycentric(at) if surface.mesh.sides == 3 else at
    return surface.evaluate(face, bary, order=0).f


def normals_at(surface: Surface, face: Int, at: Float) -> Float:
    """Unit normals (N, 3) of the surface at face parameters (N, 2)."""
    bary = barycentric(at) if surface.mesh.sides == 3 else at
    return surface.evaluate(face, bary, order=1).normal


def vertices_of(surface: Surface) -> Iterator[tuple[int, Int, Int, Int]]:
    """For each part its index, and the patches, corners and mesh vertices where a patch corner is a mesh vertex."""
    for index, part in enumerate(surface.parts):
        patch, corner = np.nonzero(part.corner_ids < len(surface.mesh.points))
        yield index, patch, corner, part.corner_ids[patch, corner]
