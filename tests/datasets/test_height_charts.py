"""Graphs in their chart: the same surface, the same meshes, and the boundary's curves to follow."""

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.vectors import norm, unit
from testbed_datasets.graph import Graph
from testbed_datasets.height_charts import HeightChart
from testbed_datasets.height_field import HeightField


@pytest.mark.parametrize("spec", ["graph", "plane", "monkey-saddle", "graph[height=3,bowl=0]"])
@pytest.mark.parametrize("level", [0, 2])
def test_charts_have_the_meshes_of_the_dataset(spec: str, level: int) -> None:
    dataset = registry.dataset(spec)
    charted, expected = dataset.charted(), dataset.mesh(level)
    assert charted is not None
    mesh = charted.halved(level).sampled()
    # ids of middles may differ: vertices and faces by their places
    order, other = np.lexsort(mesh.points.T), np.lexsort(expected.points.T)
    assert np.abs(mesh.points[order] - expected.points[other]).max() < 1e-14
    assert mesh.normals is not None
    assert expected.normals is not None
    assert mesh.second_forms is not None
    assert expected.second_forms is not None
    assert np.abs(mesh.normals[order] - expected.normals[other]).max() < 1e-14
    assert np.abs(mesh.second_forms[order] - expected.second_forms[other]).max() < 1e-12
    assert np.abs(mesh.corner_points() - expected.corner_points()).max() < 1e-14


@pytest.mark.parametrize("spec", ["graph", "monkey-saddle"])
def test_the_boundary_is_followed_and_nothing_else(spec: str) -> None:
    charted = registry.dataset(spec).charted()
    assert charted is not None
    finer = charted.halved(2)
    mesh = finer.sampled()
    assert np.array_equal(finer.followed, mesh.boundary_edges[mesh.face_edges])
    tangents = mesh.face_data.side_tangents
    assert tangents is not None
    # above the straight sides of the plane's polygon the boundary curves stay in vertical planes
    face, side = np.nonzero(finer.followed)
    along = finer.at[face, (side + 1) % 3] - finer.at[face, side]
    given = tangents[face, side][..., :2]
    cross = given[..., 0] * along[:, None, 1] - given[..., 1] * along[:, None, 0]
    assert np.abs(cross).max() < 1e-14
    assert (np.einsum("nei,ni->ne", given, along) > 0.0).all()


def test_jets_of_every_order_are_those_of_the_polynomial() -> None:
    surface = HeightField(((1.0, 2.0, 3.0), (4.0, 5.0), (6.0,)))
    chart, at = HeightChart(surface, (-1.0, -1.0), (1.0, 1.0)), np.array([[0.5, -0.25], [0.0, 1.0]])
    x, y = at.T
    zero, one = np.zeros(2), np.ones(2)
    f = 1.0 + 2.0 * y + 3.0 * y**2 + 4.0 * x + 5.0 * x * y + 6.0 * x**2
    expected = [
        [x, y, f],
        [one, zero, 4.0 + 5.0 * y + 12.0 * x],
        [zero, one, 2.0 + 6.0 * y + 5.0 * x],
        [zero, zero, 12.0 * one],
        [zero, zero, 5.0 * one],
        [zero, zero, 6.0 * one],
    ]
    for order, rows in enumerate((1, 3, 6)):
        jet = chart.jets(np.zeros(2, dtype=np.int64), at, order)
        assert np.abs(jet.coefficients - np.moveaxis(np.array(expected[:rows]), 1, -1)).max() < 1e-14
        assert jet.order == order


def test_normals_in_the_chart_point_upward() -> None:
    charted = Graph().charted()
    jet = charted.jets()
    assert (jet.normal[..., 2] > 0.0).all()
    assert norm(jet.normal - unit(jet.normal)).max() < 1e-15
