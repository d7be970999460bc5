"""Interpolation: how far the surface is from its data at the vertices, at every patch that meets there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS
from testbed.geometry.jets import Jet
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between, norm
from testbed.plugins.measure import Column, Measure, Survey, Value


@dataclass(frozen=True)
class Interpolation(Measure):
    """Distances, angles and differences of second fundamental forms between surface and data at the vertices.

    Second fundamental forms are left out on blended patches, whose second derivatives have no limit at their corners.
    """

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
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns for which the mesh has data."""
        surface, mesh = survey.surface, survey.surface.mesh
        blended = any(batch.corner_margin > 0.0 for batch in surface.batches)
        order = 0 if mesh.normals is None else 1 if mesh.second_forms is None or blended else 2
        worst: dict[str, tuple[float, int]] = {}
        for jet, vertex in vertex_jets(surface, order):
            errors = {"distance": norm(jet.f - mesh.points[vertex])}
            if mesh.normals is not None:
                errors["normal"] = np.degrees(angle_between(jet.normal, mesh.normals[vertex]))
            if mesh.second_forms is not None and not blended:
                errors["form"] = np.abs(second_form_matrix(jet) - mesh.second_forms[vertex]).max(axis=(1, 2))
            for name, values in errors.items():
                worst[name] = _worse(worst.get(name, (-1.0, -1)), values, vertex)
        units = {"distance": "max", "normal": "max_deg", "form": "max"}
        result: dict[str, Value] = {}
        for name, (value, vertex_id) in worst.items():
            result[f"vertex_{name}_{units[name]}"] = value
            result[f"vertex_{name}_vertex"] = vertex_id
        return result


def vertex_jets(surface: Surface, order: int) -> Iterator[tuple[Jet, Int]]:
    """For each part, jets (rows, N, 3) at the N patch corners that are mesh vertices, and the vertices (N,)."""
    for part in surface.parts:
        patch, corner = np.nonzero(part.corner_ids < len(surface.mesh.points))
        jet = part.batch.jets(CORNERS[part.batch.sides], order)
        yield Jet(jet.coefficients[:, patch, corner]), part.corner_ids[patch, corner]


def _worse(known: tuple[float, int], values: Float, vertices: Int) -> tuple[float, int]:
    """The larger of the known worst and the largest value, with the lowest vertex that has it; NaN is above all."""
    if not len(values) or np.isnan(known[0]):
        return known
    largest = float(values.max())
    at = int(vertices[np.isnan(values) if np.isnan(largest) else values == largest].min())
    return known if known[0] > largest or (known[0] == largest and known[1] <= at) else (largest, at)
