"""Polynomial graphs as charts: meshes that are refined in the plane keep their boundary, and patches follow it."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.charted import ChartedMesh, Charts
from testbed.geometry.edges import HalfEdges
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.vectors import Bool, Float, Int
from testbed_datasets.height_field import HeightField


@dataclass(frozen=True)
class HeightChart(Charts):
    """The graph of a polynomial in the one chart (x, y, f).

    Parameters
    ----------
    surface
        The graph.
    low, high
        Corners (x, y) of the rectangle it is taken over.
    """

    surface: HeightField
    low: tuple[float, float]
    high: tuple[float, float]

    def __len__(self) -> int:
        return 1

    def polygon(self, chart: int) -> Float:
        """The rectangle's corners, (4, 2)."""
        del chart
        (left, bottom), (right, top) = self.low, self.high
        return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        """Jets (rows, N, 3) at places (N, 2) of the plane."""
        del chart
        rows = np.zeros((ROWS[order], len(at), 3))
        rows[0, :, :2] = at
        rows[1:2, :, 0] = rows[2:3, :, 1] = 1.0  # empty at order 0
        rows[:, :, 2] = self.surface.jet(at[:, 0], at[:, 1])[: ROWS[order]]
        return Jet(rows)


def charted_graph(surface: HeightField, plane: Float, faces: Int) -> ChartedMesh:
    """Return the mesh over vertices (V, 2) of the plane in the chart of a graph; its boundary is followed."""
    (left, bottom), (right, top) = plane.min(axis=0).tolist(), plane.max(axis=0).tolist()
    chart = HeightChart(surface, (left, bottom), (right, top))
    return ChartedMesh(chart, faces, np.zeros(len(faces), dtype=np.int64), plane[faces], boundary_sides(faces))


def boundary_sides(faces: Int) -> Bool:
    """(F, 3) true for sides of triangles that no other triangle has."""
    halves = HalfEdges.between(faces.ravel(), np.roll(faces, -1, axis=1).ravel())
    alone = (halves.forward < 0) | (halves.backward < 0)
    sides: Bool = alone[halves.edge].reshape(faces.shape)
    return sides
