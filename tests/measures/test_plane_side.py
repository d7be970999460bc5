"""Distances from a plane: minima in closed form, what is left out, guarantees, and faces below."""

import math
from typing import Any

import numpy as np
import pytest
from built_surfaces import flat, graph, octahedron, one_graph, place

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.plane_side import PlaneSide
from testbed.plugins.measure import Survey

EVERY = {"plane_min", "plane_min_face", "plane_min_bary", "plane_min_low", "plane_below"}


def columns(surface: Surface, plane: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 0.0)) -> dict[str, Any]:
    return dict(PlaneSide(plane).measure(Survey(surface)))


def bowl(x: Float, y: Float) -> Float:
    """Smallest value -0.01 at (0.3, 0.4), not negative at the corners (0, 0), (1, 0), (0, 1)."""
    return (x - 0.3) ** 2 + 2.0 * (y - 0.4) ** 2 + (x - 0.3) * (y - 0.4) - 0.01


def test_the_smallest_distance_is_found_with_its_place() -> None:
    found = columns(one_graph(bowl, 2))
    assert set(found) == EVERY
    assert found["plane_min"] == pytest.approx(-0.01, abs=1e-11)
    assert np.abs(place(found["plane_min_bary"]) - [0.3, 0.3, 0.4]).max() < 1e-4
    assert found["plane_min_face"] == 0
    assert found["plane_below"] == 1.0
    assert -0.01 - 5e-5 < found["plane_min_low"] <= -0.01 + 1e-15


def test_a_surface_above_the_plane_is_not_below_it() -> None:
    found = columns(one_graph(lambda x, y: bowl(x, y) + 0.010001, 2))
    assert found["plane_min"] == pytest.approx(1e-6, abs=1e-11)
    # the guarantee is as fine as it takes to tell the sides apart
    assert 0.4e-6 < found["plane_min_low"] <= 1e-6 + 1e-15
    assert found["plane_below"] == 0.0


def test_the_share_of_faces_below_counts_each_face_once() -> None:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    # below the plane in a strip within 0 < x < 0.5: of the first two faces
    found = columns(graph(lambda x, _: x * (x - 0.5), 2, corners, faces))
    assert found["plane_below"] == 0.5
    assert found["plane_min"] == pytest.approx(-1.0 / 16.0)
    # a point below that no sample is in counts its face
    narrow = graph(lambda x, y: (x - 0.357) ** 2 + (y - 0.213) ** 2 - 1e-6, 2, corners, faces)
    assert columns(narrow)["plane_below"] == 0.25


def test_split_faces_count_once() -> None:
    mesh = registry.dataset("scattered[field=noise,normals=estimated]").mesh(0)
    surface = registry.scheme("shirman-sequin").fit(mesh)  # three patches a face
    (part,) = surface.parts
    below = (part.batch.jets(lattice(3, 24), 0).f[..., 2] < 0.0).any(axis=1)
    patches, faces = np.count_nonzero(below), len(np.unique(part.faces[below]))
    assert patches > 1.5 * faces > 15
    # the measure's samples are others
    assert len(mesh.faces) * columns(surface)["plane_below"] == pytest.approx(faces, abs=1.0)


@pytest.mark.parametrize("height", [-1e-6, -1.0])
def test_nothing_is_said_where_a_vertex_is_below(height: float) -> None:
    points = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, height], [0.0, 1.0, 1.0]])
    assert columns(flat(points, np.array([[0, 1, 2]]))) == {}
    assert columns(octahedron()) == {}


def test_vertices_may_be_on_the_plane() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = columns(flat(points, np.array([[0, 1, 2]])))
    assert found["plane_min"] == found["plane_min_low"] == found["plane_below"] == 0.0
    assert math.copysign(1.0, found["plane_min"]) == 1.0


