"""Charted meshes: sampling, splitting and halving in the charts."""

from dataclasses import dataclass

import numpy as np
import pytest

from testbed.geometry.charted import ChartedMesh, Charts, triangle_fan
from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, Int, norm


@dataclass(frozen=True)
class TwoCylinders(Charts):
    """Cylinders of radius 1 and ``radius`` about lines parallel to y, which touch along x = z = 0: G1 there only."""

    radius: float = 0.5

    def __len__(self) -> int:
        return 2

    def polygon(self, chart: int) -> Float:
        square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        return square - np.array([1.0, 0.0]) if chart == 0 else square

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        r = np.where(chart == 0, 1.0, self.radius)
        u, v, zero, one = at[:, 0], at[:, 1], np.zeros(len(at)), np.ones(len(at))
        s, c = np.sin(u / r), np.cos(u / r)
        f = [r * s, v, r * (c - 1.0)]
        rows = [f, [c, zero, -s], [zero, one, zero], [-s / r, zero, -c / r], [zero] * 3, [zero] * 3]
        return Jet(np.stack([np.stack(row, axis=-1) for row in rows])[: (1, 3, 6)[order]])


def strip() -> ChartedMesh:
    """Two triangles in each cylinder, left of x = 0 and right of it."""
    faces = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    place = np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]])
    followed = np.array([[1, 1, 0], [0, 1, 1], [1, 1, 0], [0, 1, 1]], dtype=bool)
    return ChartedMesh(TwoCylinders(), faces, np.array([0, 0, 1, 1]), place[faces], followed)


def test_samples_are_those_of_the_charts_and_curvature_is_kept_apart_where_they_disagree() -> None:
    mesh = strip().sampled()
    assert mesh.normals is not None
    assert mesh.second_forms is not None
    assert np.allclose(mesh.normals[[1, 4]], [0.0, 0.0, 1.0])
    by_corner = mesh.face_data.corner_second_forms
    assert by_corner is not None
    # across the axis the normal curvature is 1 on the left and 2 on the right
    assert np.allclose(by_corner[0, 1], np.diag([1.0, 0.0, 0.0]))
    assert np.allclose(by_corner[2, 0], np.diag([2.0, 0, 0]))
    low, high = mesh.second_forms[1, 0, 0], by_corner[..., 0, 0].max()
    assert 1.0 < low < 2.0 == pytest.approx(high)


def test_followed_sides_have_the_tangents_of_their_curves_the_same_from_both_faces() -> None:
    mesh = strip().halved(2).sampled()
    data = mesh.edge_data
    assert data.t0 is not None
    assert data.t1 is not None
    followed = np.isfinite(data.t0).all(axis=1)
    assert followed.sum() == 4 * 7  # seven straight sides of the strip, in four pieces each
    straight = followed & (np.abs(data.p1[:, 1] - data.p0[:, 1]) > 1e-9)
    assert np.allclose(np.abs(data.t0[straight]), [0.0, 1.0, 0.0])
    arcs = followed & ~straight
    assert np.allclose(data.t0[arcs, 1], 0.0, atol=1e-15)
    assert np.all(np.abs(data.t0[arcs, 0]) > 0.4)


def test_halving_makes_a_conforming_mesh_of_samples() -> None:
    for levels in range(4):
        charted = strip().halved(levels)
        mesh = charted.sampled()
        assert len(mesh.faces) == 4 * 4**levels
        assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == 1
        x, y, z = mesh.points.T
        r = np.where(x <= 0.0, 1.0, 0.5)
        assert np.allclose(np.hypot(x, z + r), r)
        assert y.min() == 0.0
        assert y.max() == 1.0
        assert np.array_equal(mesh.points[:6], strip().sampled().points)


def test_children_on_a_followed_side_are_followed_and_inner_ones_are_not() -> None:
    charted = strip()
    third = np.array([[[1.0, 0, 0], [2 / 3, 1 / 3, 0], [0, 0, 1.0]], [[2 / 3, 1 / 3, 0], [0, 1.0, 0], [0, 0, 1.0]]])
    children = charted.split(np.array([[0, 2, 1], [2, 3, 1]]), np.array([0, 0]), third)
    assert children.followed.tolist() == [[True, False, False], [True, True, False]]
    assert np.allclose(children.at[0, 1], [-2 / 3, 0.0])


def test_charts_that_do_not_meet_are_found_out() -> None:
    charted, shift = strip(), np.array([0.0, 0.0, 0.1, 0.1])
    at = charted.at + np.stack([np.zeros(4), shift], axis=-1)[:, None]
    apart = ChartedMesh(charted.charts, charted.faces, charted.chart, at, charted.followed)
    with pytest.raises(ValueError, match="share their sides"):
        apart.sampled()


def test_a_fan_covers_its_polygon() -> None:
    angle = 2.0 * np.pi * np.arange(5) / 5
    polygon = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    corners, centre = triangle_fan(polygon)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert (area > 0.0).all()
    assert area.sum() == pytest.approx(2.5 * np.sin(2.0 * np.pi / 5.0))
    assert norm(np.append(centre, 0.0)) < 1e-15
