"""The adaptive loop: bounds that are reached hold, every other ending says why, and what is recorded is so."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from toy_surfaces import LensData

from testbed import registry
from testbed.approximation.approximate import Limits, Target, approximate
from testbed.approximation.criteria import TEN_SAMPLES
from testbed.approximation.history import Approximation, control_point_counts
from testbed.approximation.longest_edge import LongestEdge
from testbed.approximation.record import arrays, history_table
from testbed.approximation.templates import Template
from testbed.errors import Refused, TestbedError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import angle_between, norm
from testbed.measures.continuity import edge_jumps, interior_edges
from testbed.measures.feet import projected
from testbed.plugins.scheme import Continuity, Data, Scheme

CUBIC = "cubic-interpolant[boundary=hermite[guard=(0.15 0.75)],reach=0.2]"


def run(
    dataset: str,
    epsilon_deg: float,
    distance: float | None = None,
    *,
    scheme: str = CUBIC,
    template: bool = False,
    limits: Limits | None = None,
) -> Approximation:
    splitting = Template() if template else LongestEdge()
    target = Target(math.radians(epsilon_deg), distance)
    return approximate(registry.dataset(dataset), registry.scheme(scheme), target, splitting=splitting, limits=limits)


def dense_epsilon_deg(surface: Surface) -> float:
    edges = interior_edges(surface)
    return math.degrees(edge_jumps(surface, edges, np.linspace(0.0, 1.0, 257))[0].max())


@pytest.mark.parametrize("template", [True, False])
def test_the_ellipsoid_comes_within_its_bounds_and_dense_samples_confirm_it(template: bool) -> None:
    found = run("ellipsoid", 0.4, 1e-4, template=template)
    assert found.reached
    assert found.surface is not None
    assert [step.step for step in found.history] == list(range(len(found.history)))
    faces = [step.faces for step in found.history]
    assert faces == sorted(set(faces))
    last = found.history[-1]
    assert last.epsilon_certified
    assert last.distance_certified
    assert last.epsilon_deg <= 0.4
    assert last.distance <= 1e-4
    dense = dense_epsilon_deg(found.surface)
    assert last.epsilon_sampled_deg <= last.epsilon_deg
    assert dense <= last.epsilon_deg * (1.0 + 1e-9)
    assert dense > 0.99 * last.epsilon_found_deg
    exact = registry.dataset("ellipsoid").surface
    assert exact is not None
    points = found.surface.batches[0].jets(lattice(3, 20), 0).f
    away = norm(points - projected(exact, points)).max(axis=1)
    assert (away <= found.face_distances * (1.0 + 1e-9)).all()
    assert 0.9 * last.distance < away.max() <= last.distance
    # every refinement split what exceeded a bound then
    assert all(step.edges_jumping + step.faces_distant > 0 for step in found.history[:-1])
    assert last.edges_split == 0


def test_the_data_are_those_of_the_exact_surface_at_every_vertex() -> None:
    found = run("ellipsoid", 0.4)
    exact = registry.dataset("ellipsoid").surface
    assert exact is not None
    points = found.mesh.points
    assert found.mesh.normals is not None
    assert found.mesh.second_forms is not None
    assert norm(points - exact.closest(points)).max() < 1e-15
    assert angle_between(found.mesh.normals, exact.normal(points)).max() < 1e-15
    assert np.abs(found.mesh.second_forms - exact.second_form(points)).max() < 1e-14


def test_levels_tell_how_often_faces_and_edges_were_split() -> None:
    found = run("ellipsoid", 0.01, template=True)
    start = registry.dataset("ellipsoid").mesh(0)
    levels, mesh = found.levels, found.mesh
    assert levels.faces.max() == len(found.history) - 1
    # no edge is halved more often than there were refinements; a face of a level has a side of that level
    assert levels.edges.max() == len(found.history) - 1
    assert (levels.edges[mesh.face_edges].max(axis=1) == levels.faces).all()
    # an edge of level k on one of the start's edges is its 2^k-th part: together they make all twelve
    key = {tuple(edge) for edge in start.edges.tolist()}
    assert len(key) == 12
    whole = np.isin(mesh.edges, np.arange(len(start.points))).all(axis=1)
    assert (levels.edges[whole] == 0).all()


def test_an_unchanged_mesh_has_level_zero_and_equal_runs_are_equal_bit_for_bit() -> None:
    found = run("sphere", 5.0)
    assert found.reached
    assert len(found.history) == 1
    assert not found.levels.faces.any()
    first, second = (arrays(run("torus", 1.0)) for _ in range(2))
    assert first.keys() == second.keys()
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_longest_edges_keep_angles_near_half_of_the_start_where_templates_need_not() -> None:
    kept = run("torus", 0.2)
    start = kept.history[0].smallest_angle_deg
    assert kept.reached
    assert min(step.smallest_angle_deg for step in kept.history) > 0.5 * start
    assert run("torus", 0.2, template=True).history[-1].smallest_angle_deg < 0.5 * start


def test_a_bump_between_the_vertices_is_found_by_the_distance_and_missed_by_the_angles() -> None:
    missed = run("bump", 1.0)
    assert missed.reached
    assert len(missed.history) == 1
    found = run("bump", 90.0, 2e-3)
    assert found.reached
    assert found.history[0].distance_found > 5e-3
    assert found.history[-1].distance < 2e-3
    tops = found.mesh.points[:, 2].max()
    assert tops > 0.01
    # and only there
    levels = found.levels.faces
    centre = found.mesh.corner_points().mean(axis=1)
    near = np.hypot(centre[:, 0] - 0.262, centre[:, 1] + 0.34) < 0.05
    assert (levels[near] > 8).any()
    assert levels[np.hypot(centre[:, 0] - 0.262, centre[:, 1] + 0.34) > 0.9].max() <= 1


@pytest.mark.parametrize("name", ["graph", "monkey-saddle", "offset[cells=3]"])
def test_the_boundary_of_an_open_surface_is_smooth_and_starts_and_ends_on_the_given_curve(name: str) -> None:
    found = run(name, 0.3)
    assert found.reached
    surface = found.surface
    assert surface is not None
    boundary = surface.edges[surface.edges.boundary]
    jet = surface.side_jets(boundary.left, np.array([0.0, 1.0]), 1)
    charted = registry.dataset(name).charted()
    assert charted is not None
    start_points = charted.sampled().points
    ids = boundary.ids
    following = {int(start): row for row, start in enumerate(ids[:, 0])}
    # tangents of the boundary curves at both sides of a vertex are parallel, but for corners of the parameter domain
    along = np.stack([jet.fu, -jet.fu + jet.fv, -jet.fv])[boundary.left.side, np.arange(len(ids))]
    before = along[:, 1]
    after = along[[following[int(end)] for end in ids[:, 1]], 0]
    turn = angle_between(before, after)
    corners = turn > 0.1
    assert corners.sum() <= 6
    assert turn[~corners].max() < 1e-9
    # corners were there at the start
    gap = norm(found.mesh.points[ids[corners, 1]][:, None] - start_points).min(axis=1)
    assert gap.max(initial=0.0) == 0.0


def test_boundary_vertices_of_the_graph_stay_above_the_sides_of_the_square() -> None:
    found = run("graph", 0.02)
    mesh = found.mesh
    assert len(found.history) > 1
    on_boundary = np.abs(mesh.points[mesh.boundary_vertices, :2]).max(axis=1)
    assert np.abs(on_boundary - 1.0).max() == 0.0


@pytest.mark.parametrize("dataset", ["offset", "offset[cells=1]"])
def test_templates_split_long_sides_on_the_boundary_too_and_come_to_an_end(dataset: str) -> None:
    found = run(dataset, 0.72, template=True)
    assert found.reached
    # without it triangles at the boundary get ever flatter, and a patch over one of them folds
    assert found.history[-1].smallest_angle_deg > 10.0
    assert found.history[-1].faces < 150


def test_too_few_refinements_are_told() -> None:
    found = run("ellipsoid", 0.01, limits=Limits(steps=1))
    assert (found.stop, found.reached) == ("most steps", False)
    assert len(found.history) == 2
    assert "epsilon is 2.08 degrees between faces" in found.reason


def test_too_many_faces_are_told() -> None:
    found = run("ellipsoid", 0.01, limits=Limits(faces=100))
    assert found.stop == "most faces"
    assert len(found.mesh.faces) <= 100
    assert "faces: epsilon is" in found.reason


def test_narrow_triangles_are_told() -> None:
    found = run("ellipsoid", 0.01, limits=Limits(angle=math.radians(40.0)))
    assert found.stop == "smallest angle"
    assert found.history[-1].smallest_angle_deg >= 40.0


def test_a_scheme_that_refuses_is_told() -> None:
    found = run("ellipsoid", 0.1, scheme="peters-cubic")
    assert found.stop == "refused"
    assert found.surface is None
    assert found.history == ()
    assert "the start mesh is refused: peters-cubic has no curve" in found.reason
    assert np.isnan(found.face_distances).all()


def test_bounds_below_rounding_are_told() -> None:
    assert run("plane", 1e-20).stop == "rounding"
    assert run("plane", 1.0, 1e-30).stop == "rounding"


def test_an_edge_of_the_exact_surface_itself_is_no_progress() -> None:
    target, limits = Target(math.radians(1.0)), Limits(patience=3)
    found = approximate(LensData(), registry.scheme(CUBIC), target, limits=limits)
    assert found.stop == "no progress"
    assert "epsilon is" in found.reason
    assert found.history[-1].epsilon_deg > 60.0


def test_points_without_a_foot_are_told() -> None:
    found = approximate(LensData(holed=True), registry.scheme("flat"), Target(1.0, 0.1))
    assert found.stop == "not finite"
    assert "no foot" in found.reason


def test_a_mesh_that_cannot_be_refined_is_told() -> None:
    # no distance is asked for, and a middle has no foot at the second refinement
    found = approximate(LensData(holed=True), registry.scheme("flat"), Target(0.1))
    assert found.stop == "refused"
    assert "has no foot for the middle of the edge" in found.reason
    assert found.surface is not None
    assert math.isnan(found.history[-1].distance)


@pytest.mark.parametrize(
    ("dataset", "scheme", "words"),
    [
        ("mesh", CUBIC, "no exact surface"),
        ("quad-torus", CUBIC, "faces of 4 sides"),
        ("hyperboloid", CUBIC, "boundary that projection would leave"),
        ("ellipsoid", "bicubic-interpolant", "takes no triangles"),
    ],
)
def test_what_cannot_be_refined_at_all_is_refused_in_one_sentence(dataset: str, scheme: str, words: str) -> None:
    with pytest.raises(Refused, match=words) as refusal:
        run(dataset, 1.0, scheme=scheme)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("epsilon", "distance"), [(0.0, None), (math.nan, None), (4.0, None), (0.1, 0.0), (0.1, math.inf)]
)
def test_bounds_are_positive_numbers(epsilon: float, distance: float | None) -> None:
    with pytest.raises(TestbedError, match="give"):
        Target(epsilon, distance)


def test_the_thesis_samples_an_edge_at_ten_places() -> None:
    assert len(TEN_SAMPLES) == 10
    assert np.array_equal(1.0 - TEN_SAMPLES[::-1], TEN_SAMPLES)
    assert np.abs(TEN_SAMPLES - np.arange(10) / 9.0).max() < 1e-15


def test_control_points_are_counted_with_and_without_sharing() -> None:
    # V + 2 E + F of cubics on a closed mesh; the octahedron's level 1 has 18 vertices, 48 edges, 32 faces
    surface = registry.scheme(CUBIC).fit(registry.dataset("octahedron").mesh(1))
    assert control_point_counts(surface) == (320, 18 + 2 * 48 + 32)
    assert control_point_counts(registry.scheme("nielson").fit(registry.dataset("octahedron").mesh(0))) == (None, None)


def test_the_sampled_criterion_stops_where_the_exact_one_goes_on() -> None:
    dataset, scheme = registry.dataset("torus"), registry.scheme(CUBIC)
    # between what ten samples show and what is there
    worst = run("torus", 20.0).history[0]
    assert worst.epsilon_sampled_deg < worst.epsilon_found_deg
    between = math.radians(0.5 * (worst.epsilon_sampled_deg + worst.epsilon_found_deg))
    sampled, exact = (approximate(dataset, scheme, Target(between, None, how)) for how in ("sampled", "exact"))
    assert len(sampled.history) == 1
    assert len(exact.history) > 1


def test_inner_edges_of_split_faces_mark_all_sides_of_the_face() -> None:
    @dataclass(frozen=True)
    class Roofs(Scheme):
        """Three flat patches a face, the centre lifted: all jumps are within faces and between them."""

        name = "roofs"
        title = "Roofs"
        reference = "a test"
        needs = Data.POINTS
        matches = Data.POINTS
        continuity = Continuity.C0
        order = None
        reproduces = ()

        def construct(self, mesh: HermiteMesh) -> Surface:
            corners = mesh.corner_points()
            lifted = 1.2 * corners.mean(axis=1)
            pieces = [np.stack([corners[:, (i + 1) % 3], corners[:, (i + 2) % 3], lifted], axis=1) for i in range(3)]
            return Surface.over_split_faces(mesh, BezierTriangles(np.stack(pieces, axis=1).reshape(-1, 3, 3)))

    found = approximate(registry.dataset("octahedron"), Roofs(), Target(0.01), limits=Limits(steps=1))
    assert [step.faces for step in found.history] == [8, 32]
    assert found.history[0].patches == 24


def test_the_table_has_a_row_a_mesh_and_empty_fields_for_what_is_not_there() -> None:
    found = run("octahedron", 1e-3, 1e-2, scheme="nielson")
    lines = history_table(found).splitlines()
    assert len(lines) == 1 + len(found.history)
    names = lines[0].split(",")
    first = dict(zip(names, lines[1].split(","), strict=True))
    assert first["control_points"] == ""
    assert first["distance_certified"] == "False"
    assert first["faces"] == "8"
