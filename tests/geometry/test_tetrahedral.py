import numpy as np
import pytest
from tetrahedra import FACTORS, INDICES, quadric_net

from testbed.geometry.simplex_bernstein import composed_jets
from testbed.geometry.tetrahedral import (
    EDGE_TERM,
    FACE_TERM,
    Expansion,
    QuotientTerm,
    coordinate_gradients,
    cubic,
    implicit_curvatures,
    in_space,
    quotient,
    rational_cubic,
)
from testbed.geometry.vectors import Float

TERMS = [FACE_TERM, EDGE_TERM]


def coordinates(count: int, seed: int) -> Float:
    return np.random.default_rng(seed).dirichlet(np.full(4, 2.0), count).T


def random_function(term: QuotientTerm, count: int, seed: int) -> tuple[Float, Float]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(20, count)), rng.normal(size=(len(term.numerator), count))


def expand(term: QuotientTerm, alpha: Float, seed: int = 0) -> Expansion:
    net, rational = random_function(term, alpha.shape[1], seed)
    return rational_cubic(net, term, rational, alpha)


def test_cubics_are_bernstein_polynomials() -> None:
    alpha, (net, _) = coordinates(50, 1), random_function(FACE_TERM, 50, 1)
    powers = (alpha ** INDICES[:, :, None]).prod(axis=1)
    np.testing.assert_allclose(cubic(net, alpha).value, (FACTORS[:, None] * net * powers).sum(axis=0), rtol=1e-13)
    jets = composed_jets(3, net[:, None], alpha[None])
    np.testing.assert_allclose(cubic(net, alpha).value, jets[0, 0], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("term", TERMS)
def test_quotients_are_those_of_the_paper(term: QuotientTerm) -> None:
    a, b, c, d = alpha = coordinates(50, 2)
    _, k = random_function(term, 50, 2)
    if term is FACE_TERM:
        expected = 6 * a * b * c * (k[0] * b * c + k[1] * a * c + k[2] * a * b) / (b * c + a * c + a * b)
    else:
        expected = 6 * a * b * d * (k[0] * a + k[1] * d) / (a + d) + 6 * a * c * d * (k[2] * a + k[3] * d) / (a + d)
    np.testing.assert_allclose(quotient(term, k, alpha).value, expected, rtol=1e-12)


@pytest.mark.parametrize("term", TERMS)
def test_derivatives_are_those_of_a_function_homogeneous_of_degree_three(term: QuotientTerm) -> None:
    alpha = coordinates(50, 3)
    found = expand(term, alpha)
    np.testing.assert_allclose((found.gradient * alpha).sum(axis=0), 3.0 * found.value, rtol=1e-12, atol=1e-13)
    along = np.einsum("ijn,jn->in", found.hessian, alpha)
    np.testing.assert_allclose(along, 2.0 * found.gradient, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.hessian, found.hessian.swapaxes(0, 1), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("term", TERMS)
def test_derivatives_agree_with_difference_quotients(term: QuotientTerm) -> None:
    alpha, step = coordinates(20, 4), 1e-5
    found = expand(term, alpha)
    for i, direction in enumerate(step * np.eye(4)[:, :, None]):
        ahead, behind = expand(term, alpha + direction), expand(term, alpha - direction)
        slope = (ahead.value - behind.value) / (2.0 * step)
        np.testing.assert_allclose(slope, found.gradient[i], rtol=1e-7, atol=1e-8)
        bend = (ahead.gradient - behind.gradient) / (2.0 * step)
        np.testing.assert_allclose(bend, found.hessian[i], rtol=1e-7, atol=1e-7)


#: Points on the lines where the terms are 0/0, columns.
SINGULAR = {
    FACE_TERM: np.array([[0.4, 0.0, 0.0, 0.6], [0.0, 0.7, 0.0, 0.3], [1e-17, -2e-17, 1.0, 0.0]]).T,
    EDGE_TERM: np.array([[0.0, 0.3, 0.7, 0.0], [0.0, 1.0, 0.0, 0.0]]).T,
}


@pytest.mark.parametrize("term", TERMS)
def test_terms_and_their_gradients_vanish_where_they_are_singular(term: QuotientTerm) -> None:
    alpha = SINGULAR[term]
    k = np.ones((len(term.numerator), alpha.shape[1]))
    found = quotient(term, k, alpha)
    assert (found.value == 0.0).all()
    assert (found.gradient == 0.0).all()
    assert np.isnan(found.hessian).all()
    # without a term there are second derivatives
    assert (quotient(term, 0.0 * k, alpha).hessian == 0.0).all()


@pytest.mark.parametrize(("term", "hidden"), [(FACE_TERM, [1, 2]), (EDGE_TERM, [0, 3])])
def test_terms_tend_to_zero_with_their_gradients(term: QuotientTerm, hidden: list[int]) -> None:
    rng = np.random.default_rng(5)
    for distance in (1e-3, 1e-6, 1e-9):
        alpha = np.full((4, 30), 0.5)
        alpha[hidden] = distance * rng.uniform(0.1, 1.0, (2, 30))
        # equal coefficients would make it a polynomial
        k = np.arange(1.0, 1.0 + len(term.numerator))[:, None] * np.ones(30)
        found = quotient(term, k, alpha)
        assert 0.0 < np.abs(found.value).max() < 20.0 * distance**2
        assert np.abs(found.gradient).max() < 40.0 * distance
        # second derivatives stay bounded, but keep their dependence on the direction
        assert np.ptp(found.hessian, axis=-1).max() > 0.1
        assert np.abs(found.hessian).max() < 100.0


def test_a_function_in_space_does_not_depend_on_the_tetrahedron() -> None:
    rng = np.random.default_rng(6)
    form = np.array([[2.0, 0.3, -0.1], [0.3, -1.0, 0.2], [-0.1, 0.2, 0.5]])
    corners = np.eye(4)[:, 1:] + 0.3 * rng.normal(size=(40, 4, 3))
    alpha = coordinates(40, 7)
    nets = np.stack([quadric_net(c, form, 0.7) for c in corners], axis=-1)
    points = np.einsum("in,nik->nk", alpha, corners)
    expansion = rational_cubic(nets, FACE_TERM, np.zeros((3, 40)), alpha)
    gradient, hessian = in_space(expansion, corners)
    np.testing.assert_allclose(expansion.value, np.einsum("ni,ij,nj->n", points, form, points) - 0.7, atol=1e-13)
    np.testing.assert_allclose(gradient, 2.0 * points @ form, atol=1e-12)
    np.testing.assert_allclose(hessian, np.broadcast_to(2.0 * form, (40, 3, 3)), atol=1e-11)


def test_coordinate_gradients_are_dual_to_the_legs() -> None:
    corners = np.random.default_rng(8).normal(size=(10, 4, 3))
    gradients = coordinate_gradients(corners)
    legs = corners - corners[:, 3:]
    expected = np.broadcast_to((np.eye(4) - np.eye(4)[:, 3:])[:, None], (4, 10, 4))
    np.testing.assert_allclose(np.einsum("ink,njk->inj", gradients, legs), expected, atol=1e-10)


def test_curvatures_of_known_level_sets() -> None:
    # sphere of radius 2 with F growing outwards; the same turned inside out; a cylinder; z = x y; an ellipsoid's tips
    two = 2.0 * np.eye(3)
    gradients = [[0.0, 0.0, 4.0], [0.0, 0.0, -4.0], [6.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0 / 3.0]]
    saddle = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    hessians = [two, -two, np.diag([2.0, 2.0, 0.0]), saddle, np.diag([2.0, 0.5, 2.0 / 9.0])]
    gauss, mean = implicit_curvatures(np.array(gradients), np.stack(hessians))
    np.testing.assert_allclose(gauss, [0.25, 0.25, 0.0, -1.0, 9.0 / 4.0], atol=1e-15)
    np.testing.assert_allclose(mean, [0.5, -0.5, 1.0 / 6.0, 0.0, 0.5 * (3.0 + 3.0 / 4.0)], atol=1e-15)
