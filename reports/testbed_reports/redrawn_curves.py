"""Pictures of boundary curves that papers print, drawn again: over arcs of a circle, and on edges of data."""

from pathlib import Path

import numpy as np

from testbed import registry
from testbed.errors import TestbedError
from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, dot, unit
from testbed_reports.redrawn import Redrawn, Shown
from testbed_reports.rendering.combs import across_plane
from testbed_reports.rendering.curve_plots import CurvePlot, write_curve_plots


def draw_curves(path: Path, picture: Redrawn) -> Path:
    """Write a picture of plane curves; TestbedError if there is no such edge or a curve does not exist."""
    plots = [curve_plot(one) for one in picture.shows]
    return write_curve_plots(path, plots, picture.columns, picture.caption)


def curve_plot(one: Shown) -> CurvePlot:
    """Return the curve of a row."""
    curve = registry.boundary_curve(one.curve)
    edge = arc(one.arc) if one.arc > 0.0 else _edge(one)
    (control_points,), _ = curve.curves(edge)
    if not np.isfinite(control_points).all():
        raise TestbedError(f"{curve} has no curve for {one.title!r}: take another edge")
    return CurvePlot(one.title, control_points, _given(edge, control_points))


def arc(degrees: float) -> EdgeData:
    """Return the data at the ends of an arc of the unit circle, about its highest point; normals outwards."""
    half = np.radians(0.5 * degrees)
    ends = np.array([[-np.sin(half), 0.0, np.cos(half)], [np.sin(half), 0.0, np.cos(half)]])
    forms = np.eye(3) - ends[:, :, None] * ends[:, None, :]
    return EdgeData(*(row[None] for row in (*ends, *ends, *forms)))


def _edge(one: Shown) -> EdgeData:
    mesh = registry.dataset(one.dataset).mesh(one.level)
    (found,) = np.nonzero((mesh.edges == np.sort(np.array(one.edge))).all(axis=1))
    if not len(found):
        raise TestbedError(f"{one.dataset} has no edge from vertex {one.edge[0]} to vertex {one.edge[1]}")
    return mesh.edge_data[found]


def _given(edge: EdgeData, control_points: Float) -> tuple[float, float]:
    """Curvature at the ends of the section of the data's surface with the curve's plane; positive along the bulge."""
    if edge.W0 is None or edge.W1 is None or edge.n0 is None or edge.n1 is None:
        raise TestbedError("the curvature of data without second fundamental forms is not known: take other data")
    along, up = across_plane(control_points)
    across = np.cross(along, up)
    found = []
    for normal, form in ((edge.n0[0], edge.W0[0]), (edge.n1[0], edge.W1[0])):
        tangent = unit(np.cross(normal, across))
        # the normal curvature of a section, over the cosine of its plane and the normal (Meusnier)
        upright = unit(normal - dot(normal, across) * across)
        found.append(float(tangent @ form @ tangent / dot(normal, upright)) * float(np.sign(dot(upright, up)) or 1.0))
    return found[0], found[1]
