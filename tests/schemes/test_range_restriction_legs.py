"""What decides about an edge: heights of its second rows, kappa, how far legs are shortened and turned."""

import numpy as np
import pytest
from restricted_networks import UP, dry, noise, surrounded

from testbed.conformance.meshes import perturbed_icosahedron
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, dot, norm
from testbed_schemes.mathematics.linear_g1 import first_rows, linear_g1
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate
from testbed_schemes.mathematics.range_restriction_heights import EdgeHeights
from testbed_schemes.mathematics.range_restriction_legs import (
    KAPPAS,
    REACH,
    choose_kappa,
    edge_heights,
    first_shortening,
    shared_edges,
    sufficient_shortening,
)
from testbed_schemes.mathematics.range_restriction_network import LegNetwork
from testbed_schemes.mathematics.range_restriction_turning import turn_between, turned


def state(**changes: tuple[float, float]) -> EdgeHeights:
    """One edge between vertices at height 1, with horizontal tangents of equal lengths a sixth of a turn apart."""
    values = {
        "vertex": (1.0, 1.0),
        "leg": (0.0, 0.0),
        "across": (0.0, 0.0),
        "alpha": (0.5, 0.5),
        "gamma": (-0.5, -0.5),
        "bounds": (0.01, 0.01),
    }
    return EdgeHeights(**{name: np.array([value]) for name, value in {**values, **changes}.items()})


def one(kappa: float) -> Float:
    return np.array([kappa])


ONES = np.ones((1, 2))


@pytest.mark.parametrize("mesh", [perturbed_icosahedron(), noise(0).mesh], ids=["closed", "open"])
def test_the_network_knows_the_next_half_edges(mesh: HermiteMesh) -> None:
    network, edges = LegNetwork.of_mesh(mesh), mesh.edges.tolist()
    half = {}
    for e, (i, j) in enumerate(edges):
        half[i, j], half[j, i] = 2 * e, 2 * e + 1
    sides = {}
    for f, (a, b, c) in enumerate(mesh.faces.tolist()):
        sides.update({(a, b): (f, c), (b, c): (f, a), (c, a): (f, b)})
    for e, (i, j) in enumerate(edges):
        for run, beside, place in (((i, j), network.left, 0), ((j, i), network.right, 1)):
            face, third = sides.get(run, (-1, -1))
            assert network.faces[e, place] == face
            expected = [half[i, third], half[j, third]] if face >= 0 else [-1, -1]
            assert beside[e].tolist() == expected
    ahead, back = network.around
    assert (back[ahead[ahead >= 0]] == np.flatnonzero(ahead >= 0)).all()
    assert (network.ends.ravel()[ahead[ahead >= 0]] == network.ends.ravel()[ahead >= 0]).all()


def test_heights_are_those_of_the_vectors() -> None:
    problem = noise(1)
    network, mesh = problem.network, problem.mesh
    assert mesh.normals is not None
    inside = np.flatnonzero(network.interior)
    kappa = np.exp(np.random.default_rng(0).uniform(-1.0, 1.0, len(inside)))
    edges = shared_edges(network[inside], mesh.points, mesh.normals, problem.legs, inside, kappa)
    bounds = problem.bounds[network.faces[inside]]
    heights = edge_heights(edges, UP, problem.heights[network.ends[inside]], bounds)
    g1 = linear_g1(edges)
    for found, vector in zip(heights.means(kappa), (g1.R1, g1.R3, g1.R4), strict=True):
        assert found == pytest.approx(vector[:, 2], abs=1e-13)
    assert heights.middle(kappa) == pytest.approx(edges.c[:, 2, 2], abs=1e-14)
    # at the ends of the interval a point of the second rows is on its bound, and none is below inside
    least, greatest = heights.interval(kappa)
    open_ = np.isfinite(least) & np.isfinite(greatest) & (least < greatest)
    assert open_.sum() > 20
    for share in (0.0, 0.4, 1.0):
        height = np.zeros(len(kappa))
        height[open_] = (1.0 - share) * least[open_] + share * greatest[open_]
        p1, p2, q1, q2 = (row[:, 2] for row in first_rows(edges, g1, height[:, None] * UP))
        low = np.min([p1 + bounds[:, 0], p2 + bounds[:, 0], q1 + bounds[:, 1], q2 + bounds[:, 1]], axis=0)[open_]
        assert low.min() > -1e-13
        if share != 0.4:
            assert np.abs(low).max() < 1e-13


def test_high_boundary_points_alone_do_not_suffice_and_kappa_helps() -> None:
    # the lower vertex's neighbours span more than a half turn: gamma0 > 0
    corner = lower_ordinate(*(np.array([height]) for height in (0.05, 1.85, 1.85)))[0]
    edge = state(vertex=(0.05, 1.85), gamma=(0.45, -0.5), bounds=(corner, corner))
    assert edge.middle(one(1.0))[0] > 0.05
    R1 = edge.means(one(1.0))[0][0]
    assert R1 < -0.3
    assert not edge.admissible(one(1.0))[0]
    assert edge.middle(one(16.0))[0] > 0.05
    assert edge.admissible(one(16.0))[0]
    # kappa is not that large where tangents are long
    kappa, possible = choose_kappa(edge, ONES)
    assert not possible[0]
    kappa, possible = choose_kappa(edge, 0.25 * ONES)
    assert possible[0]
    assert 8.0 < kappa[0] <= 4.0 * REACH


