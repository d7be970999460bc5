"""Hansford's scheme as completed here: rows that join in four dimensions, exact conics, curvature as established."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry import curvature
from testbed.geometry.bernstein import evaluate_curve, multiply_curves
from testbed.geometry.bezier import RationalBezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, norm, unit
from testbed_schemes.hansford import Hansford, Inner, check_weights, joined_points


def patches(mesh: HermiteMesh, inner: Inner = "fitted") -> RationalBezierTriangles:
    (batch,) = Hansford(inner).fit(mesh).batches
    assert isinstance(batch, RationalBezierTriangles)
    return batch


def random_conics(count: int = 50, seed: int = 4) -> tuple[Float, Float, Float]:
    """Conics (count, 3, 4) with end weights 1, and normals across their end tangents."""
    rng = np.random.default_rng(seed)
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.8, 0.0], [2.0, 0.0, 0.0]]) + 0.2 * rng.normal(size=(count, 3, 3))
    weights = np.ones((count, 3, 1))
    weights[:, 1, 0] = rng.uniform(0.3, 1.0, count)
    normals = [unit(np.cross(points[:, r + 1] - points[:, r], [0.1, 0.0, 1.0])) for r in (0, 1)]
    return np.concatenate([weights * points, weights], axis=-1), normals[0], normals[1]


def rows_of(conics: Float, normals: tuple[Float, Float], seed: int = 5) -> Float:
    """Second rows (count, 4, 4) with random a, b, k: they fulfil the join."""
    rng = np.random.default_rng(seed)
    a, b, k = (rng.uniform(0.3, 0.7, (len(conics), 3, 1)) for _ in range(3))
    apex = conics[:, 1, :3] / conics[:, 1, 3:]
    legs = (apex - conics[:, 0, :3], conics[:, 2, :3] - apex)
    across = np.stack([unit(np.cross(n, leg)) for n, leg in zip(normals, legs, strict=True)], axis=1)
    field = np.concatenate([across, np.zeros((len(conics), 2, 1))], axis=-1)
    return np.asarray(multiply_curves(a, conics[:, :2]) + multiply_curves(b, conics[:, 1:]) + multiply_curves(k, field))


def test_a_row_that_joins_is_kept() -> None:
    conics, n0, n1 = random_conics()
    row = rows_of(conics, (n0, n1))
    first, second = joined_points(conics, row, n0, n1)
    assert np.abs(first - row[:, 1]).max() < 1e-13
    assert np.abs(second - row[:, 2]).max() < 1e-13


def test_any_other_row_is_made_to_join_and_changed_as_little_as_possible() -> None:
    conics, n0, n1 = random_conics()
    joined = rows_of(conics, (n0, n1))
    row = joined.copy()
    row[:, 1:3] += 0.1 * np.random.default_rng(6).normal(size=(len(row), 2, 4))
    row[:, 1], row[:, 2] = joined_points(conics, row, n0, n1)
    # with the conic, its derivative and a row that joins: dependent in four dimensions
    t = np.linspace(0.0, 1.0, 11)
    spanning = [evaluate_curve(net, t)[0] for net in (conics[:, :2], conics[:, 1:], joined, row)]
    determinants = np.linalg.det(np.stack([unit(vector) for vector in spanning], axis=-1))
    assert np.abs(determinants).max() < 1e-14
    again = joined_points(conics, row, n0, n1)
    assert np.abs(again[0] - row[:, 1]).max() < 1e-13
    assert np.abs(again[1] - row[:, 2]).max() < 1e-13


def test_the_join_moves_and_grows_with_the_data_and_reverses_with_the_edge() -> None:
    conics, n0, n1 = random_conics()
    row = rows_of(conics, (n0, n1))
    row[:, 1:3] += 0.1 * np.random.default_rng(6).normal(size=(len(row), 2, 4))
    points = joined_points(conics, row, n0, n1)

    def moved(a: Float) -> Float:
        return np.concatenate([100.0 * (a[..., :3] + a[..., 3:] * np.array([1.0, -2.0, 0.5])), a[..., 3:]], axis=-1)

    for found, expected in zip(joined_points(moved(conics), moved(row), n0, n1), points, strict=True):
        assert np.abs(found - moved(expected)).max() < 1e-11
    for found, expected in zip(joined_points(conics[:, ::-1], row[:, ::-1], n1, n0), points[::-1], strict=True):
        assert np.abs(found - expected).max() < 1e-13


def test_boundaries_on_the_octahedron_are_great_circles() -> None:
    batch = patches(registry.dataset("octahedron").mesh(0))
    t = np.linspace(0.0, 1.0, 17)
    edge = batch.jets(np.stack([t, np.zeros_like(t)], axis=-1), 0).f
    assert np.abs(norm(edge) - 1.0).max() < 1e-14


@pytest.mark.parametrize(
    ("name", "inner", "extremes"),
    [
        ("octahedron", "kept", (0.167, 3.117)),
        ("octahedron", "fitted", (0.678, 1.523)),
        ("icosahedron", "fitted", (0.935, 1.084)),
    ],
)
def test_the_curvature_over_spheres(name: str, inner: Inner, extremes: tuple[float, float]) -> None:
    K = curvature.gauss(patches(registry.dataset(name).mesh(0), inner).jets(lattice(3, 40)))
    assert (K.min(), K.max()) == pytest.approx(extremes, abs=2e-3)


def test_boundaries_of_all_patches_are_conics_raised_to_quartics() -> None:
    mesh = registry.dataset("ellipsoid").mesh(0)
    boundary = patches(mesh).homogeneous[:, [0, 1, 3, 6, 10]]
    # in homogeneous coordinates they are raised parabolas: the third differences vanish
    assert np.abs(np.diff(boundary, 3, axis=1)).max() < 1e-14
    assert boundary[:, 2, 3].max() < 0.95


@pytest.mark.parametrize("inner", ["fitted", "kept"])
def test_flat_data_give_planes_with_their_linear_parametrisation(inner: Inner) -> None:
    batch = patches(registry.dataset("plane").mesh(0), inner)
    assert np.abs(batch.weights - 1.0).max() < 1e-14
    jet = batch.jets(lattice(3, 5))
    assert max(norm(jet.fuu).max(), norm(jet.fuv).max(), norm(jet.fvv).max()) < 1e-12


def test_an_edge_with_an_inflection_is_refused_by_its_vertices() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    normals = unit(np.array([[-0.3, -0.3, 1.0], [0.3, -0.2, 1.0], [-0.5, -0.3, 1.0]]))
    with pytest.raises(Refused, match="no conic for 1 of 3 edges, the first from vertex 0 to vertex 2: "):
        Hansford().fit(HermiteMesh(points, [[0, 1, 2]], normals))


def test_weights_that_are_not_positive_are_refused_by_the_face() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    net = np.ones((len(mesh.faces), 3, 15, 4))
    check_weights(Hansford(), mesh, net)
    for bad in (0.0, -0.1, np.nan):
        net[3, 1, 7, 3] = bad
        with pytest.raises(Refused, match="face 3"):
            check_weights(Hansford(), mesh, net)
