"""Interpolation: how far the surface is from its data at vertices, at every patch that meets there, and at centres."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.domain import CORNERS
from testbed.geometry.jets import Jet
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between, norm
from testbed.measures.centre_errors import MISSED, centre_errors
from testbed.measures.corner_forms import corner_forms
from testbed.measures.extremum import patch_order
from testbed.plugins.measure import Column, Measure, Survey, Value


@dataclass(frozen=True)
class Interpolation(Measure):
    """Distances, angles and differences of second fundamental forms between surface and data.

    At the vertices, and at the centres of faces where the mesh has samples there.

    Blended patches have no second fundamental form at their corners, only limits: the farthest of those along three
    directions counts, so that a form that depends on the direction is not taken for the data's.

    Parameters
    ----------
    blended
        Blended patches whose forms are looked at, evenly chosen among all of them; of other patches all are.
    """

    blended: int = 256

    name: ClassVar[str] = "interpolation"
    title: ClassVar[str] = "Interpolation of the data"
    reference: ClassVar[str] = "a comparison at the vertices"
    columns: ClassVar[tuple[Column, ...]] = (
        Column(
            "vertex_distance_max", "largest distance from a vertex to the surface's point for it, in the mesh's unit"
        ),
        Column("vertex_distance_vertex", "vertex where that is"),
        Column("vertex_normal_max_deg", "largest angle between data and surface normal at a vertex", optional=True),
        Column("vertex_normal_vertex", "vertex where that is", optional=True),
        Column("vertex_form_max", "largest entry of the difference of second fundamental forms, 1/unit", optional=True),
        Column("vertex_form_vertex", "vertex where that is", optional=True),
        Column("centre_distance_max", "largest distance from a sample at a face's centre", optional=True),
        Column("centre_normal_max_deg", "largest angle to the normal of such a sample", optional=True),
        Column("centre_form_max", "largest difference of second forms from such a sample, 1/unit", optional=True),
        Column(
            "centres_missed", f"faces off their samples by more than {MISSED:g}, relative to the size", optional=True
        ),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns for which the mesh has data."""
        surface, mesh = survey.surface, survey.surface.mesh
        worst: dict[str, tuple[float, int]] = {}
        for jet, vertex in vertex_jets(surface, 0 if mesh.normals is None else 1):
            errors = {"distance": norm(jet.f - mesh.points[vertex])}
            if mesh.normals is not None:
                errors["normal"] = np.degrees(angle_between(jet.normal, mesh.normals[vertex]))
            for name, values in errors.items():
                worst[name] = _worse(worst.get(name, (-1.0, -1)), values, vertex)
        if mesh.second_forms is not None:
            for forms, vertex, face in vertex_forms(surface, self.blended):
                corner = (mesh.faces[face] == vertex[:, None]).argmax(axis=1)
                given = mesh.corner_second_forms(face)[np.arange(len(face)), corner]
                values = np.abs(forms - given[:, None]).max(axis=(1, 2, 3))
                worst["form"] = _worse(worst.get("form", (-1.0, -1)), values, vertex)
        units = {"distance": "max", "normal": "max_deg", "form": "max"}
        result: dict[str, Value] = {}
        for name, (value, vertex_id) in worst.items():
            result[f"vertex_{name}_{units[name]}"] = value
            result[f"vertex_{name}_vertex"] = vertex_id
        errors_at_centres = centre_errors(surface)
        if errors_at_centres is not None:
            result["centre_distance_max"] = float(errors_at_centres.distance.max())
            result["centre_normal_max_deg"] = float(np.degrees(errors_at_centres.angle.max()))
            result["centre_form_max"] = float(errors_at_centres.form.max())
            result["centres_missed"] = int(errors_at_centres.missed(float(norm(np.ptp(mesh.points, axis=0)))).sum())
        return result


def vertex_jets(surface: Surface, order: int) -> Iterator[tuple[Jet, Int]]:
    """For each part, jets (rows, N, 3) at the N patch corners that are mesh vertices, and the vertices (N,)."""
    for part in surface.parts:
        patch, corner = np.nonzero(part.corner_ids < len(surface.mesh.points))
        jet = part.batch.jets(CORNERS[part.batch.sides], order)
        yield Jet(jet.coefficients[:, patch, corner]), part.corner_ids[patch, corner]


def vertex_forms(surface: Surface, blended: int) -> Iterator[tuple[Float, Int, Int]]:
    """For each part, second forms (N, D, 3, 3) at patch corners that are vertices, and the vertices and faces, (N,).

    Parameters
    ----------
    blended
        How many blended patches are looked at.
    """
    order = patch_order(surface)
    count = len(surface.mesh.points)
    part_of = np.repeat(np.arange(len(surface.parts)), [len(part.batch) for part in surface.parts])
    margins = np.array([part.batch.corner_margin for part in surface.parts])[part_of]
    at_vertices = np.concatenate([(part.corner_ids < count).any(axis=1) for part in surface.parts])
    chosen = at_vertices & (margins == 0.0)
    among = order[(at_vertices & (margins > 0.0))[order]]
    chosen[among[np.linspace(0, len(among) - 1, min(blended, len(among)), dtype=np.int64)]] = True
    for index, part in enumerate(surface.parts):
        patches = np.flatnonzero(chosen[part_of == index])
        ids = part.corner_ids[patches]
        patch, corner = np.nonzero(ids < count)
        yield corner_forms(part.batch.take(patches))[patch, corner], ids[patch, corner], part.faces[patches][patch]


def _worse(known: tuple[float, int], values: Float, vertices: Int) -> tuple[float, int]:
    """The larger of the known worst and the largest value, with the lowest vertex that has it; NaN is above all."""
    if not len(values) or np.isnan(known[0]):
        return known
    largest = float(values.max())
    at = int(vertices[np.isnan(values) if np.isnan(largest) else values == largest].min())
    return known if known[0] > largest or (known[0] == largest and known[1] <= at) else (largest, at)