def test_the_reversed_edge_gets_the_reciprocal_kappa() -> None:
    edge = state(vertex=(0.05, 1.85), leg=(0.01, 0.02), across=(0.03, -0.01), alpha=(0.4, 0.6), gamma=(0.45, -0.5))
    turned_edge = EdgeHeights(
        edge.vertex[:, ::-1],
        edge.leg[:, ::-1],
        -edge.across[:, ::-1],
        1.0 - edge.alpha[:, ::-1],
        -1.0 - edge.gamma[:, ::-1],
        edge.bounds[:, ::-1],
    )
    for kappa in (1.0, 3.0, 20.0):
        assert turned_edge.width(one(1.0 / kappa)) == pytest.approx(edge.width(one(kappa)), rel=1e-12)
        assert turned_edge.middle(one(1.0 / kappa)) == pytest.approx(edge.middle(one(kappa)), rel=1e-13)
    factors = np.array([[0.1, 0.3]])
    found, possible = choose_kappa(edge, factors)
    reverse, also = choose_kappa(turned_edge, factors[:, ::-1])
    assert possible[0]
    assert also[0]
    assert found[0] > 1.0
    assert reverse == pytest.approx(1.0 / found, rel=1e-15)


def test_kappa_does_not_prefer_an_end_of_a_symmetric_edge() -> None:
    # a boundary that sags: with kappa far from 1 its middle point is higher
    edge = state(vertex=(0.05, 0.05), leg=(-0.05, -0.05), bounds=(0.01, 0.01))
    assert not edge.admissible(one(1.0))[0]
    helps = edge[np.zeros(1, dtype=np.int64)].for_many().admissible(np.concatenate([KAPPAS, 1.0 / KAPPAS]))[0]
    assert (helps[: len(KAPPAS)] == helps[len(KAPPAS) :]).all()
    kappa, possible = choose_kappa(edge, ONES)
    assert not possible[0]
    assert kappa[0] == 1.0
    found, factors = sufficient_shortening(edge, ONES)
    assert found[0]
    assert factors[0, 0] == factors[0, 1] < 1.0
    assert edge.scaled(factors).admissible(one(1.0))[0]


def test_legs_are_shortened_to_just_above_the_bound_and_only_where_they_end_below() -> None:
    vertex, leg = np.array([[1.0, 0.2], [0.0, 1.0]]), np.array([[-1.05, -0.9], [0.0, 3.0]])
    factors = first_shortening(vertex, leg, np.array([0.1, 0.0]))
    assert factors[0, 0] == 1.0
    assert factors[1].tolist() == [1.0, 1.0]
    assert vertex[0, 1] + factors[0, 1] * leg[0, 1] == pytest.approx(-0.1, rel=1e-5)
    assert vertex[0, 1] + factors[0, 1] * leg[0, 1] > -0.1


def test_only_the_end_that_needs_it_is_shortened() -> None:
    # the higher end's tangent falls below the plane, which no kappa mends
    edge = state(vertex=(0.05, 1.0), leg=(0.0, -1.2))
    assert not choose_kappa(edge, 1e-9 * ONES)[1][0]
    found, factors = sufficient_shortening(edge, ONES)
    assert found[0]
    assert factors[0, 0] == 1.0
    assert factors[0, 1] < 1.0
    assert choose_kappa(edge.scaled(factors), factors)[1][0]
    assert not choose_kappa(edge.scaled(factors / 0.8), factors / 0.8)[1][0]


def spans(legs: Float, normals: Float, network: LegNetwork) -> tuple[Float, Float]:
    """Angles ahead of each half edge (2 E,) and from the one before it to the one ahead; NaN where there is none."""
    ahead, back = network.around
    flat, vertex = legs.reshape(-1, 3), network.ends.ravel()
    angle = np.where(ahead >= 0, turn_between(flat, flat[ahead], normals[vertex]), np.nan)
    return angle, angle + np.where(back >= 0, angle[back], np.nan)


@pytest.mark.parametrize("seed", [1, 2, 4, 5, 10])
def test_turned_legs_keep_their_lengths_planes_and_order(seed: int) -> None:
    problem = dry(seed)
    network, mesh, vertex = problem.network, problem.mesh, problem.network.ends.ravel()
    assert mesh.normals is not None
    before, span = spans(problem.legs, mesh.normals, network)
    # with five neighbours there is room for it
    wide = np.flatnonzero((span > np.pi) & (mesh.valence[vertex] >= 5))
    assert len(wide) > 0
    legs = turned(network, mesh.normals, problem.legs, wide)
    after, narrow = spans(legs, mesh.normals, network)
    assert narrow[wide].max() < np.pi
    assert norm(legs) == pytest.approx(norm(problem.legs), rel=1e-14)
    assert np.abs(dot(legs, mesh.normals[network.ends])).max() < 1e-15
    here = np.isin(vertex, vertex[wide])
    np.testing.assert_array_equal(legs.reshape(-1, 3)[~here], problem.legs.reshape(-1, 3)[~here])
    assert after[here].min() > 0.0
    assert after[here].max() < np.pi
    assert after[here].sum() == pytest.approx(before[here].sum(), rel=1e-12)


def test_legs_at_four_neighbours_cannot_all_be_turned() -> None:
    problem = surrounded(np.ones(4), 0.0)
    network, mesh = problem.network, problem.mesh
    assert mesh.normals is not None
    centre = np.flatnonzero(network.ends.ravel() == 4)
    np.testing.assert_array_equal(turned(network, mesh.normals, problem.legs, centre), problem.legs)
    legs = turned(network, mesh.normals, problem.legs, centre[:1])
    assert spans(legs, mesh.normals, network)[1][centre[0]] < np.pi
