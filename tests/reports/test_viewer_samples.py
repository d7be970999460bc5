"""Samples for a viewer are exact where they are: points, normals and curvatures of the patches, angles along edges."""

import math

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import barycentric, lattice
from testbed_reports.viewer.samples import SampledSurface, sampled


def samples(scheme: str, dataset: str = "octahedron", steps: int = 4) -> SampledSurface:
    data = registry.dataset(dataset)
    return sampled(registry.scheme(scheme).fit(data.mesh(0)), steps, data.surface)


@pytest.mark.parametrize("scheme", ["shirman-sequin", "gregory-charrot", "cubic-interpolant"])
def test_samples_are_those_of_the_surface_at_their_places(scheme: str) -> None:
    surface = registry.scheme(scheme).fit(registry.dataset("torus").mesh(0))
    (part,) = sampled(surface, 5).parts
    inside = (barycentric(lattice(3, 5)) > 0.1).all(axis=-1)
    at = lattice(3, 5)[inside]
    for patch in (0, len(part.faces) - 1):
        analysis = analyse(surface.parts[0].batch.take(np.array([patch])).jets(at, 2))
        np.testing.assert_allclose(part.gauss[patch, inside], analysis.gauss[0], rtol=1e-12)
        np.testing.assert_allclose(part.mean[patch, inside], analysis.mean[0], rtol=1e-12)
        np.testing.assert_allclose(part.normals[patch, inside], analysis.normal[0], rtol=1e-12)


@pytest.mark.parametrize("scheme", ["nielson", "gregory-charrot", "triangular-gregory", "loop", "shirman-sequin"])
def test_corners_of_blended_patches_have_normals_and_curvatures(scheme: str) -> None:
    for part in samples(scheme, "torus").parts:
        for values in (part.points, part.normals, part.gauss, part.mean, part.distance):
            assert np.isfinite(values).all()
        assert np.abs(part.gauss).max() < 1e3


def test_curvature_beside_a_corner_stands_for_it_only_there() -> None:
    (part,) = samples("triangular-gregory", "torus", 4).parts
    surface = registry.scheme("triangular-gregory").fit(registry.dataset("torus").mesh(0))
    corner, middle = lattice(3, 4)[0], np.full(2, 1.0 / 3.0)
    near = analyse(surface.parts[0].batch.jets((0.999 * corner + 0.001 * middle)[None], 2))
    np.testing.assert_allclose(part.gauss[:, 0], near.gauss[:, 0], rtol=1e-9)


def test_edges_of_the_flat_octahedron_bend_by_its_dihedral_angle_all_along() -> None:
    mine = samples("flat")
    assert mine.edge_angle.shape == (12, 5)
    np.testing.assert_allclose(mine.edge_angle, math.degrees(math.acos(1.0 / 3.0)), rtol=1e-12)


def test_edges_are_sides_of_patches_and_those_of_the_boundary_have_no_angle() -> None:
    surface = registry.scheme("shirman-sequin").fit(registry.dataset("graph").mesh(0))
    mine = sampled(surface, 3)
    assert set(map(tuple, np.stack([mine.edge_patch, mine.edge_side], axis=-1).tolist())) == set(
        zip(surface.edges.left.patch.tolist(), surface.edges.left.side.tolist(), strict=True)
    )
    boundary = np.isnan(mine.edge_angle).all(axis=-1)
    assert boundary.sum() == (~surface.edges.interior).sum() > 0
    assert np.nanmax(mine.edge_angle) < 1e-5


def test_distances_are_asked_for_only_where_there_is_an_exact_surface() -> None:
    surface = registry.scheme("flat").fit(registry.dataset("octahedron").mesh(0))
    assert np.isnan(sampled(surface, 2).values("distance")).all()
    assert np.nanmax(samples("flat").values("distance")) == pytest.approx(1.0 - math.sqrt(1.0 / 3.0), rel=0.2)
