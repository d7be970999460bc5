"""What A-patches reproduce: planes, and quadrics with their gradients; what the default and unit normals miss."""

import dataclasses

import numpy as np
import pytest
from trivariate_functions import noisy_torus

from testbed.conformance.meshes import AXES, ellipsoid, icosahedron
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.shooting_quads import ShootingQuads
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed_datasets.joined_faces import JoinedFaces
from testbed_schemes.a_patch import APatch
from testbed_schemes.mathematics.a_patch_sides import hull, nets_of_faces


def all_points(surface: Surface, steps: int = 10) -> Float:
    return np.concatenate([batch.jets(lattice(batch.sides, steps), 0).f.reshape(-1, 3) for batch in surface.batches])


def with_gradients(mesh: HermiteMesh, gradients: Float) -> HermiteMesh:
    return HermiteMesh(mesh.points, mesh.faces, gradients=gradients)


def hyperboloid(around: int = 12, up: int = 4) -> HermiteMesh:
    """A band of x^2 + y^2 - z^2 = 1, triangles, with gradients."""
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(around), np.arange(up), indexing="ij"))
    turn, z = 2.0 * np.pi * (i + 0.3 * j) / around, -0.6 + 1.2 * j / (up - 1)
    out = np.sqrt(1.0 + z * z)
    points = np.stack([out * np.cos(turn), out * np.sin(turn), z], axis=-1)
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(around), np.arange(up - 1), indexing="ij"))
    a, b = i * up + j, (i + 1) % around * up + j
    return HermiteMesh(
        points,
        np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)]),
        gradients=points * [1, 1, -1],
    )


def test_planes_are_recovered_within_a_curved_surface() -> None:
    mesh = JoinedFaces("flat").mesh(0)
    surface = APatch().fit(mesh)
    bary = np.random.default_rng(1).dirichlet(np.ones(3), 20)
    points = surface.evaluate(np.ones(20, dtype=int), bary, 0).f
    assert np.abs(points[:, 2]).max() == 0.0
    assert points == pytest.approx(np.einsum("nk,kx->nx", bary, mesh.points[mesh.faces[1]]), abs=1e-15)


def quadric_data(name: str) -> tuple[HermiteMesh, Float]:
    """A mesh with gradients of x . D x = 1, and D."""
    if name == "sphere":
        mesh = icosahedron()
        return with_gradients(mesh, 2.0 * mesh.points), np.ones(3)
    if name == "ellipsoid":
        return ellipsoid(), 1.0 / AXES**2
    return hyperboloid(), np.array([1.0, 1.0, -1.0])


@pytest.mark.parametrize("name", ["sphere", "ellipsoid", "hyperboloid"])
def test_quadrics_are_reproduced_with_their_gradients_and_curvatures(name: str) -> None:
    mesh, diagonal = quadric_data(name)
    surface = APatch(free="quadric").fit(mesh)
    assert surface.notes == {}
    for batch in surface.batches:
        assert isinstance(batch, ShootingTriangles | ShootingQuads)
        at = lattice(batch.sides, 8)
        at = at[(at > 0.01).all(axis=1) & (at.sum(axis=1) < (0.99 if batch.sides == 3 else 2.0)) & (at[:, 0] < 0.99)]
        points, gradient = batch.jets(at, 0).f, batch.gradient(at)
        assert np.abs((points * points * diagonal).sum(axis=-1) - 1.0).max() <= 1e-13
        slope = points * diagonal
        assert mesh.gradients is not None
        factor = norm(mesh.gradients[0]) / norm(diagonal * mesh.points[0])
        assert norm(gradient - factor * slope).max() <= 1e-12
        jet = batch.jets(at)
        # of x . D x = 1: K = det D / |D x|^4
        expected = diagonal.prod() / norm(slope) ** 4
        assert gauss(jet) == pytest.approx(expected, rel=1e-8, abs=1e-10)


def test_on_the_hyperboloid_all_faces_are_nonconvex() -> None:
    surface = APatch(free="quadric").fit(hyperboloid())
    assert surface.branches["nonconvex faces"] == len(surface.mesh.faces)


def test_the_default_reproduces_no_sphere() -> None:
    """3.1 % of the radius on the icosahedron: its coefficient is 0.829 where the sphere asks for 1.580."""
    mesh = icosahedron()
    surface = APatch().fit(mesh)
    assert np.abs(norm(all_points(surface, 30)) - 1.0).max() == pytest.approx(0.0315, abs=1e-4)
    doubled = hull(with_gradients(mesh, 2.0 * mesh.points), 0.05, 1e-12)
    nets = nets_of_faces(doubled, 0, np.zeros(20, dtype=bool))
    assert nets.default == pytest.approx(0.8291796, abs=5e-8)
    assert norm(nets.apex) ** 2 - 1.0 == pytest.approx(1.5799560, abs=5e-8)


def test_unit_normals_of_an_ellipsoid_do_not_give_it_back() -> None:
    sphere, axes = icosahedron(), np.array([1.0, 1.5, 0.8])
    mesh = HermiteMesh(sphere.points * axes, sphere.faces, gradients=sphere.points / axes)
    errors = {}
    for lengths in ("data", "unit"):
        points = all_points(dataclasses.replace(APatch(free="quadric"), lengths=lengths).fit(mesh), 8)
        errors[lengths] = np.abs((points**2 / axes**2).sum(axis=-1) - 1.0).max()
    assert errors["data"] <= 1e-13
    assert errors["unit"] == pytest.approx(3.1e-2, rel=0.03)
    only_normals = HermiteMesh(mesh.points, mesh.faces, mesh.normals)
    same = all_points(APatch(free="quadric").fit(only_normals), 8)
    assert np.abs((same**2 / axes**2).sum(axis=-1) - 1.0).max() == pytest.approx(errors["unit"], rel=1e-9)


def test_a_common_factor_of_all_vectors_changes_nothing() -> None:
    mesh = noisy_torus()
    assert mesh.gradients is not None
    one, other = (APatch().fit(with_gradients(mesh, factor * mesh.gradients)) for factor in (1.0, 37.0))
    assert all_points(one, 4) == pytest.approx(all_points(other, 4), abs=1e-13)
