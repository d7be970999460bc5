"""Curves that join the same corners, and sides that are a point: the lune between two triangles."""

import numpy as np
import pytest

from testbed.errors import PluginError
from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.domain import CORNERS, corner_distance, lattice
from testbed.geometry.edges import patch_edges
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.measures.climb import move
from testbed.measures.sampling import sample_points

#: Two triangles on the edge from vertex 0 to vertex 1; the first runs along it, the second back.
POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.8, 0.0], [0.5, -0.8, 0.0]])
FACES = np.array([[0, 1, 2], [1, 0, 3]])


class CollapsedQuads(BezierQuads):
    """A square whose sides u = 0 and u = 1 are points."""

    collapsed = (1, 3)


def bowed() -> Surface:
    """Quadratic triangles that leave a lune open between them along the edge, and the lune."""
    mesh = HermiteMesh(POINTS, FACES)
    corners = mesh.corner_points()
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    rim = np.array([[0.5, 0.2, 0.0], [0.5, -0.2, 0.0]])
    nets = np.stack([corners[:, 0], rim, middles[:, 2], corners[:, 1], middles[:, 1], corners[:, 2]], axis=1)
    # from the second face's rim at v = 0 to the first one's at v = 1
    quad = np.stack([POINTS[[0, 0]], rim[::-1], POINTS[[1, 1]]])[None]
    triangles = Part(
        BezierTriangles(nets), FACES, np.arange(2), np.tile(CORNERS[3], (2, 1, 1)), np.array([[1, 0, 0], [2, 0, 0]])
    )
    on_edge = CORNERS[3][[[0, 1, 1, 0]]]
    lune = Part(CollapsedQuads(quad), np.array([[0, 1, 1, 0]]), np.array([0]), on_edge, np.array([[2, 0, 1, 0]]))
    return Surface(mesh, (triangles, lune))


def test_sides_with_the_same_corners_are_paired_by_their_strands() -> None:
    surface = bowed()
    edges = surface.edges
    inner = edges[edges.interior]
    assert len(edges) == 6
    assert inner.ids.tolist() == [[0, 1], [0, 1]]
    # each of the two joins a triangle and the lune
    assert {frozenset(pair) for pair in zip(inner.left.part.tolist(), inner.right.part.tolist(), strict=True)} == {
        frozenset({0, 1})
    }
    assert sorted(inner.left.side.tolist() + inner.right.side.tolist()) == [0, 0, 0, 2]
    left, right = surface.edge_jets(inner, np.linspace(0.1, 0.9, 9), 1)
    np.testing.assert_allclose(left.f, right.f, rtol=0, atol=1e-15)
    np.testing.assert_allclose(left.normal, np.broadcast_to([0.0, 0.0, 1.0], left.normal.shape), atol=1e-15)
    np.testing.assert_allclose(right.normal, left.normal, atol=1e-15)


def test_without_strands_the_sides_do_not_fit_and_with_wrong_ones_they_do_not_join() -> None:
    parts = bowed().parts
    with pytest.raises(PluginError, match="do not fit together on the edge from corner 0 to corner 1"):
        patch_edges([part.corner_ids for part in parts], [part.faces for part in parts])
    turned = [np.array([[2, 0, 0], [1, 0, 0]]), np.array([[2, 0, 1, 0]])]
    with pytest.raises(PluginError, match="do not fit together"):
        patch_edges([part.corner_ids for part in parts], [part.faces for part in parts], turned)


def test_a_side_that_is_a_point_makes_no_edge() -> None:
    edges = bowed().edges
    assert (edges.ids[:, 0] != edges.ids[:, 1]).all()
    assert not ((edges.left.part == 1) & np.isin(edges.left.side, (1, 3))).any()


def test_places_are_found_in_the_faces_and_not_in_the_patch_beside_them() -> None:
    surface = bowed()
    middle = surface.evaluate(np.array([0, 1]), np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.0]]), 0).f
    np.testing.assert_allclose(middle, [[0.5, 0.1, 0.0], [0.5, -0.1, 0.0]], atol=1e-15)
    faces, places = surface.place(1, np.array([0]), np.array([[0.25, 0.7]]))
    assert faces.tolist() == [0]
    np.testing.assert_allclose(places, [[0.25, 0.0]], atol=1e-15)


def test_strands_have_the_shape_of_the_corners() -> None:
    part = bowed().parts[0]
    with pytest.raises(PluginError, match="strands has shape"):
        Part(part.batch, part.corner_ids, part.faces, part.corners_in_face, np.zeros((2, 4), dtype=np.int64))


def test_the_distance_from_a_collapsed_side_counts_as_that_from_a_corner() -> None:
    at = lattice(4, 10)
    np.testing.assert_array_equal(corner_distance(4, at, (1, 3)), np.minimum(at[:, 0], 1.0 - at[:, 0]))
    np.testing.assert_array_equal(corner_distance(4, at, (0, 2)), np.minimum(at[:, 1], 1.0 - at[:, 1]))


def test_samples_keep_curvature_off_collapsed_sides_and_steps_do_not_come_nearer() -> None:
    points = sample_points(4, 0.01, 4, (1, 3))
    away = np.minimum(points.at[:, 0], 1.0 - points.at[:, 0])
    assert (points.curved == (away > 0.0)).all()
    on_margin = points.at[np.abs(away - 0.01) < 1e-12]
    np.testing.assert_allclose(np.unique(on_margin[:, 1]), [0.0, 0.5, 1.0])
    assert len(on_margin) == 6
    rng = np.random.default_rng(5)
    centre = rng.uniform(0.02, 0.98, (100, 1, 2))
    moved = move(centre, rng.normal(size=(100, 7, 2)), 4, 0.01, (1, 3))
    assert (np.minimum(moved[..., 0], 1.0 - moved[..., 0]) >= 0.01 * (1.0 - 1e-9)).all()
    assert (moved != centre).any(axis=-1).mean() > 0.3
