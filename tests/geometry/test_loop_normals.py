"""Loop's limit normals: what subdivision keeps, what repeated subdivision tends to, planes, symmetry, invariance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from spoked_meshes import spokes

from testbed import registry
from testbed.errors import MeshError
from testbed.geometry.domain import CORNERS
from testbed.geometry.loop_normals import limit_tangents, loop_limit_normals
from testbed.geometry.loop_subdivision import interpolating_vertices, subdivided
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, angle_between, cross, norm
from testbed_schemes.loop import Loop

MESHES = {
    **{name: registry.dataset(name).mesh(0) for name in ("octahedron", "icosahedron", "torus", "graph")},
    **{f"valence {count}": spokes(count, closed=True) for count in (3, 4, 7, 12)},
    **{f"{count} faces on the boundary": spokes(count, closed=False) for count in (1, 2, 3, 4, 5, 9)},
}
every_mesh = pytest.mark.parametrize("name", MESHES)


def triangles(mesh: HermiteMesh) -> Triangulation:
    return Triangulation(mesh.faces, len(mesh.points))


def step(faces: Triangulation, points: Float) -> Float:
    """A step with the rule of Hoppe et al. 1994 for boundary edges at vertices with four faces or more."""
    result = subdivided(faces, points)
    crowded = faces.on_boundary & (faces.face_count > 3)
    a, b = faces.edges.T
    bounding = faces.twin[faces.half_edge] < 0
    for near, far in ((a, b), (b, a)):
        (chosen,) = np.nonzero(bounding & crowded[near] & ~crowded[far])
        result[faces.vertices + chosen] = (3.0 * points[near[chosen]] + 5.0 * points[far[chosen]]) / 8.0
    return result


def apart(mesh: HermiteMesh) -> tuple[Triangulation, Float]:
    """The mesh; where boundary vertices have four faces or more after a step, which sets its vertices apart."""
    faces = triangles(mesh)
    crowded = faces.on_boundary & (faces.face_count > 3)
    return (faces.refined(), step(faces, mesh.points)) if crowded.any() else (faces, mesh.points)


@every_mesh
def test_a_step_of_subdivision_leaves_the_normals(name: str) -> None:
    # the masks are left eigenvectors, so that each step gives the limit's normal again
    faces, points = apart(MESHES[name])
    count = len(MESHES[name].points)
    normals = loop_limit_normals(points, faces.faces)
    finer = loop_limit_normals(step(faces, points), faces.refined().faces)
    assert norm(finer[:count] - normals[:count]).max() < 2e-14


@every_mesh
def test_a_step_scales_the_tangents_of_the_boundary_by_their_eigenvalues(name: str) -> None:
    faces, points = apart(MESHES[name])
    along, inward, _ = limit_tangents(faces, points)
    finer_along, finer_inward, _ = limit_tangents(faces.refined(), step(faces, points))
    (rim,) = np.nonzero(faces.on_boundary[: len(MESHES[name].points)])
    count = faces.face_count[rim]
    half = np.where(count > 3, 0.625, 0.5)[:, None]
    across = np.where(count == 1, 0.5, 0.375 + 0.25 * np.cos(np.pi / count))[:, None]
    assert norm(finer_along[rim] - half * along[rim]).max(initial=0.0) < 1e-14
    assert norm(finer_inward[rim] - across * inward[rim]).max(initial=0.0) < 1e-14


@every_mesh
def test_facets_around_a_vertex_tend_to_its_normal(name: str) -> None:
    faces, points = apart(MESHES[name])
    normals = loop_limit_normals(points, faces.faces)[: len(MESHES[name].points)]
    angles = []
    for _ in range(4):
        faces, points = faces.refined(), step(faces, points)
        facet, corner = np.nonzero(faces.faces < len(normals))
        p = points[faces.faces[facet]]
        turns = angle_between(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), normals[faces.faces[facet, corner]])
        angles.append(turns.max())
    assert angles[-1] < max(0.9 * angles[-2], 1e-12)
    assert angles[-1] < 0.3


@pytest.mark.parametrize("name", ["octahedron", "torus", "graph", "valence 3", "valence 7", "3 faces on the boundary"])
def test_they_are_the_normals_of_the_interpolating_loop_surface_over_its_control_vertices(name: str) -> None:
    mesh = MESHES[name]
    normals = loop_limit_normals(interpolating_vertices(triangles(mesh), mesh.points), mesh.faces)
    crowded = triangles(mesh).on_boundary & (triangles(mesh).face_count > 3)
    for part in Loop().fit(mesh).parts:
        patch, corner = np.nonzero(part.corner_ids < len(mesh.points))
        vertex = part.corner_ids[patch, corner]
        found = part.batch.jets(CORNERS[3], 1).normal[patch, corner]
        assert norm(found - normals[vertex])[~crowded[vertex]].max(initial=0.0) < 1e-12


@pytest.mark.parametrize("name", ["octahedron", "icosahedron"])
def test_symmetric_vertices_have_radial_normals(name: str) -> None:
    mesh = registry.dataset(name).mesh(0)
    assert norm(loop_limit_normals(mesh.points, mesh.faces) - mesh.points).max() < 1e-15


@pytest.mark.parametrize("sides", [3, 4, 5, 6, 11])
def test_the_tip_of_a_pyramid_has_the_normal_of_the_axis(sides: int) -> None:
    turn = 2.0 * np.pi * np.arange(sides) / sides
    points = np.vstack([np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides)]), [[0.0, 0.0, 1.3]]])
    faces = [[j, (j + 1) % sides, sides] for j in range(sides)]
    normals = loop_limit_normals(points, np.array(faces))
    assert norm(normals[-1] - [0.0, 0.0, 1.0]) < 1e-15
    assert (normals[:-1, :2] * points[:-1, :2]).sum(axis=1).min() > 0.0


@given(st.integers(0, 2**32 - 1), st.booleans(), st.integers(3, 9))
@settings(max_examples=20, deadline=None)
def test_planes_are_exact_and_far_from_the_origin_too(seed: int, closed: bool, count: int) -> None:
    random = np.random.default_rng(seed)
    mesh = spokes(count, closed=closed, rings=2)
    place = mesh.points[:, :2] + random.uniform(-0.1, 0.1, (len(mesh.points), 2))
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    axes *= np.linalg.det(axes)
    normals = loop_limit_normals(place @ axes[:, :2].T, mesh.faces)
    assert norm(normals - axes[:, 2]).max() < 1e-13
    moved = loop_limit_normals(1e-3 * place @ axes[:, :2].T + [1e5, -1e5, 1e5], mesh.faces)
    assert norm(moved - axes[:, 2]).max() < 1e-6


@every_mesh
def test_motions_scales_and_labels_do_not_matter_and_a_flip_reverses(name: str) -> None:
    mesh = MESHES[name].without_normals()
    normals = loop_limit_normals(mesh.points, mesh.faces)
    random = np.random.default_rng(3)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    moved = mesh.transformed(turn, (0.1, -0.2, 0.5), 7.0)
    assert norm(loop_limit_normals(moved.points, moved.faces) - normals @ turn.T).max() < 1e-13
    order = random.permutation(len(mesh.points))
    other = mesh.relabelled(order).with_face_order(random.permutation(len(mesh.faces)))
    other = other.rotated_corners(random.integers(3, size=len(mesh.faces)))
    assert norm(loop_limit_normals(other.points, other.faces) - normals[order]).max() < 1e-13
    back = mesh.flipped()
    assert norm(loop_limit_normals(back.points, back.faces) + normals).max() < 1e-13


def test_tiny_and_huge_meshes_have_normals() -> None:
    mesh = MESHES["graph"]
    normals = loop_limit_normals(mesh.points, mesh.faces)
    for scale in (1e-30, 1e30):
        assert norm(loop_limit_normals(scale * mesh.points, mesh.faces) - normals).max() < 1e-14


def test_vertices_without_a_normal_are_named() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    with pytest.raises(MeshError, match="no normal at vertex 0"):
        loop_limit_normals(points, np.array([[0, 1, 2], [0, 2, 1]]))
    mesh = spokes(4, closed=True, rings=2)
    folded = mesh.points.copy()
    folded[3] = folded[1]  # opposite neighbours of vertex 0
    with pytest.raises(MeshError, match="no normal at vertex 0"):
        loop_limit_normals(folded, mesh.faces)
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.5]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    assert norm(loop_limit_normals(points, faces)[0] - [0.0, 1.0, 0.0]) < 1e-15
    points[2] = [2.0, 0.0, 0.0]  # along the line through the other two neighbours
    with pytest.raises(MeshError, match="no normal at vertex 0"):
        loop_limit_normals(points, faces)


def test_quadrilaterals_are_not_taken() -> None:
    mesh = registry.dataset("quad-sphere").mesh(0)
    with pytest.raises(MeshError, match="split them"):
        loop_limit_normals(mesh.points, mesh.faces)
