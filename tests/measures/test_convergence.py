import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.vectors import Float
from testbed.measures.convergence import OrderEstimate, estimate_order, verdict

H: Float = 0.5 ** np.arange(14, dtype=np.float64)


@given(order=st.floats(0.5, 6.0), constant=st.floats(1e-3, 1e3), ratio=st.floats(0.4, 0.8), scale=st.floats(1e-2, 1e2))
@settings(max_examples=50, deadline=None)
def test_a_power_law_gives_its_order_whatever_the_constant_and_the_scale(
    order: float, constant: float, ratio: float, scale: float
) -> None:
    h: Float = ratio ** np.arange(5, dtype=np.float64)
    found = estimate_order(scale * h, scale * constant * h**order, scale)
    assert found.status == "estimated"
    assert found.order == pytest.approx(order, abs=1e-9)
    assert found.low <= found.order <= found.high
    assert found.levels_used == (0, 1, 2, 3, 4)
    assert not found.left_out


def test_levels_at_the_rounding_floor_are_left_out_and_named() -> None:
    error = H**4 + 3e-16
    assert np.polyfit(np.log(H), np.log(error), 1)[0] < 3.97  # what a fit over all levels says
    found = estimate_order(H, error, 1.0)
    assert found.order == pytest.approx(4.0, abs=1e-3)
    assert set(found.left_out) == {11, 12, 13}
    assert set(found.left_out.values()) == {"rounding floor"}
    assert found.levels_used == tuple(range(11))
    assert verdict(4.0, found) == "met"


def test_a_collapse_near_the_floor_is_rounding_and_all_finer_levels_with_it() -> None:
    error = np.array([1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 3e-11, 5e-11])
    found = estimate_order(10.0 ** (-np.arange(9) / 4.0), error, 1.0)
    assert found.order == pytest.approx(4.0, abs=1e-9)
    assert set(found.left_out) == {7, 8}


def test_a_collapse_far_from_the_floor_is_a_lower_order() -> None:
    error = np.concatenate([H[:4] ** 4, H[3] ** 4 * (H[4:9] / H[3]) ** 2])
    found = estimate_order(H[:9], error, 1.0)
    assert found.order == pytest.approx(2.0, abs=1e-9)
    assert verdict(4.0, found) == "missed"
    assert set(found.left_out) == {0, 1, 2}


def test_levels_before_the_asymptotic_range_are_left_out() -> None:
    error = H[:8] ** 4 * (1.0 + 40.0 * H[:8] ** 2)
    found = estimate_order(H[:8], error, 1.0)
    assert set(found.left_out.values()) == {"local order not settled yet"}
    assert 0 in found.left_out
    assert found.order == pytest.approx(4.0, abs=0.1)
    assert verdict(4.0, found) == "met"


def test_the_interval_holds_the_limit_that_local_orders_drift_to() -> None:
    found = estimate_order(H[:5], H[:5] ** 4 * (1.0 + H[:5]), 1.0)
    assert found.order > 4.05
    assert found.low == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize("seed", range(20))
def test_noise_widens_the_interval_and_leaves_the_verdict(seed: int) -> None:
    noise = np.exp(0.03 * np.random.default_rng(seed).normal(size=8))
    found = estimate_order(H[:8], 1e-3 * H[:8] ** 4 * noise, 1.0)
    assert found.high - found.low > 0.01
    assert verdict(4.0, found) == "met"
    assert verdict(3.0, found) == "exceeded"
    assert verdict(5.0, found) == "missed"


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_fewer_than_three_levels_are_no_test(levels: int) -> None:
    found = estimate_order(H[:levels], H[:levels] ** 4, 1.0)
    assert found.status == "not testable"
    assert math.isnan(found.order)
    assert str(levels) in found.reason
    assert verdict(4.0, found) == "not testable"


def test_two_levels_above_the_floor_are_no_test() -> None:
    found = estimate_order(H[:4], np.array([1e-3, 1e-9, 1e-16, 2e-16]), 1.0)
    assert found.status == "not testable"
    assert found.reason.startswith("2 usable levels of 4")
    assert set(found.left_out) == {2, 3}


def test_a_constant_error_has_order_zero() -> None:
    found = estimate_order(H[:5], np.full(5, 0.3), 1.0)
    assert found.order == pytest.approx(0.0, abs=1e-12)
    assert verdict(2.0, found) == "missed"


@pytest.mark.parametrize("error", [np.zeros(4), np.array([1e-16, 3e-16, 0.0, 2e-15])])
def test_errors_that_are_all_rounding_are_exact(error: Float) -> None:
    found = estimate_order(H[:4], error, 1.0)
    assert found.status == "exact"
    assert found.order == math.inf
    assert verdict(4.0, found) == "exceeded"


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_an_error_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    for level in range(5):
        error = H[:5] ** 4
        error[level] = bad
        found = estimate_order(H[:5], error, 1.0)
        assert found.status == "not testable"
        assert f"level {level}" in found.reason
        assert verdict(0.0, found) == "not testable"


def test_local_orders_that_do_not_settle_meet_no_claim() -> None:
    found = estimate_order(H[:3], np.array([1.0, 0.5**5, 0.5**7]), 1.0)
    assert found.low < 2.0 < 5.0 <= found.high
    assert verdict(4.0, found) == "not testable"


def test_no_claim_no_verdict() -> None:
    assert verdict(None, OrderEstimate("estimated", 4.0, 3.9, 4.1)) == "not claimed"


@pytest.mark.parametrize(
    ("h", "error", "scale", "says"),
    [
        ([1.0, 0.5], [1.0], 1.0, "shape"),
        ([0.5, 1.0, 2.0], [1.0, 1.0, 1.0], 1.0, "decrease"),
        ([1.0, 0.5, 0.0], [1.0, 1.0, 1.0], 1.0, "decrease"),
        ([1.0, 0.5, 0.25], [1.0, -1.0, 1.0], 1.0, "negative"),
        ([1.0, 0.5, 0.25], [1.0, 1.0, 1.0], 0.0, "scale"),
        ([1.0, 0.5, 0.25], [1.0, 1.0, 1.0], math.nan, "scale"),
    ],
)
def test_input_that_makes_no_sense_is_an_error(h: list[float], error: list[float], scale: float, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        estimate_order(h, error, scale)
