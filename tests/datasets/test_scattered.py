"""Scattered heights: triangles of random sites, data of every kind, and that they tempt surfaces below the ground."""

from typing import Any

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.inverse_area_normals import inverse_area_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.measures.plane_side import PlaneSide
from testbed.plugins.measure import Survey
from testbed_datasets.scattered_sites import WIDEST_DEG, even_sites, triangulated

DATA = ["field=peak", "field=peak,normals=estimated", "field=rainfall", "field=noise,normals=estimated"]


def flat_mesh(sites: Float) -> HermiteMesh:
    return HermiteMesh(np.column_stack([sites, np.zeros(len(sites))]), triangulated(sites))


def angles_deg(mesh: HermiteMesh) -> Float:
    corners = mesh.corner_points()
    return np.degrees(angle_between(np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners))


@pytest.mark.parametrize("count", [8, 34, 300])
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
@pytest.mark.parametrize("seed", range(5))
def test_triangles_are_a_disc_of_delaunay_triangles(count: int, even: bool, seed: int) -> None:
    sites = even_sites(count, seed) if even else np.random.default_rng(seed).uniform(size=(count, 2))
    mesh = flat_mesh(sites)  # refuses what is no manifold, and sites without a triangle
    assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == 1
    a, b, c = np.moveaxis(sites[mesh.faces], 1, 0)
    legs = np.stack([b - a, c - a], axis=1)
    assert (np.linalg.det(legs) > 0.0).all()  # counterclockwise
    centre = a + np.linalg.solve(legs, 0.5 * (legs**2).sum(axis=2)[..., None])[..., 0]
    radius = norm(centre - a)
    assert (norm(sites - centre[:, None]) >= radius[:, None] * (1.0 - 1e-9)).all()


@pytest.mark.parametrize("seed", range(10))
def test_even_sites_leave_no_needles(seed: int) -> None:
    sites = even_sites(34, seed)
    assert ((sites > 0.0) & (sites < 1.0)).all()
    apart = norm(sites[:, None] - sites) + np.eye(34)
    assert apart.min() > 0.5 / np.sqrt(34)
    mesh = flat_mesh(sites)
    assert angles_deg(mesh).min() > 15.0
    # no wide angle looks at the boundary from inside
    wide, corner = np.nonzero(angles_deg(mesh) > WIDEST_DEG)
    opposite = mesh.face_edges[wide, (corner + 1) % 3]
    assert not (mesh.boundary_edges[opposite] & ~mesh.boundary_vertices[mesh.faces[wide, corner]]).any()


def test_slivers_on_both_sides_of_a_vertex_do_not_both_go() -> None:
    # without its two long triangles the rectangle would hang together in its centre alone
    sites = np.array([[-1.0, -0.1], [1.0, -0.1], [1.0, 0.1], [-1.0, 0.1], [0.0, 0.0]])
    mesh = flat_mesh(sites)
    assert len(mesh.faces) == 3
    assert angles_deg(mesh).max() > 150.0


def test_triangles_do_not_depend_on_the_order_of_sites() -> None:
    sites = even_sites(50, 3)
    order = np.random.default_rng(0).permutation(50)
    one, other = (np.sort(faces, axis=1) for faces in (order[triangulated(sites[order])], triangulated(sites)))
    assert sorted(one.tolist()) == sorted(other.tolist())


def test_coinciding_sites_are_refused() -> None:
    sites = even_sites(20, 0)
    sites[7] = sites[3]
    with pytest.raises(Refused, match=r"site (3|7) "):
        triangulated(sites)


@pytest.mark.parametrize("text", DATA)
def test_no_height_is_below_the_ground_on_any_level(text: str) -> None:
    for seed in range(5):
        dataset = registry.dataset(f"scattered[{text},seed={seed},ground=0.125]")
        for level in range(3):
            assert dataset.mesh(level).points[:, 2].min() >= 0.125


@pytest.mark.parametrize("text", DATA)
def test_levels_are_nested_and_seeds_differ(text: str) -> None:
    dataset = registry.dataset(f"scattered[{text}]")
    coarse, fine = dataset.mesh(0), dataset.mesh(2)
    assert len(fine.faces) == 16 * len(coarse.faces)
    assert np.array_equal(fine.points[: len(coarse.points)], coarse.points)
    assert np.array_equal(dataset.mesh(2).points, fine.points)
    other = registry.dataset(f"scattered[{text},seed=1]").mesh(0)
    assert not np.isin(other.points, coarse.points).any(axis=1).all()
    assert len(registry.dataset(f"scattered[{text},points=60]").mesh(0).points) == 60


def test_normals_are_of_the_kind_asked_for() -> None:
    exact, estimated, none = (registry.dataset(f"scattered[normals={kind}]").mesh(1) for kind in NORMALS)
    assert np.array_equal(exact.points, estimated.points)
    assert np.array_equal(exact.points, none.points)
    assert exact.second_forms is not None
    assert exact.normals_from == "given"
    assert estimated.second_forms is None
    assert estimated.normals_from == "estimated"
    assert estimated.normals is not None
    assert np.abs(estimated.normals - inverse_area_normals(none.points, none.faces)).max() < 1e-15
    assert none.normals is None


NORMALS = ("exact", "estimated", "none")


def test_dry_sites_are_on_the_plane_with_its_normal() -> None:
    mesh = registry.dataset("scattered[field=rainfall]").mesh(1)
    assert mesh.normals is not None
    dry = mesh.points[:, 2] == 0.0
    assert 0.1 < dry.mean() < 0.9
    assert np.array_equal(mesh.normals[dry], np.tile([0.0, 0.0, 1.0], (dry.sum(), 1)))


def test_random_heights_have_no_surface() -> None:
    assert registry.dataset("scattered[field=noise,normals=none]").surface is None
    for field in ("peak", "rainfall"):
        dataset = registry.dataset(f"scattered[field={field},normals=none]")
        assert dataset.surface is not None
        points = dataset.mesh(0).points
        assert norm(dataset.surface.closest(points) - points).max() < 1e-15


@pytest.mark.parametrize("text", DATA)
def test_smooth_surfaces_swing_below_the_plane(text: str) -> None:
    for seed in range(5):
        mesh = registry.dataset(f"scattered[{text},seed={seed}]").mesh(0)
        assert mesh.points[:, 2].min() >= 0.0
        columns = PlaneSide().measure(Survey(registry.scheme("shirman-sequin").fit(mesh)))
        assert float(columns["plane_min"]) < -1e-4
        assert float(columns["plane_below"]) > 0.0


@pytest.mark.parametrize(
    "text",
    ["points=7", "points=200000", "seed=-1", "height=0", "height=inf", "ground=inf", "field=noise", "field=dune"],
)
def test_parameters_that_make_no_data_are_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(SpecError, match=r"of scattered cannot be"):
        registry.dataset(f"scattered[{text}]")


def test_heights_are_in_proportion_to_the_factor() -> None:
    def heights(**parameters: Any) -> Float:
        spec = ",".join(f"{name}={value}" for name, value in parameters.items())
        points: Float = registry.dataset(f"scattered[{spec}]").mesh(1).points
        return points[:, 2]

    for field in ("peak", "rainfall", "noise"):
        low, high = (heights(field=field, normals="none", ground=0, height=height) for height in (0.25, 1.0))
        assert np.abs(high - 4.0 * low).max() < 1e-15
