"""Interpolation reads off how far a surface is from its data at the vertices, and what it leaves out it cannot know."""

import numpy as np
import pytest

from testbed.conformance.meshes import octahedron
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.measures.interpolation import Interpolation
from testbed.plugins.measure import Value, measure_all
from testbed.registry import scheme


def read(surface: Surface) -> dict[str, Value]:
    return measure_all([Interpolation()], surface, None)


def flat(mesh: HermiteMesh, offset: float = 0.0) -> Surface:
    net = mesh.corner_points().copy()
    net[3, 1, 2] += offset
    return Surface.over_faces(mesh, BezierTriangles(net))


def test_flat_faces_of_the_octahedron_are_off_by_known_amounts() -> None:
    row = read(flat(octahedron()))
    assert row["vertex_distance_max"] == 0.0
    # the angle between a face's normal (1, 1, 1) and an axis
    assert row["vertex_normal_max_deg"] == pytest.approx(np.degrees(np.arccos(1.0 / np.sqrt(3.0))), abs=1e-12)
    # the flat faces have no second form, and the sphere's is I - n n^T
    assert row["vertex_form_max"] == pytest.approx(1.0, abs=1e-15)


def test_a_moved_corner_is_found_with_its_vertex() -> None:
    mesh = octahedron()
    row = read(flat(mesh, 0.25))
    assert row["vertex_distance_max"] == pytest.approx(0.25, abs=1e-15)
    assert row["vertex_distance_vertex"] == mesh.faces[3, 1]


def test_what_matches_second_forms_shows_it() -> None:
    row = read(scheme("cubic-interpolant").fit(octahedron()))
    assert max(float(row[name]) for name in ("vertex_distance_max", "vertex_normal_max_deg", "vertex_form_max")) < 1e-9


def test_columns_are_left_out_where_there_is_no_such_number() -> None:
    mesh = octahedron()
    assert not {"vertex_normal_max_deg", "vertex_form_max"} & set(read(flat(mesh.without_normals())))
    assert "vertex_form_max" not in read(flat(mesh.without_second_forms()))
    assert "vertex_form_max" not in read(scheme("nielson").fit(mesh))
    assert "vertex_normal_max_deg" in read(scheme("nielson").fit(mesh))


def test_nan_is_never_a_pass() -> None:
    assert np.isnan(float(read(flat(octahedron(), np.nan))["vertex_distance_max"]))
