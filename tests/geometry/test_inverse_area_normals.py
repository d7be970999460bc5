"""Normals by inverse areas: the mean inside, the extrapolation on the boundary, and what steep data ask for."""

import numpy as np
import pytest

from testbed.conformance.meshes import fan, graph, grid, icosahedron, octahedron, perturbed_icosahedron
from testbed.errors import MeshError
from testbed.geometry.cone_axes import face_normals
from testbed.geometry.inverse_area_normals import inverse_area_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, angle_between, dot, norm, unit

OPEN = (graph(*fan()), grid(3, 4), graph(np.array([0.1, 0.8, 0.3]), np.array([-0.2, 0.1, 0.7]), np.array([[0, 1, 2]])))


def across(mesh: HermiteMesh, face: int, vertex: int) -> int | None:
    """Return the face across the edge of a face that is opposite to a vertex."""
    others = [i for i in mesh.faces[face].tolist() if i != vertex]
    beside = [f for f in np.flatnonzero(np.isin(mesh.faces, others).sum(axis=1) == 2).tolist() if f != face]
    return beside[0] if beside else None


def extrapolated(mesh: HermiteMesh, vertex: int) -> Float:
    """2 n_i - n_E over the faces at a vertex, by inverse areas, n_E the mean by inverse areas on the opposite edge."""
    normals, areas = face_normals(mesh.points, mesh.faces)
    total = np.zeros(3)
    for face in np.flatnonzero((mesh.faces == vertex).any(axis=1)).tolist():
        other = across(mesh, face, vertex)
        if other is None:
            mean = normals[face]
        else:
            mean = normals[face] / areas[face] + normals[other] / areas[other]
            mean = mean / (1.0 / areas[face] + 1.0 / areas[other])
        total += (2.0 * normals[face] - mean) / areas[face]
    return unit(total)


def as_printed(mesh: HermiteMesh, vertex: int) -> Float:
    """The boundary rule with n_i* = A_i O x A_i A_{i+1}, which is of face i itself."""
    normals, areas = face_normals(mesh.points, mesh.faces)
    total = np.zeros(3)
    for face in np.flatnonzero((mesh.faces == vertex).any(axis=1)).tolist():
        other = across(mesh, face, vertex)
        size, beside = areas[face], 0.0 if other is None else areas[other]
        star = normals[face] if other is None else -normals[face]
        total += ((2.0 * size + beside) * normals[face] - size * star) / (size + beside) / size
    return unit(total)


@pytest.mark.parametrize("mesh", OPEN)
def test_the_boundary_rule_extrapolates(mesh: HermiteMesh) -> None:
    found = inverse_area_normals(mesh.points, mesh.faces)
    for vertex in np.flatnonzero(mesh.boundary_vertices).tolist():
        assert found[vertex] == pytest.approx(extrapolated(mesh, vertex), abs=1e-14)


@pytest.mark.parametrize("mesh", [*OPEN, perturbed_icosahedron()])
def test_inside_it_is_the_mean_by_inverse_areas(mesh: HermiteMesh) -> None:
    normals, areas = face_normals(mesh.points, mesh.faces)
    found = inverse_area_normals(mesh.points, mesh.faces)
    for vertex in np.flatnonzero(~mesh.boundary_vertices).tolist():
        around = (mesh.faces == vertex).any(axis=1)
        mean = (normals[around] / areas[around, None]).sum(axis=0)
        assert found[vertex] == pytest.approx(unit(mean), abs=1e-14)


def test_the_boundary_rule_as_printed_is_another_and_worse() -> None:
    """On a graph; ours is nearer to its normals than the mean without extrapolation, too."""
    mesh = grid(3, 8)
    assert mesh.normals is not None
    rim = np.flatnonzero(mesh.boundary_vertices)
    found = inverse_area_normals(mesh.points, mesh.faces)[rim]
    printed = np.stack([as_printed(mesh, vertex) for vertex in rim.tolist()])
    assert norm(found - printed).max() > 0.01
    ours, theirs = (angle_between(some, mesh.normals[rim]).mean() for some in (found, printed))
    assert ours < 0.7 * theirs


def test_planes_and_regular_solids_are_exact() -> None:
    coefficients = np.zeros((2, 2))
    coefficients[1, 0], coefficients[0, 1] = 0.3, -0.2
    for mesh in (graph(*fan(), coefficients), octahedron(), icosahedron()):
        assert inverse_area_normals(mesh.points, mesh.faces) == pytest.approx(mesh.normals, abs=1e-14)


def test_they_turn_with_the_data_and_do_not_depend_on_size_order_or_place() -> None:
    mesh = graph(*fan())
    found = inverse_area_normals(mesh.points, mesh.faces)
    flipped = mesh.flipped()
    assert inverse_area_normals(flipped.points, flipped.faces) == pytest.approx(-found, abs=1e-14)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = mesh.transformed(turn, [3.0, -2.0, 1.0], 1e-3)
    assert inverse_area_normals(moved.points, moved.faces) == pytest.approx(found @ turn.T, abs=1e-11)
    order = np.random.default_rng(2).permutation(len(mesh.points))
    other = mesh.relabelled(order).with_face_order(np.arange(len(mesh.faces))[::-1])
    assert inverse_area_normals(other.points, other.faces) == pytest.approx(found[order], abs=1e-14)


def test_they_see_all_faces_of_steep_data_which_the_rules_do_not() -> None:
    """Random heights fifty times as rough as their sites are apart."""
    x, y, faces = fan()
    hidden = 0
    for seed in range(20):
        points = np.stack([x, y, np.random.default_rng(seed).uniform(0.0, 20.0, len(x))], axis=-1)
        mesh = HermiteMesh(points, faces)
        found = inverse_area_normals(points, faces)
        of_faces, _ = face_normals(points, faces)
        assert dot(found[faces], of_faces[:, None]).min() > 0.0
        hidden += sum(
            bool((of_faces[(faces == vertex).any(axis=1)] @ extrapolated(mesh, vertex) <= 0.0).any())
            for vertex in np.flatnonzero(mesh.boundary_vertices).tolist()
        )
    assert hidden > 0


def test_what_has_no_normals_is_refused_naming_the_vertex() -> None:
    # a vertex whose faces are the two sides of one triangle
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    faces = np.array([[0, 1, 2], [0, 2, 1]])
    with pytest.raises(MeshError, match="at vertex 0 cancel out"):
        inverse_area_normals(points[:3], faces)
    with pytest.raises(MeshError, match="have four vertices"):
        inverse_area_normals(points, np.array([[0, 1, 2, 3]]))
