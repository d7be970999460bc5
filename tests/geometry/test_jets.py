"""Jets: what is read off the derivatives."""

import numpy as np
import pytest

from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.vectors import Float, cross, dot


def some_coefficients(seed: int = 0) -> Float:
    return np.random.default_rng(seed).standard_normal((6, 4, 5, 3))


@pytest.mark.parametrize("order", [0, 1, 2])
def test_rows_and_order(order: int) -> None:
    coefficients = some_coefficients()[: ROWS[order]]
    jet = Jet(coefficients)
    assert jet.order == order
    for row, name in enumerate(("f", "fu", "fv", "fuu", "fuv", "fvv")):
        if row < ROWS[order]:
            np.testing.assert_array_equal(getattr(jet, name), coefficients[row])
        else:
            with pytest.raises(ValueError, match=f"stops at order {order}"):
                getattr(jet, name)


def test_normal_is_the_unit_vector_along_f_u_x_f_v() -> None:
    jet = Jet(some_coefficients())
    np.testing.assert_allclose(dot(jet.normal, jet.normal), 1.0, rtol=1e-14)
    np.testing.assert_allclose(dot(jet.normal, jet.fu), 0.0, atol=1e-14)
    np.testing.assert_allclose(dot(jet.normal, jet.fv), 0.0, atol=1e-14)
    assert (dot(jet.normal, np.cross(jet.fu, jet.fv)) > 0.0).all()


def test_normal_of_a_singular_point_is_nan_and_quiet() -> None:
    coefficients = some_coefficients()
    coefficients[2, 1, 2] = 0.0
    assert np.isnan(Jet(coefficients).normal[1, 2]).all()
    assert np.isnan(Jet(coefficients).normal).sum() == 3


def test_first_form_is_the_metric() -> None:
    jet = Jet(some_coefficients())
    E, F, G = jet.first_form
    a, b = 0.7, -1.3
    along = a * jet.fu + b * jet.fv
    np.testing.assert_allclose(a * a * E + 2 * a * b * F + b * b * G, (along**2).sum(axis=-1), rtol=1e-13)


def test_second_form_is_positive_on_the_unit_sphere_with_outward_normals() -> None:
    # at the north pole of (x, y, sqrt(1 - x^2 - y^2))
    jet = Jet(np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, -1], [0, 0, 0], [0, 0, -1]]))
    assert [float(value) for value in jet.second_form] == [1.0, 0.0, 1.0]


def test_nothing_depends_on_the_memory_layout() -> None:
    coefficients = some_coefficients()
    planar = np.ascontiguousarray(coefficients.transpose(0, 2, 3, 1)).transpose(0, 3, 1, 2)
    one, other = Jet(coefficients), Jet(planar)
    np.testing.assert_array_equal(one.normal, other.normal)
    np.testing.assert_array_equal(one.first_form, other.first_form)
    np.testing.assert_array_equal(one.second_form, other.second_form)
    np.testing.assert_array_equal(cross(one.fu, one.fv), np.cross(other.fu, other.fv))
