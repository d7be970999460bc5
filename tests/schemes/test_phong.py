"""Phong tessellation: the same as the published blend of projections, corners matched in position only."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry import curvature
from testbed.geometry.domain import CORNERS, barycentric, lattice
from testbed.geometry.vectors import angle_between, dot, norm
from testbed_schemes.phong import Phong


@pytest.mark.parametrize("alpha", [0.0, 0.6, 0.75, 1.0])
def test_the_patch_is_the_published_blend_of_projections(alpha: float) -> None:
    mesh = registry.dataset("torus").mesh(0)
    at = lattice(3, 5)
    b, corners, normals = barycentric(at), mesh.corner_points(), mesh.corner_normals()
    flat = np.einsum("si,fid->fsd", b, corners)
    heights = dot(flat[:, :, None] - corners[:, None], normals[:, None])
    projected = flat[:, :, None] - heights[..., None] * normals[:, None]
    expected = (1.0 - alpha) * flat + alpha * np.einsum("si,fsid->fsd", b, projected)
    assert norm(Phong(alpha).fit(mesh).batches[0].jets(at, 0).f - expected).max() < 1e-14


def test_the_normals_at_the_corners_are_not_the_data() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    jet = Phong().fit(mesh).batches[0].jets(CORNERS[3], 1)
    assert norm(jet.f - mesh.corner_points()).max() < 1e-15
    # by hand, at (1, 0, 0): legs (-1/8, 7/8, 0) and (-1/8, 0, 7/8), so that the normal is (7, 1, 1) / sqrt 51
    expected = np.degrees(np.arccos(7.0 / np.sqrt(51.0)))
    assert np.degrees(angle_between(jet.normal, mesh.corner_normals())) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("alpha", "limit"), [(0.5, 1.0), (0.75, 2.25)])
def test_on_fine_meshes_it_bends_by_twice_alpha(alpha: float, limit: float) -> None:
    surface = Phong(alpha).fit(registry.dataset("octahedron").mesh(5))
    assert curvature.gauss(surface.batches[0].jets(lattice(3, 2))) == pytest.approx(limit, rel=0.02)


def test_alpha_is_a_number() -> None:
    with pytest.raises(SpecError, match="alpha must be finite"):
        Phong(float("nan"))
