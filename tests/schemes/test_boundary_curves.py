"""Boundary curves: what each matches, and that it depends on its own edge only, in any position, size and direction."""

import numpy as np
import pytest
from edge_samples import (
    chosen,
    flat_edges,
    legs,
    lengths,
    moved,
    normal_curvatures,
    reversed_edges,
    sampled_edges,
)

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.vectors import cross, dot, norm, quadratic_form, unit
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed.registry import catalogue
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.conic import ConicCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.hermite_space import HermiteSpace
from testbed_schemes.boundary_curves.optimized import Optimized
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.boundary_curves.piper import PiperCurve
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve

CURVES = [
    Projected(),
    Planar(),
    Circular(),
    Hermite(),
    Hermite(root="worst"),
    Optimized(),
    HermiteSpace(),
    HermiteSpace(root="worst"),
    PetersCurve(),
    PiperCurve(),
    WaltonMeekCurve(),
    ConicCurve(),
]
every_curve = pytest.mark.parametrize("boundary", CURVES, ids=str)
PLANAR = [Planar(), Hermite(), Hermite(root="worst"), Optimized(), ConicCurve()]
#: Constructions by formulas alone, without a search for roots or minima.
CLOSED = [Projected(), Planar(), Circular(), PiperCurve(), WaltonMeekCurve(), ConicCurve()]


@every_curve
def test_a_curve_ends_in_the_data_with_tangents_in_the_tangent_planes(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    curves, _ = boundary.curves(edges)
    assert np.array_equal(curves[:, 0], edges.p0)
    assert np.array_equal(curves[:, 3], edges.p1)
    chord = edges.p1 - edges.p0
    for leg, normal in ((curves[:, 1] - curves[:, 0], edges.n0), (curves[:, 3] - curves[:, 2], edges.n1)):
        assert normal is not None
        assert np.abs(dot(leg, normal)).max() < 1e-14
        assert (dot(leg, chord) > 0.0).all()


@pytest.mark.parametrize("boundary", PLANAR, ids=str)
def test_a_planar_construction_stays_in_the_plane_of_chord_and_mean_normal(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    assert edges.n0 is not None
    assert edges.n1 is not None
    curves, _ = boundary.curves(edges)
    plane = unit(cross(edges.n0 + edges.n1, edges.p1 - edges.p0))
    assert np.abs(dot(curves - curves[:, :1], plane[:, None])).max() < 1e-14


@every_curve
@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e7])
def test_a_curve_moves_with_its_data(boundary: BoundaryCurve, scale: float) -> None:
    edges = sampled_edges()
    rotation = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    curves, notes = boundary.curves(edges)
    images, image_notes = boundary.curves(moved(edges, rotation, scale, np.zeros(3)))
    assert image_notes == notes
    off = images / scale - curves @ rotation.T
    assert norm(off[:, [0, 3]]).max() < 1e-14
    # where two solutions nearly merge, rounding, amplified, moves inner points along their legs, and not off them
    legs = unit(np.stack([curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2]], axis=1) @ rotation.T)
    along = dot(off[:, 1:3], legs)
    assert norm(off[:, 1:3] - along[..., None] * legs).max() < 1e-13
    assert np.abs(along).max() < 1e-9


