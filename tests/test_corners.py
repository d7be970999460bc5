"""Corners of faces that leave a patch no tangent plane, or turn it over, are found and named; all others are taken."""

import numpy as np
import pytest
from hostile_meshes import Data, bipyramid, hostile_mesh_data, mesh_data, vertex_normals
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import testbed
from testbed import registry
from testbed.errors import MeshError, Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, tangential
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Scheme
from testbed.plugins.scheme import Data as VertexData

quick = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
seeds = st.integers(0, 2**32 - 1)
SUBJECT = testbed.scheme("flat")


def chords(mesh: HermiteMesh) -> tuple[Float, Float]:
    p0, p1 = mesh.points[mesh.edges[:, 0]], mesh.points[mesh.edges[:, 1]]
    return p1 - p0, p0 - p1


def projected(mesh: HermiteMesh) -> tuple[Float, Float]:
    assert mesh.normals is not None
    start, end = chords(mesh)
    return tangential(start, mesh.normals[mesh.edges[:, 0]]), tangential(end, mesh.normals[mesh.edges[:, 1]])


def pyramids(sides: int = 7) -> HermiteMesh:
    points, faces = bipyramid(sides)
    return HermiteMesh(points, faces, vertex_normals(points, faces))


def turned(mesh: HermiteMesh, vertices: list[int]) -> HermiteMesh:
    assert mesh.normals is not None
    normals = mesh.normals.copy()
    normals[vertices] *= -1.0
    return HermiteMesh(mesh.points, mesh.faces, normals)


@settings(quick, max_examples=200)
@given(hostile_mesh_data())
def test_the_chords_of_a_mesh_that_is_taken_have_planes_at_all_corners(data: Data) -> None:
    try:
        mesh = HermiteMesh(**data)
    except MeshError:
        return
    check_corners(SUBJECT, mesh, *chords(mesh))


@quick
@given(mesh_data(), seeds)
def test_tangents_on_one_line_or_of_no_length_are_refused_and_named(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    random = np.random.default_rng(seed)
    vertex = int(random.integers(len(mesh.points)))
    line = random.choice([0.0, 1.0]) * random.normal(size=3)
    start, end = chords(mesh)
    start[mesh.edges[:, 0] == vertex] = random.normal() * line
    end[mesh.edges[:, 1] == vertex] = random.normal() * line
    with pytest.raises(Refused, match=rf"^flat leaves no tangent plane at vertex {vertex} of face \d+ .*: .* turn it"):
        check_corners(SUBJECT, mesh, start, end)


@quick
@given(st.integers(3, 12), st.integers(0, 11), st.booleans())
def test_a_normal_turned_over_is_found_at_its_vertex_and_all_of_them_are_none(sides: int, v: int, inside: bool) -> None:
    mesh = pyramids(sides)
    vertex = v % len(mesh.points)
    if inside:
        mesh = turned(mesh, list(range(len(mesh.points))))
    check_sides(SUBJECT, mesh, *projected(mesh))
    mesh = turned(mesh, [vertex])
    few = len(mesh.points) > 5 or vertex > 2  # of five vertices, two next to each other are as many as the others
    with pytest.raises(Refused, match=rf"folds over at vertex {vertex if few else '[0-9]'} of face"):
        check_sides(SUBJECT, mesh, *projected(mesh))


def test_a_part_that_is_inside_out_as_a_whole_is_taken() -> None:
    one = pyramids()
    assert one.normals is not None
    faces = np.concatenate([one.faces, one.faces + len(one.points)])
    normals = np.concatenate([one.normals, -one.normals])
    two = HermiteMesh(np.concatenate([one.points, one.points + 5.0]), faces, normals)
    check_sides(SUBJECT, two, *projected(two))
    with pytest.raises(Refused, match="vertex 10 of face"):
        check_sides(SUBJECT, turned(two, [10]), *projected(turned(two, [10])))


def test_two_faces_folded_over_their_edge_are_refused() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.6, 0.8, 0.1]])
    mesh = HermiteMesh(points, [[0, 1, 2], [1, 0, 3]], np.tile([0.0, 0, 1], (4, 1)))
    with pytest.raises(Refused, match="folds over at vertex 1 of face 1"):
        check_sides(SUBJECT, mesh, *projected(mesh))


SCHEMES = registry.catalogue(Scheme)  # type: ignore[type-abstract]
G1 = [
    name
    for name, scheme in SCHEMES.items()
    if scheme.continuity is Continuity.G1 and VertexData.NORMALS in scheme.needs
]


@pytest.mark.parametrize("name", G1)
def test_smooth_schemes_refuse_a_normal_that_is_turned_over(name: str) -> None:
    mesh = pyramids()
    assert testbed.scheme(name).fit(mesh).patch_count
    with pytest.raises(Refused, match=r"vert(ex|ices|ex .* to vertex) 3"):
        testbed.scheme(name).fit(turned(mesh, [3]))


