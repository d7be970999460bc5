"""Plugins for the tests of the harness: quick, and as badly behaved as asked. Registered through TESTBED_PLUGINS."""

import ctypes
import os
import signal
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.dataset import Dataset
from testbed.plugins.measure import Column, Measure, Survey, Value
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed.registry import hookimpl

Act: TypeAlias = Literal[
    "work", "raise", "exit", "leave", "kill", "segfault", "hang", "nan", "refuse", "memory", "system-exit", "print"
]


@hookimpl
def testbed_schemes() -> Iterable[str]:
    """Return the schemes below."""
    return [f"{__name__}:Toy", f"{__name__}:Needy"]


@hookimpl
def testbed_datasets() -> Iterable[str]:
    """Return the datasets below."""
    return [f"{__name__}:Grid", f"{__name__}:File"]


@hookimpl
def testbed_measures() -> Iterable[str]:
    """Return the measures below."""
    return [f"{__name__}:Sums", f"{__name__}:Words"]


def act(what: Act) -> None:  # noqa: C901 - a list of misdeeds
    """Behave badly."""
    match what:
        case "raise":
            raise ValueError("a toy\nbroke")
        case "exit":
            os._exit(3)
        case "leave":
            os._exit(0)
        case "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        case "segfault":
            ctypes.string_at(0)
        case "hang":
            time.sleep(3600)
        case "refuse":
            raise Refused("the toy takes no such data at vertex 0")
        case "memory":
            raise MemoryError
        case "system-exit":
            sys.exit(0)
        case "print":
            print("noise")  # noqa: T201


@dataclass(frozen=True)
class Toy(Scheme):
    """The mesh's own triangles, slowly or not at all.

    Parameters
    ----------
    act
        What it does on ``level`` faces = 2 * 4^level; elsewhere it works.
    level
        On which level; -1 for all.
    seconds
        How long it takes.
    tag
        Tells equal toys apart.
    """

    act: Act = "work"
    level: int = -1
    seconds: float = 0.0
    tag: int = 0

    name = "toy"
    title = "Toy"
    reference = "none"
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = 2
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Log the attempt where TOY_LOG says, then act."""
        if "TOY_LOG" in os.environ:
            with Path(os.environ["TOY_LOG"]).open("a") as log:
                log.write(f"{self} {len(mesh.faces)}\n")
        time.sleep(self.seconds)
        if self.level in (-1, round(np.log2(len(mesh.faces) / 2) / 2)):
            act(self.act)
            if self.act == "nan":
                return Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()), {"nan": 1})
        return Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()))


@dataclass(frozen=True)
class Needy(Toy):
    """A toy that reads second fundamental forms."""

    name = "needy"
    needs = Data.POINTS | Data.SECOND_FORMS


class Floor(ExactSurface):
    """The plane z = 0."""

    def closest(self, points: Float) -> Float:
        """Feet of the perpendiculars."""
        return points * [1.0, 1.0, 0.0]

    def normal(self, points: Float) -> Float:
        """Unit normals."""
        return np.broadcast_to([0.0, 0.0, 1.0], points.shape).copy()

    def second_form(self, points: Float) -> Float:
        """Zero."""
        return np.zeros((len(points), 3, 3))


@dataclass(frozen=True)
class Grid(Dataset):
    """A square of 2^level x 2^level cells.

    Parameters
    ----------
    act
        What it does instead.
    sides
        Vertices of a face, 3 or 4.
    forms
        Whether it has normals and second fundamental forms, and an exact surface.
    """

    act: Act = "work"
    sides: int = 3
    forms: bool = True

    name = "grid"
    title = "Grid"
    reference = "none"
    closed: ClassVar[bool | None] = False
    shape = Shape.PLANES
    finest = 2

    def mesh(self, level: int) -> HermiteMesh:
        """Return the grid; no level above 5."""
        act(self.act)
        if level > 5:
            raise Refused(f"the grid ends at level 5, and {level} was asked for")
        count = 2**level
        x, y = np.meshgrid(np.linspace(0.0, 1.0, count + 1), np.linspace(0.0, 1.0, count + 1), indexing="ij")
        points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
        i, j = (index.ravel() for index in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
        a, b = i * (count + 1) + j, (i + 1) * (count + 1) + j
        quads = np.stack([a, b, b + 1, a + 1], axis=-1)
        faces = quads if self.sides == 4 else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return Floor().sample(points, faces) if self.forms else HermiteMesh(points, faces)

    @property
    def surface(self) -> ExactSurface | None:
        """The plane."""
        return Floor() if self.forms else None


@dataclass(frozen=True)
class File(Grid):
    """A grid that claims to be read from a file."""

    path: str = ""

    name = "file"
    positional = "path"
    finest = 0

    def files(self) -> tuple[Path, ...]:
        """The file, if one is named."""
        return (Path(self.path),) if self.path else ()


@dataclass(frozen=True)
class Sums(Measure):
    """Numbers that depend on every bit of the surface."""

    name = "sums"
    title = "Sums"
    reference = "none"
    columns = (
        Column("total", "sum of the control points"),
        Column("distance_max", "a made-up error, h squared", converges=True, exact=True),
        Column("normal_max_deg", "a made-up error, none", converges=True, exact=True),
        Column("epsilon_deg", "none", converges=True),
        Column("gap_max", "none"),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns; NaN for a surface with a note that says so."""
        surface = survey.surface
        points = np.concatenate([batch.jets(np.array([[0.25, 0.25]]), 0).f.ravel() for batch in surface.batches])
        total = float(np.sin(points).sum())
        found: dict[str, Value] = {"total": np.nan if surface.notes else total, "epsilon_deg": 0.0, "gap_max": 0.0}
        if survey.exact is not None:
            found |= {"distance_max": surface.mesh.h**2, "normal_max_deg": 0.0}
        return found


@dataclass(frozen=True)
class Words(Measure):
    """A count and a text, of numpy's types."""

    name = "words"
    title = "Words"
    reference = "none"
    columns = (Column("corners", "corners of the patches"), Column("where", "a text"))

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        corners = np.int64(3 * survey.surface.patch_count)
        return {"corners": corners, "where": f'{corners} corners, and a "comma"'}  # type: ignore[dict-item]