@every_curve
def test_the_reversed_edge_has_the_reversed_curve(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    there, back = boundary.curves(edges)[0], boundary.curves(reversed_edges(edges))[0]
    assert norm(there - back[:, ::-1]).max() < 1e-10


@pytest.mark.parametrize("boundary", CLOSED, ids=str)
def test_a_formula_gives_the_reversed_curve_bit_for_bit(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    assert np.array_equal(boundary.curves(edges)[0], boundary.curves(reversed_edges(edges))[0][:, ::-1])


@every_curve
def test_both_faces_of_an_edge_have_the_same_curve_bit_for_bit(boundary: BoundaryCurve) -> None:
    mesh = registry.dataset("icosahedron").mesh(0)
    curves = boundary.network(mesh).opposite_vertices().reshape(-1, 4, 3)
    ends = np.roll(mesh.faces, -1, axis=1)[..., None][:, :, [0, 0]]
    ends[..., 1] = np.roll(mesh.faces, -2, axis=1)
    ends = ends.reshape(-1, 2)
    partner = [np.flatnonzero((ends == end[::-1]).all(axis=1))[0] for end in ends]
    assert np.array_equal(curves, curves[partner][:, ::-1])


@every_curve
def test_a_curve_sees_its_own_edge_only(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    curves, _ = boundary.curves(edges)
    for which in (slice(17, 18), slice(5, 90), slice(None, None, -1)):
        assert np.array_equal(boundary.curves(chosen(edges, which))[0], curves[which])


@every_curve
def test_flat_data_give_straight_edges_and_nothing_to_note(boundary: BoundaryCurve) -> None:
    edges = flat_edges()
    curves, notes = boundary.curves(edges)
    t = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] / 3.0
    assert norm(curves - (edges.p0[:, None] * (1.0 - t) + edges.p1[:, None] * t)).max() < 1e-13
    assert notes == {}


@every_curve
def test_a_chord_along_a_normal_is_refused_by_the_vertices(boundary: BoundaryCurve) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    W = np.zeros((3, 3, 3))
    with pytest.raises(Refused, match="from vertex 0 to vertex 2"):
        boundary.network(HermiteMesh(points, [[0, 1, 2]], normals, W))


@every_curve
@pytest.mark.parametrize("off", [0.0, 1e-14, 1e-10])
def test_a_chord_nearly_along_a_normal_has_no_curve_and_its_neighbour_has_one(
    boundary: BoundaryCurve, off: float
) -> None:
    edges = sampled_edges(2)
    n0 = np.array(edges.n0)
    n0[0] = unit(edges.p1[0] - edges.p0[0] + np.array([off, 0.0, 0.0]))
    W0 = np.zeros((2, 3, 3))
    curves, _ = boundary.curves(EdgeData(edges.p0, edges.p1, n0, edges.n1, W0, edges.W1))
    assert np.isnan(curves[0]).any()
    assert np.isfinite(curves[1]).all()


@pytest.mark.parametrize("boundary", CURVES, ids=str)
def test_the_registry_reads_back_what_a_curve_calls_itself(boundary: BoundaryCurve) -> None:
    assert registry.boundary_curve(str(boundary)) == boundary


@every_curve
def test_a_curve_says_how_it_is_built_how_that_is_published_and_where_it_fails(boundary: BoundaryCurve) -> None:
    assert all((boundary.formula, boundary.status, boundary.failures))


def test_every_registered_curve_is_tested_here() -> None:
    assert {type(curve) for curve in CURVES} >= set(catalogue(BoundaryCurve).values())  # type: ignore[type-abstract]


@pytest.mark.parametrize("boundary", [curve for curve in CURVES if Data.SECOND_FORMS not in curve.matches], ids=str)
def test_what_does_not_claim_the_curvature_of_the_data_does_not_have_it(boundary: BoundaryCurve) -> None:
    edges = sampled_edges(200)
    assert edges.W0 is not None
    curves, _ = boundary.curves(edges)
    t0 = unit(curves[:, 1] - curves[:, 0])
    assert np.abs(normal_curvatures(curves, edges)[0] - quadratic_form(t0, edges.W0, t0)).max() > 1e-3


@pytest.mark.parametrize("boundary", [curve for curve in CURVES if Data.SECOND_FORMS in curve.matches], ids=str)
def test_what_claims_the_normal_curvature_of_the_data_has_it(boundary: BoundaryCurve) -> None:
    edges = sampled_edges(2000)
    assert edges.W0 is not None
    assert edges.W1 is not None
    curves, notes = boundary.curves(edges)
    assert notes == {}
    at_start, at_end = normal_curvatures(curves, edges)
    t0, t1 = unit(curves[:, 1] - curves[:, 0]), unit(curves[:, 3] - curves[:, 2])
    # relative to the legs: a leg d and an error e in a point change the curvature by e / d^2
    small0, small1 = (np.minimum(leg / lengths(edges), 1.0 / 3.0) ** 2 for leg in legs(curves))
    assert (np.abs(at_start - quadratic_form(t0, edges.W0, t0)) * small0).max() < 1e-12
    assert (np.abs(at_end - quadratic_form(t1, edges.W1, t1)) * small1).max() < 1e-12