@pytest.mark.parametrize("name", [*G1, "pn-triangle", "quadratic-interpolant", "cubic-interpolant"])
def test_schemes_refuse_a_normal_in_the_plane_of_a_face(name: str) -> None:
    mesh = pyramids()
    assert mesh.normals is not None
    normals = mesh.normals.copy()
    a, b, c = mesh.points[mesh.faces[4]]
    normals[mesh.faces[4, 0]] = (b - a) - 0.3 * (c - a)
    given = HermiteMesh(mesh.points, mesh.faces, normals, np.zeros((len(normals), 3, 3)))
    # on curves of another kind, whose tangents leave the plane of the face, there may be a patch
    projects = ("cubic-interpolant", "peters", "shirman-sequin", "triangular-gregory", "walton-meek")
    boundary = "[boundary=projected]" if name in projects else ""
    with pytest.raises(Refused, match=r": .*(turn it or move the vertex|put a vertex on it|use a(nother)? scheme)"):
        testbed.scheme(name + boundary).fit(given)


def test_the_cubic_interpolant_refuses_second_forms_that_put_its_centre_far_away() -> None:
    sphere, scheme = testbed.dataset("icosahedron").mesh(0), testbed.scheme("cubic-interpolant[boundary=projected]")
    assert sphere.second_forms is not None
    for factor, far in ((1e6, False), (1e12, True)):
        data = HermiteMesh(sphere.points, sphere.faces, sphere.normals, factor * sphere.second_forms)
        if far:
            with pytest.raises(Refused, match=r"moves the centre of face 0 \(vertices .*\) by \de\+\d\d heights"):
                scheme.fit(data)
        else:
            assert scheme.fit(data).patch_count == 20


@pytest.mark.parametrize("name", ["shirman-sequin", "triangular-gregory", "herron", "walton-meek"])
def test_schemes_on_networks_refuse_normals_that_are_opposite_as_seen_along_an_edge(name: str) -> None:
    # the curve from vertex 0 to 1 stays in the plane of the face, its conormals point up and down
    normals = [[0.98551924, -0.16956364, 0], [-0.89508782, -0.44588989, 0], [0, 0, 1.0]]
    mesh = HermiteMesh([[1.0, 0, 0], [1, 1, 0], [0, 0, 0]], [[0, 1, 2]], normals)
    with pytest.raises(Refused, match=r"half-way on 1 of 3 edges, the first from vertex 0 to vertex 1: .*opposite"):
        testbed.scheme(f"{name}[boundary=planar]").fit(mesh)


def test_a_vertex_at_the_origin_without_a_tangent_is_refused() -> None:
    mesh = HermiteMesh(np.vstack([np.zeros(3), np.eye(3)[:2]]), [[0, 1, 2]])
    start, end = chords(mesh)
    with pytest.raises(Refused, match="vertex 0 of face 0"):
        check_corners(SUBJECT, mesh, 0.0 * start, end)


def test_a_narrow_corner_is_no_line_and_a_normal_in_its_plane_is_one_but_for_rounding() -> None:
    narrow = HermiteMesh([[0.0, 0, 0], [1, 0, 0], [1, 1e-9, 0]], [[0, 1, 2]], np.tile([0.0, 0, 1], (3, 1)))
    check_corners(SUBJECT, narrow, *projected(narrow))
    wide = HermiteMesh([[0.0, 0, 0], [1, 0, 0], [0.3, 0.9, 0.2]], [[0, 1, 2]], np.tile([0.0, 0, 1], (3, 1)))
    start, end = chords(wide)
    for sine, fits in ((1e-6, True), (1e-11, False)):
        start[0] = start[1] + sine * np.cross(start[1], [0.0, 0, 1])  # edges 01 and 02 from vertex 0
        if fits:
            check_corners(SUBJECT, wide, start, end)
        else:
            with pytest.raises(Refused, match="vertex 0 of face 0"):
                check_corners(SUBJECT, wide, start, end)


@pytest.mark.parametrize("angle", [1e-3, 1e-6])
def test_nielson_refuses_edges_whose_projection_has_lost_its_digits(angle: float) -> None:
    normals = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0, 0, 1], [0, 0, 1]])
    mesh = HermiteMesh([[0.0, 0, 0], [1, 0, 0], [0.3, 0.9, 0]], [[0, 1, 2]], normals)
    if angle < 1e-4:
        with pytest.raises(Refused, match="the edge from vertex 0 to vertex 1"):
            testbed.scheme("nielson").fit(mesh)
    else:
        assert testbed.scheme("nielson").fit(mesh).patch_count == 1


def test_the_cubic_interpolant_measures_the_way_of_its_centre_by_the_height_of_the_face() -> None:
    needle = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1e-6, 0]])
    scheme = testbed.scheme("cubic-interpolant[boundary=projected]")
    bend = np.tile(np.diag([1.0, 1.0, 0.0]), (3, 1, 1))
    normals = vertex_normals(needle, np.array([[0, 1, 2]]))
    assert scheme.fit(HermiteMesh(needle, [[0, 1, 2]], normals, bend)).patch_count == 1
    with pytest.raises(Refused, match="heights of the face"):
        scheme.fit(HermiteMesh(needle, [[0, 1, 2]], normals, 1e6 * bend))
