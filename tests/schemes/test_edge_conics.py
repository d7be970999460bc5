"""Conics on edges and the cubics that stand for them."""

import numpy as np
import pytest
from edge_samples import (
    arc,
    sampled_edges,
)

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import dot, norm, unit
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.conic import ConicCurve
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.mathematics.edge_conics import edge_conics
from testbed_schemes.mathematics.planar_frame import planar_frame


@pytest.mark.parametrize("degrees", [1.0, 45.0, 90.0, 170.0])
def test_a_conic_over_an_arc_is_the_circle_and_its_cubic_that_of_an_arc(degrees: float) -> None:
    edges = arc(np.radians(degrees), radius=2.0)
    frame = planar_frame(edges)
    conics = edge_conics(frame)
    middle, w, t = conics.middle(edges, frame), conics.weight[0], np.linspace(0.0, 1.0, 9)[:, None]
    assert w == pytest.approx(np.cos(np.radians(degrees / 2.0)), rel=1e-12)
    weights = np.concatenate([(1.0 - t) ** 2, 2.0 * w * t * (1.0 - t), t**2], axis=1)
    points = weights @ np.concatenate([edges.p0, middle, edges.p1]) / weights.sum(axis=1, keepdims=True)
    assert norm(points) == pytest.approx(2.0, rel=1e-13)
    assert norm(ConicCurve().curves(edges)[0] - Circular().curves(edges)[0]).max() < 1e-12


def test_a_conic_curve_passes_through_the_shoulder_of_the_conic() -> None:
    edges = sampled_edges()
    frame = planar_frame(edges)
    conics = edge_conics(frame)
    assert conics.exists.all()
    middle, w = conics.middle(edges, frame), conics.weight[:, None]
    shoulder = (edges.p0 + 2.0 * w * middle + edges.p1) / (2.0 + 2.0 * w)
    curves, notes = ConicCurve().curves(edges)
    assert notes == {}
    assert norm((curves * np.array([1.0, 3.0, 3.0, 1.0])[:, None]).sum(axis=1) / 8.0 - shoulder).max() < 1e-14
    for leg, normal in ((middle - edges.p0, edges.n0), (middle - edges.p1, edges.n1)):
        assert normal is not None
        assert np.abs(dot(leg, normal)).max() < 1e-14


def test_edges_with_an_inflection_or_bent_at_one_end_have_no_conic_and_are_planar() -> None:
    chord = np.array([[1.0, 0.0, 0.0]])
    slopes = [(0.3, 0.3), (0.3, 0.2), (0.3, 0.0), (0.3, -0.01)]
    normals = [unit(np.array([[-s0, 1.0, 0.0], [-s1, 1.0, 0.0]])) for s0, s1 in slopes]
    n0, n1 = (np.stack([pair[end] for pair in normals]) for end in (0, 1))
    edges = EdgeData(np.zeros((4, 3)), np.repeat(chord, 4, axis=0), n0, n1, None, None)
    curves, notes = ConicCurve().curves(edges)
    assert notes == {"curves without a conic": 4}
    assert np.array_equal(curves, Planar().curves(edges)[0])
