import numpy as np
import pytest

from testbed.geometry.bernstein import tensor_tables, triangle_tables
from testbed.geometry.composition import BernsteinBasis, centre_weights, compose, elevation, quartering
from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float

BASES = [BernsteinBasis(degrees) for degrees in ((1,), (3,), (4,), (1, 2), (3, 3))]
FIRST = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
EXPONENTS = np.array([*FIRST, [2, 0, 0], [1, 0, 1], [0, 2, 0], [0, 0, 2], [1, 0, 2]])
every_basis = pytest.mark.parametrize("basis", BASES, ids=str)


def values(basis: BernsteinBasis, net: Float, at: Float) -> Float:
    if len(basis.degrees) == 1:
        table = triangle_tables(basis.degrees[0], at, 0)[0]
    else:
        table = tensor_tables((basis.degrees[0], basis.degrees[1]), at, 0)[0].reshape(len(at), -1)
    result: Float = np.tensordot(table, net, axes=(1, 0))
    return result


def points(basis: BernsteinBasis) -> Float:
    return lattice(3 if len(basis.degrees) == 1 else 4, 7)


@every_basis
@pytest.mark.parametrize("rational", [False, True])
def test_a_composition_is_the_polynomial_of_the_patch(basis: BernsteinBasis, rational: bool) -> None:
    random = np.random.default_rng(3)
    net, coefficients = random.normal(size=(len(basis), 3, 5)), random.normal(size=(len(EXPONENTS), 5))
    weights = random.uniform(0.5, 2.0, (len(basis), 5)) if rational else None
    at = points(basis)
    composed = values(basis.power(3), compose(net, weights, basis, EXPONENTS, coefficients, 3), at)
    w = values(basis, weights, at) if weights is not None else np.ones((len(at), 5))
    x = values(basis, net, at) / w[:, None]
    terms = np.prod(x[:, None] ** EXPONENTS[:, :, None], axis=2)
    expected = w**3 * (coefficients * terms).sum(axis=1)
    assert np.abs(composed - expected).max() < 1e-12 * np.abs(expected).max()


@every_basis
def test_elevation_keeps_the_polynomial(basis: BernsteinBasis) -> None:
    net = np.random.default_rng(1).normal(size=(len(basis), 2))
    at = points(basis)
    raised = elevation(basis, 3) @ net
    assert np.abs(values(basis.power(3), raised, at) - values(basis, net, at)).max() < 1e-14


@every_basis
def test_quarters_cover_the_patch(basis: BernsteinBasis) -> None:
    net = np.random.default_rng(2).normal(size=(len(basis), 3))
    at = points(basis)
    found = np.concatenate([values(basis, quarter @ net, at) for quarter in quartering(basis)])
    double = lattice(3 if len(basis.degrees) == 1 else 4, 14)
    # the quarters' lattices are a lattice of twice the steps, points on common sides twice and more
    whole = values(basis, net, double)
    apart = np.abs(found[:, None] - whole[None]).max(axis=-1)
    assert apart.min(axis=1).max() < 1e-13
    assert apart.min(axis=0).max() < 1e-13


@every_basis
def test_the_centre_is_the_middle_of_the_domain(basis: BernsteinBasis) -> None:
    net = np.random.default_rng(4).normal(size=(len(basis), 3))
    middle = np.full((1, 2), 1.0 / 3.0 if len(basis.degrees) == 1 else 0.5)
    assert np.abs(centre_weights(basis) @ net - values(basis, net, middle)).max() < 1e-14
