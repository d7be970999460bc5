"""Boundary curves that follow given ones: the boundary of a surface, the edges of a network of charts."""

from dataclasses import dataclass

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.charted import ChartedMesh, Charts
from testbed.geometry.jets import Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, dot, norm, quadratic_form, unit


@dataclass(frozen=True)
class Wave(Charts):
    """The graph of sin x cosh(y) / 2 + y^2 over a parallelogram whose sides are slanted: curved in space."""

    def __len__(self) -> int:
        return 1

    def polygon(self, chart: int) -> Float:
        del chart
        return np.array([[0.2, 0.0], [1.2, 0.1], [1.4, 1.0], [0.4, 0.9]])

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        del chart
        x, y = at.T
        zero, one = np.zeros(len(at)), np.ones(len(at))
        s, c, sh, ch = 0.5 * np.sin(x), 0.5 * np.cos(x), np.sinh(y), np.cosh(y)
        rows = [
            [x, y, s * ch + y * y],
            [one, zero, c * ch],
            [zero, one, s * sh + 2.0 * y],
            [zero, zero, -s * ch],
            [zero, zero, c * sh],
            [zero, zero, s * ch + 2.0],
        ]
        return Jet(np.stack([np.stack(row, axis=-1) for row in rows])[: (1, 3, 6)[order]])


def wave(levels: int) -> HermiteMesh:
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    followed = np.array([[True, True, False], [False, True, True]])
    charts = Wave()
    return (
        ChartedMesh(charts, faces, np.zeros(2, np.int64), charts.polygon(0)[faces], followed).halved(levels).sampled()
    )


@pytest.mark.parametrize("name", ["hermite", "hermite-space"])
def test_curves_on_the_boundary_have_its_tangents_and_its_normal_curvature(name: str) -> None:
    mesh = wave(2)
    points = registry.boundary_curve(name).network(mesh).control_points
    data, on_boundary = mesh.edge_data, mesh.boundary_edges
    assert data.t0 is not None
    assert np.array_equal(np.isfinite(data.t0).all(axis=1), on_boundary)
    for end, n, t, W in ((0, data.n0, data.t0, data.W0), (3, data.n1, data.t1, data.W1)):
        assert n is not None
        assert t is not None
        assert W is not None
        inner = points[:, abs(end - 1)] - points[:, end]
        further = points[:, abs(end - 2)] - points[:, abs(end - 1)]
        sign = 1.0 if end == 0 else -1.0
        assert np.allclose(sign * unit(inner)[on_boundary], t[on_boundary], atol=1e-12)
        bend = 2.0 / 3.0 * dot(n, further - inner) / dot(inner, inner)
        assert np.allclose(bend[on_boundary], -quadratic_form(t, W, t)[on_boundary], atol=1e-9)


def test_the_boundary_of_an_approximation_is_smooth_where_that_of_the_surface_is() -> None:
    mesh = wave(2)
    followed = registry.scheme("cubic-interpolant").fit(mesh)
    projected = registry.scheme("cubic-interpolant[boundary=projected]").fit(mesh)
    corners = {(0.2, 0.0), (1.2, 0.1), (1.4, 1.0), (0.4, 0.9)}

    def kinks(surface: object) -> Float:
        """Angles between the boundary's tangents before and after each vertex that is no corner."""
        points = surface.batches[0].control_points  # type: ignore[attr-defined]
        # control points 300 210 201 120 111 102 030 021 012 003: sides 0, 1, 2
        sides = np.stack([points[:, [0, 1, 3, 6]], points[:, [6, 7, 8, 9]], points[:, [9, 5, 2, 0]]], axis=1)
        out, back = {}, {}
        for face, side in np.argwhere(mesh.edge_faces[mesh.face_edges].min(axis=2) < 0).tolist():
            curve = sides[face, side]
            out[int(mesh.faces[face, side])] = unit(curve[1] - curve[0])
            back[int(mesh.faces[face, (side + 1) % 3])] = unit(curve[3] - curve[2])
        inner = [v for v in out if tuple(np.round(mesh.points[v, :2], 12)) not in corners]
        assert len(inner) == 12
        return np.array([norm(out[v] - back[v]) for v in inner])

    assert kinks(followed).max() < 1e-12
    assert kinks(projected).max() > 1e-3


def test_other_edges_are_as_without_curves_to_follow() -> None:
    mesh = wave(1)
    free = HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms)
    for name in ("hermite", "hermite-space"):
        curve = registry.boundary_curve(name)
        given, plain = curve.network(mesh).control_points, curve.network(free).control_points
        inner = ~mesh.boundary_edges
        assert np.array_equal(given[inner], plain[inner])
        assert np.abs(given - plain)[~inner].max(axis=(1, 2)).min() > 1e-4
    space = registry.boundary_curve("hermite-space").network(mesh).control_points
    assert np.array_equal(registry.boundary_curve("hermite").network(mesh).control_points[~inner], space[~inner])


def test_the_cubic_interpolant_converges_with_followed_boundaries() -> None:
    errors = []
    for levels in (2, 3, 4):
        surface = registry.scheme("cubic-interpolant").fit(wave(levels))
        at = np.array([[0.2, 0.3], [0.5, 0.5], [0.0, 0.4], [0.6, 0.0], [1 / 3, 1 / 3]])
        x, y, z = np.moveaxis(surface.batches[0].jets(at, 0).f, -1, 0)
        errors.append(np.abs(z - (0.5 * np.sin(x) * np.cosh(y) + y * y)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 3.7
