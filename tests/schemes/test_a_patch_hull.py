"""Apexes of the tetrahedra on faces: the conditions they satisfy, the paper's heights, and the height 0 it prints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trivariate_functions import noisy_torus

from testbed.conformance.meshes import icosahedron
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_datasets.joined_faces import Case, JoinedFaces
from testbed_schemes.mathematics.a_patch_coefficients import face_nets
from testbed_schemes.mathematics.a_patch_hull import apex_heights, height_conditions
from testbed_schemes.mathematics.a_patch_sides import SIDES, face_normals, hull, nets_of_faces

NUMBER1, NUMBER3 = [0, 3, 5], [1, 2, 4]


def random_faces(seed: int, count: int = 20) -> tuple[Float, Float, Float]:
    """Triangles, vectors at their corners within some sixty degrees of their normals, and these."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 3, 3))
    normals = face_normals(corners)
    vectors = rng.uniform(0.5, 2.0, (count, 3, 1)) * normals[:, None] + 0.8 * rng.uniform(-1.0, 1.0, corners.shape)
    vectors += np.maximum(0.1 - dot(vectors, normals[:, None]), 0.0)[..., None] * normals[:, None]
    return corners, vectors, normals


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 0.5))
@settings(max_examples=40, deadline=None)
def test_layer_one_is_positive_at_corners_and_not_negative_on_edges(seed: int, epsilon: float) -> None:
    corners, vectors, normals = random_faces(seed)
    heights = apex_heights(corners, vectors, normals, epsilon)
    apex = corners.mean(axis=1) + heights[:, None] * normals
    nets = face_nets(np.arange(20), corners, vectors, apex, np.zeros(20, dtype=bool))
    size = np.abs(nets.layer1).max(axis=1, keepdims=True)
    assert (nets.layer1[:, NUMBER1] > 0.0).all()
    assert (nets.layer1[:, NUMBER3] >= -1e-13 * size).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_at_the_heights_of_the_conditions_the_coefficients_vanish(seed: int) -> None:
    corners, vectors, normals = random_faces(seed)
    single, pair = height_conditions(corners, vectors, normals)
    centre = corners.mean(axis=1)
    for s, (number1, number3) in enumerate(zip(NUMBER1, NUMBER3[::-1], strict=True)):
        for heights, place in ((single[:, s], number1), (pair[:, s], number3)):
            apex = centre + heights[:, None] * normals
            nets = face_nets(np.arange(20), corners, vectors, apex, np.zeros(20, dtype=bool))
            size = np.abs(nets.layer1).max(axis=1) * (1.0 + np.abs(heights))
            assert (np.abs(nets.layer1[:, place]) <= 1e-12 * size).all()
    # how the coefficient at a corner grows with the height
    nets = face_nets(np.arange(20), corners, vectors, centre + normals, np.zeros(20, dtype=bool))
    slope = dot(normals[:, None], vectors)
    assert nets.layer1[:, NUMBER1] == pytest.approx((1.0 - single) * slope / 3.0, abs=1e-11)


@pytest.mark.parametrize(
    ("case", "positive", "negative"),
    [("convex", (4.46669776, 4.46669776), None), ("mixed", (4.46669776, 4.46669776), (None, 3.24302998))],
)
def test_the_heights_over_the_papers_faces(
    case: Case, positive: tuple[float, ...], negative: tuple[float | None, ...] | None
) -> None:
    found = hull(JoinedFaces(case).mesh(0), 0.05, 1e-12)
    heights = norm(found.apexes - found.mesh.corner_points().mean(axis=1))
    assert heights[0] == pytest.approx(positive, abs=5e-9)
    expected = (None, None) if negative is None else negative
    for height, value in zip(heights[1], expected, strict=True):
        assert np.isnan(height) if value is None else height == pytest.approx(value, abs=5e-9)


def test_on_round_data_a_condition_of_an_edge_decides_and_its_coefficient_is_zero() -> None:
    """Number 3 coefficients may vanish exactly: on figure 6 and on the icosahedron."""
    round_data = icosahedron()
    for mesh in (
        JoinedFaces("convex").mesh(0),
        HermiteMesh(round_data.points, round_data.faces, gradients=round_data.points),
    ):
        found = hull(mesh, 0.05, 1e-12)
        nets = nets_of_faces(found, 0, np.zeros(len(mesh.faces), dtype=bool))
        assert np.abs(nets.layer1[:, NUMBER3]).min(axis=1) == pytest.approx(0.0, abs=1e-14)


def test_the_printed_least_height_of_zero_gives_tetrahedra_without_a_volume() -> None:
    """Where all conditions hold below a face, the paper's maximum is its 0: on a noisy torus that happens."""
    found = hull(noisy_torus(), 0.05, 1e-12)
    corners, vectors = found.mesh.corner_points(), found.vectors[found.mesh.faces]
    degenerate = 0
    for side, sign in enumerate(SIDES):
        faces = found.standing_faces(side)
        base, normals = corners[faces], sign * face_normals(corners[faces])
        single, pair = height_conditions(base, sign * vectors[faces], normals)
        printed = np.maximum(np.maximum(single.max(axis=1) + 1e-3, pair.max(axis=1)), 0.0)
        degenerate += int((printed == 0.0).sum())
        edges = base[:, 1:] - base[:, :1]
        volume = dot(cross(edges[:, 0], edges[:, 1]), found.apexes[side, faces] - base[:, 0])
        area, length = norm(cross(edges[:, 0], edges[:, 1])), norm(edges).min(axis=1)
        assert (sign * volume >= 0.03 * area * length).all()
    assert degenerate > 0


def test_both_sides_are_one_construction_in_mirrored_frames() -> None:
    mesh = noisy_torus()
    one, other = hull(mesh, 0.05, 1e-12), hull(mesh.flipped(), 0.05, 1e-12)
    assert other.apexes[::-1] == pytest.approx(one.apexes, abs=1e-14, nan_ok=True)
