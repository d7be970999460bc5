"""Pictures of surfaces that papers print, drawn again: of schemes, on meshes and on adaptive approximations."""

import dataclasses
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from testbed import registry
from testbed.approximation.approximate import Limits, Target, approximate
from testbed.approximation.history import Approximation
from testbed.approximation.templates import Template
from testbed.errors import TestbedError
from testbed.geometry.bezier import BezierQuads
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed_reports.redrawn import Redrawn, Shown
from testbed_reports.refinement_plot import level_key, level_map
from testbed_reports.rendering.colouring import OUTER
from testbed_reports.rendering.figure import Additions, Edges, Subject, write_figure
from testbed_reports.rendering.legends import Key

#: What approximations are made with, as by ``testbed approximate``.
APPROXIMANT: Final = "cubic-interpolant[boundary=hermite[guard=(0.15 0.75)],reach=0.2]"
#: Colours of surfaces of which the lines matter, and of planes.
PLAIN: Final = np.array([0.97, 0.97, 0.98])
PLANE: Final = np.array([0.97, 0.86, 0.55])
#: Which edges are drawn, by the words of the table.
EDGES: Final[Mapping[str, Edges]] = MappingProxyType(
    {"": None, "all": True, "none": False, "mesh": "mesh", "kinds": "kinds"}
)
#: How far a plane reaches beyond the mesh, relative to that.
BEYOND: Final = 0.12


def draw_surfaces(path: Path, picture: Redrawn) -> Path:
    """Write a picture of surfaces; TestbedError if a scheme does not take its data or a bound is not reached."""
    return write_figure(
        path,
        subjects_of(picture),
        picture.style,
        size=picture.size,
        view=picture.view,
        limit=picture.limit,
        columns=picture.columns,
        title=picture.caption,
        additions=Additions(
            edges=EDGES[picture.edges],
            net=picture.net,
            extremes=picture.extremes,
            key=_key(picture),
            heading="level: faces" if any(one.colour == "levels" for one in picture.shows) else "",
        ),
    )


def subjects_of(picture: Redrawn) -> list[Subject]:
    """Return what a picture shows."""
    return [_subject(one) for one in picture.shows]


def _subject(one: Shown) -> Subject:
    dataset, scheme = registry.dataset(one.dataset), registry.scheme(one.scheme)
    found = approximation(one.dataset, one.epsilon, one.step) if one.epsilon > 0.0 else None
    surface = scheme.fit(dataset.mesh(one.level) if found is None else found.mesh)
    if one.faces:
        surface = of_faces(surface, one.faces)
    colours: list[Float] | None = None
    if one.colour == "levels" and found is not None:
        colours = list(level_map(found, surface))
    elif one.colour == "plain" or one.plane:
        colours = [np.tile(PLAIN if one.colour else OUTER, (len(part.batch), 1)) for part in surface.parts]
    if one.plane and colours is not None:
        surface = with_plane(surface, one.plane)
        colours.append(PLANE[None])
    return Subject(
        one.title,
        surface,
        dataset.surface,
        style=one.style or None,
        view=(one.view[0], one.view[1]) if one.view else None,
        colours=None if colours is None else tuple(colours),
        remark=one.remark or _counts(one, surface),
        highlight=tuple((a, b) for a, b in one.highlight),
        edges=EDGES[one.edges],
    )


def _counts(one: Shown, surface: Surface) -> str | None:
    """What is counted below a picture where not all of it is a surface's faces and patches; else None."""
    if one.faces:
        return f"{surface.patch_count} patches on {len(one.faces)} of {len(surface.mesh.faces)} faces"
    return f"{len(surface.mesh.faces)} faces" if one.plane else None


def _key(picture: Redrawn) -> tuple[Key, ...]:
    """Names of the colours: levels of refinement of the last approximation that shows them, planes."""
    keys: tuple[Key, ...] = ()
    for one in picture.shows:
        if one.colour == "levels":
            keys = level_key(approximation(one.dataset, one.epsilon, one.step))
        elif one.plane and not keys:
            keys = (("surface", _colour(OUTER)), ("plane", _colour(PLANE)))
    return keys


def _colour(colour: Float) -> tuple[float, float, float]:
    r, g, b = colour.tolist()
    return r, g, b


@cache
def approximation(dataset: str, epsilon: float, step: int = -1) -> Approximation:
    """Return an approximation of a dataset's surface, as the table of published figures has it.

    Parameters
    ----------
    dataset
        Text of the dataset.
    epsilon
        Bound of the angle between normals at ten samples of an edge, degrees.
    step
        Refinements; -1 for as many as it takes.

    Raises
    ------
    TestbedError
        The bound is not reached, or was before so many refinements.
    """
    target = Target(math.radians(epsilon), None, "sampled")
    limits = Limits() if step < 0 else Limits(steps=step)
    found = approximate(
        registry.dataset(dataset), registry.scheme(APPROXIMANT), target, splitting=Template(), limits=limits
    )
    if step < 0 and not found.reached:
        raise TestbedError(f"{dataset} is not approximated to {epsilon:g} degrees: {found.reason}")
    if step >= 0 and len(found.history) != step + 1:
        raise TestbedError(
            f"{dataset} reaches {epsilon:g} degrees after {len(found.history) - 1} refinements: name no step beyond"
        )
    return found


def of_faces(surface: Surface, faces: tuple[int, ...]) -> Surface:
    """Return the patches of a surface that came from some faces of its mesh."""
    parts = []
    for part in surface.parts:
        (chosen,) = np.nonzero(np.isin(part.faces, faces))
        strands = None if part.strands is None else part.strands[chosen]
        parts.append(
            Part(
                part.batch.take(chosen),
                part.corner_ids[chosen],
                part.faces[chosen],
                part.corners_in_face[chosen],
                strands,
            )
        )
    if not sum(len(part.batch) for part in parts):
        raise TestbedError(f"there are no patches on faces {', '.join(map(str, faces))}: name faces of the mesh")
    return dataclasses.replace(surface, parts=tuple(parts))


def with_plane(surface: Surface, plane: tuple[float, ...]) -> Surface:
    """Return a surface with one patch more: a piece of the plane a x + b y + c z + d = 0 below its mesh."""
    normal = np.array(plane[:3])
    length = float(norm(normal))
    normal, offset = normal / length, plane[3] / length
    along = np.eye(3)[int(np.argmin(np.abs(normal)))]
    right = unit(along - dot(along, normal) * normal)
    axes = np.stack([right, cross(normal, right)])
    seen = surface.mesh.points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    low, high = low - BEYOND * (high - low), high + BEYOND * (high - low)
    # (u, v) along the two axes, so that the normal points upwards
    grid = np.array([[[low[0], low[1]], [low[0], high[1]]], [[high[0], low[1]], [high[0], high[1]]]])
    piece = BezierQuads((grid @ axes - offset * normal)[None])
    # ids of its own: it joins nothing
    first = len(surface.mesh.points) + len(surface.mesh.faces)
    ids = first + np.arange(4)[None]
    corners = np.zeros((1, 4, 2))
    return dataclasses.replace(surface, parts=(*surface.parts, Part(piece, ids, np.zeros(1, np.int64), corners)))
