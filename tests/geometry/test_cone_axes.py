"""The narrowest cones about sets of directions are optimal, and there is none where the directions surround a point."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.conformance.meshes import fan, graph, icosahedron
from testbed.geometry.cone_axes import cone_axes, face_normals, fans
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, dot, norm, unit


def directions(seed: int, sets: int, count: int, spread: float) -> Float:
    """Random unit vectors about a random one in each set."""
    random = np.random.default_rng(seed)
    return unit(random.normal(size=(sets, 1, 3)) + spread * random.normal(size=(sets, count, 3)))


@given(seed=st.integers(0, 10**6), count=st.integers(1, 12), spread=st.sampled_from([1e-6, 0.01, 0.3, 1.0]))
def test_the_axis_is_a_combination_of_vectors_on_the_rim_and_no_vector_lies_outside(
    seed: int, count: int, spread: float
) -> None:
    """By duality, with weights that are not negative this makes it the best."""
    from scipy.optimize import nnls

    vectors = directions(seed, 4, count, spread)
    axes, cosines = cone_axes(vectors)
    for some, axis, cosine in zip(vectors, axes, cosines, strict=True):
        if np.isnan(cosine):
            # no open half space holds them: a combination of them vanishes
            _, rest = nnls(np.vstack([some.T, np.ones(count)]), np.array([0.0, 0.0, 0.0, 1.0]))
            assert rest < 1e-6
            continue
        assert norm(axis) == pytest.approx(1.0, abs=1e-14)
        assert dot(some, axis).min() >= cosine - 1e-13
        rim = some[dot(some, axis) <= cosine + 1e-12]
        _, rest = nnls(rim.T, axis)
        assert rest < 1e-6
        assert cosine > 0.0


def test_known_cones() -> None:
    e = np.eye(3)
    axes, cosines = cone_axes(np.stack([e, e[[0, 0, 0]], e[[0, 1, 0]]]))
    assert axes == pytest.approx(
        np.stack([np.ones(3) / np.sqrt(3), e[0], [np.sqrt(0.5), np.sqrt(0.5), 0.0]]), abs=1e-15
    )
    assert cosines == pytest.approx([np.sqrt(1 / 3), 1.0, np.sqrt(0.5)], abs=1e-15)


def test_directions_that_surround_a_point_have_no_cone() -> None:
    opposite = np.stack([np.eye(3)[0], -np.eye(3)[0], np.eye(3)[2]])
    axes, cosines = cone_axes(np.stack([icosahedron().points, np.resize(opposite, (12, 3))]))
    assert np.isnan(axes).all()
    assert np.isnan(cosines).all()


def test_sets_do_not_depend_on_others_or_on_repeats() -> None:
    vectors = directions(5, 40, 9, 0.5)
    axes, cosines = cone_axes(vectors)
    for one in (0, 17):
        alone, cosine = cone_axes(np.concatenate([vectors[one : one + 1], vectors[one : one + 1, 4:5]], axis=1))
        assert np.array_equal(alone[0], axes[one], equal_nan=True)
        assert np.array_equal(cosine[0], cosines[one], equal_nan=True)


def test_fans_hold_all_faces_at_a_vertex() -> None:
    for mesh in (icosahedron(), graph(*fan())):
        around = fans(Triangulation(mesh.faces, len(mesh.points)), np.arange(len(mesh.points)))
        for vertex, faces in enumerate(around):
            assert set(faces.tolist()) == set(np.flatnonzero((mesh.faces == vertex).any(axis=1)).tolist())


def test_normals_and_areas_of_faces() -> None:
    mesh = icosahedron()
    normals, areas = face_normals(2.0 * mesh.points, mesh.faces)
    assert normals == pytest.approx(unit(mesh.corner_points().mean(axis=1)), abs=1e-15)
    side = 2.0 * norm(mesh.points[mesh.edges[0, 0]] - mesh.points[mesh.edges[0, 1]])
    assert areas == pytest.approx(np.sqrt(3) / 4 * side**2, rel=1e-14)