def test_rounding_does_not_put_vertices_below_the_plane() -> None:
    # vertices on the plane x/3 + y/7 + z/9 = 0.1, as far as rounding lets them
    corners = np.random.default_rng(2).uniform(size=(3, 2))
    z = 9.0 * (0.1 - corners[:, 0] / 3.0 - corners[:, 1] / 7.0)
    plane = (1.0 / 3.0, 1.0 / 7.0, 1.0 / 9.0, -0.1)
    for tiny in (0.0, -1e-14):
        found = columns(flat(np.column_stack([corners, z + tiny]), np.array([[0, 1, 2]])), plane)
        assert abs(found["plane_min"]) < 1e-14
        assert -1e-13 < found["plane_min_low"] < 0.0
        assert found["plane_below"] == 0.0
    assert columns(flat(np.column_stack([corners, z - 1e-10]), np.array([[0, 1, 2]])), plane) == {}


def test_it_turns_and_grows_with_the_surface() -> None:
    mesh = registry.dataset("scattered[field=rainfall]").mesh(0)
    R, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    R = R * np.linalg.det(R)
    translation = np.array([0.3, -2.0, 0.7])
    scheme = registry.scheme("shirman-sequin")
    before = columns(scheme.fit(mesh))
    a, b, c = R[:, 2].tolist()
    plane = (2.0 * a, 2.0 * b, 2.0 * c, -2.0 * float(R[:, 2] @ translation))
    after = columns(scheme.fit(mesh.transformed(R, translation, 3.0)), plane)
    assert after["plane_min"] == pytest.approx(3.0 * before["plane_min"], rel=1e-9)
    assert after["plane_min_low"] == pytest.approx(3.0 * before["plane_min_low"], rel=1e-3)
    assert after["plane_min_face"] == before["plane_min_face"]
    assert after["plane_below"] == before["plane_below"]


@pytest.mark.parametrize("scheme", ["shirman-sequin", "range-restricted[constrain=never]", "pn-triangle", "flat"])
@pytest.mark.parametrize("field", ["peak", "rainfall", "noise"])
def test_no_point_is_below_the_guaranteed_bound(scheme: str, field: str) -> None:
    mesh = registry.dataset(f"scattered[field={field},normals=estimated,ground=0.01]").mesh(0)
    surface = registry.scheme(scheme).fit(mesh)
    found = columns(surface)
    dense = min(part.batch.jets(lattice(3, 50), 0).f[..., 2].min() for part in surface.parts)
    assert found["plane_min_low"] <= found["plane_min"] + 1e-15
    assert found["plane_min"] <= dense + 1e-6
    assert found["plane_min_low"] <= dense + 1e-15
    # of blends the bound is that of what they are blended from
    assert found["plane_min_low"] >= dense - 2e-3
    assert (found["plane_min"] < 0.0) == (found["plane_below"] > 0.0)


def test_other_patches_have_no_guarantee() -> None:
    surface = registry.scheme("triangular-gregory").fit(registry.dataset("scattered").mesh(0))
    assert set(columns(surface)) == EVERY - {"plane_min_low"}


def test_quadrilaterals_have_all_columns() -> None:
    mesh = registry.dataset("quad-graph").mesh(0)
    up = mesh.transformed(translation=(0.0, 0.0, 2.0))
    found = columns(registry.scheme("zero-twist-bicubic").fit(up))
    assert set(found) == EVERY
    assert found["plane_min_low"] <= found["plane_min"] <= up.points[:, 2].min()
    assert len(place(found["plane_min_bary"])) == 2


def test_what_is_not_a_number_is_no_pass() -> None:
    points = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    control_points = points[faces]
    control_points[1, 0, 2] = np.nan
    found = columns(Surface.over_faces(HermiteMesh(points, faces), BezierTriangles(control_points)))
    assert found["plane_min_face"] == 1
    for name in ("plane_min", "plane_min_low", "plane_below"):
        assert math.isnan(found[name])


@pytest.mark.parametrize("plane", [(0.0, 0.0, 0.0, 1.0), (1e200, 0.0, 0.0, 1.0), (0.0, 1e-50, 0.0, 1e300)])
def test_planes_that_are_none_are_refused(plane: tuple[float, float, float, float]) -> None:
    with pytest.raises(SpecError, match="parameter plane of plane-side cannot be"):
        PlaneSide(plane)
