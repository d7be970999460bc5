"""Interpolation reads off how far a surface is from its data at the vertices, and what it leaves out it cannot know."""

import numpy as np
import pytest

from testbed.conformance.meshes import octahedron, torus
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.measures.interpolation import Interpolation, vertex_forms
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
    assert "vertex_normal_max_deg" in read(flat(mesh.without_second_forms()))


@pytest.mark.parametrize("mesh", [octahedron(), torus(8, 5, 3)], ids=["octahedron", "torus"])
def test_blended_patches_are_judged_by_the_limits_at_their_corners(mesh: HermiteMesh) -> None:
    assert float(read(scheme("hagen-pottmann").fit(mesh))["vertex_form_max"]) < 1e-8
    # no two directions agree there, and most are far from the data
    assert float(read(scheme("nielson").fit(mesh))["vertex_form_max"]) > 0.1
    assert float(read(scheme("triangular-gregory").fit(mesh))["vertex_form_max"]) > 0.1


def test_the_form_of_one_moved_patch_is_found_with_its_vertex() -> None:
    mesh = torus(8, 5, 3)
    assert mesh.second_forms is not None
    forms = mesh.second_forms.copy()
    forms[7] *= 1.01
    surface = scheme("hagen-pottmann").fit(mesh)
    moved = Surface(HermiteMesh(mesh.points, mesh.faces, mesh.normals, forms), surface.parts)
    row = read(moved)
    assert row["vertex_form_vertex"] == 7
    assert row["vertex_form_max"] == pytest.approx(0.01 * np.abs(mesh.second_forms[7]).max(), rel=1e-6)


def test_blended_patches_are_looked_at_evenly_and_no_more_than_asked_for() -> None:
    surface = scheme("hagen-pottmann").fit(torus(8, 5, 3))
    ((forms, vertex, _),) = vertex_forms(surface, 10)
    assert forms.shape == (30, 3, 3, 3)
    assert len(vertex) == 30
    faces = np.linspace(0, 79, 10, dtype=np.int64)
    np.testing.assert_array_equal(vertex.reshape(10, 3), surface.mesh.faces[faces])


def test_samples_at_face_centres_are_compared_where_there_are_some() -> None:
    mesh = torus(8, 5, 4, twist=1)
    row = read(scheme("bicubic-interpolant[reach=10]").fit(mesh))
    assert row["centres_missed"] == 0
    assert float(row["centre_distance_max"]) < 1e-14
    assert float(row["centre_normal_max_deg"]) < 1e-11
    assert float(row["centre_form_max"]) < 1e-10
    other = read(scheme("zero-twist-bicubic").fit(mesh))
    assert other["centres_missed"] == 40
    assert float(other["centre_distance_max"]) > 1e-3
    assert not [name for name in read(flat(octahedron())) if name.startswith("centre")]


def test_a_centre_that_is_moved_is_missed_by_one_face() -> None:
    mesh = torus(8, 5, 4, twist=1)
    centres = mesh.face_data.centres
    assert centres is not None
    surface = scheme("bicubic-interpolant[reach=10]").fit(mesh)
    points = centres.points.copy()
    points[7, 0] += 0.125
    data = FaceData(Centres(points, centres.normals, centres.second_forms))
    moved = HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms, face_data=data)
    row = read(Surface(moved, surface.parts))
    assert row["centres_missed"] == 1
    assert row["centre_distance_max"] == pytest.approx(0.125, abs=1e-14)


def test_nan_is_never_a_pass() -> None:
    assert np.isnan(float(read(flat(octahedron(), np.nan))["vertex_distance_max"]))
