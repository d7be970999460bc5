"""The search finds the best settings where graphs have kinks, several valleys, refusals, and several datasets."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import cast

import pytest

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.objectives import measures_for, objective
from testbed.harness.parameters import Interval
from testbed.harness.plan import make_plan
from testbed.harness.trials import Trial, Trials
from testbed.harness.tune import DIGITS, ROUNDING, Tuned, trace, tune
from testbed.plugins.scheme import Scheme
from testbed.registry import scheme

Formula = Callable[[float, float], Sequence[float]]
C = Interval("jensen_c", 0.5, 2.0)
ALPHA = Interval("alpha2", 1.0, 4.0)


class Formulas:
    """Trials that take the values of shirman-sequin from a formula of its two parameters; NaN is a refusal."""

    def __init__(self, formula: Formula) -> None:
        self.formula = formula
        self.done: dict[str, Trial] = {}
        self.objective = objective("gauss_spread")
        self.datasets = ("octahedron", "icosahedron")

    def all(self, settings: Sequence[str]) -> list[Trial]:
        for setting in settings:
            one: Scheme = scheme(setting)
            assert str(one) == setting
            values = tuple(self.formula(one.jensen_c, one.alpha2))  # type: ignore[attr-defined]  # shirman-sequin has them
            outcomes = [
                Outcome("refused", "the formula says so") if math.isnan(value) else Outcome("ok", values={})
                for value in values
            ]
            self.done.setdefault(setting, Trial(setting, tuple(outcomes), values))
        return [self.done[setting] for setting in settings]


def tuned(formula: Formula, *intervals: Interval, maximise: bool = False) -> Tuned:
    return tune("shirman-sequin", intervals, cast("Trials", Formulas(formula)), maximise=maximise)


def test_a_kink_is_found_to_the_digits_kept() -> None:
    found = tuned(lambda c, _: [max(3.0 * (1.2345 - c), 0.5 * (c - 1.2345)) + 0.125], C)
    assert dict(found.parameters)["jensen_c"] == pytest.approx(1.2345, abs=2e-4)
    assert found.best.values[0] == pytest.approx(0.125, abs=2e-4)
    assert found.on_bound == ()
    assert found.gain == pytest.approx(1.0 - found.best.values[0] / found.given.values[0])


def test_of_two_valleys_the_deeper_one_is_found_though_it_is_narrow() -> None:
    found = tuned(lambda c, _: [min(2.0 * abs(c - 0.8) + 0.5, 10.0 * abs(c - 1.7) + 0.25)], C)
    assert dict(found.parameters)["jensen_c"] == pytest.approx(1.7, abs=1e-3)


def test_two_parameters_in_a_crossing_of_kinks() -> None:
    # the largest of three planes has its one lowest point at (1.1, 1.75), and no side of it is an axis
    def planes(c: float, alpha: float) -> list[float]:
        x, y = c - 1.1, alpha - 1.75
        return [max(2.0 * x + y, -x + 0.5 * y, -2.0 * y + 0.3 * x) + 1.0]

    found = tuned(planes, C, ALPHA)
    assert [value for _, value in found.parameters] == pytest.approx([1.1, 1.75], abs=3e-3)
    assert found.best.values[0] == pytest.approx(1.0, abs=3e-3)


def test_a_refusal_is_never_the_best() -> None:
    found = tuned(lambda c, _: [c if c >= 1.3 else math.nan], C)
    assert dict(found.parameters)["jensen_c"] == pytest.approx(1.3, abs=1e-3)
    assert found.best.valid
    assert found.gain is None  # refused as given
    assert 0 < found.without_value < found.settings
    with pytest.raises(TestbedError, match=r"no setting .* the formula says so"):
        tuned(lambda *_: [math.nan], C)


def test_an_optimum_on_a_bound_is_the_bound_and_said_to_be() -> None:
    found = tuned(lambda c, alpha: [c + (alpha - 2.0) ** 2], C, ALPHA)
    assert dict(found.parameters)["jensen_c"] == 0.5
    assert found.on_bound == ("jensen_c",)


def test_large_values_can_be_sought() -> None:
    found = tuned(lambda c, _: [5.0 - abs(c - 1.5)], C, maximise=True)
    assert found.best.values[0] == pytest.approx(5.0, abs=1e-3)
    assert found.gain == pytest.approx(5.0 / 4.5 - 1.0, abs=1e-3)


def test_several_datasets_count_by_the_one_that_gains_least() -> None:
    # as given 0.6 and 35; (1.6 - c) / 0.6 falls and (c - 1.15) / 0.35 rises, and they cross at c = 1.25 / 0.95
    found = tuned(lambda c, _: [0.1 + abs(c - 1.5), 100.0 * (0.1 + abs(c - 1.25))], C)
    assert dict(found.parameters)["jensen_c"] == pytest.approx(1.25 / 0.95, abs=2e-4)
    assert found.gain == pytest.approx(1.0 - (1.6 - 1.25 / 0.95) / 0.6, abs=1e-3)


def test_several_datasets_need_a_value_as_given_on_each() -> None:
    with pytest.raises(TestbedError, match=r"weighed .*the formula says so"):
        tuned(lambda c, _: [1.0, c if c > 1.2 else math.nan], C)
    with pytest.raises(TestbedError, match="its value is -1"):
        tuned(lambda *_: [1.0, -1.0], C)
    with pytest.raises(TestbedError, match="jensen_c twice"):
        tuned(lambda *_: [1.0], C, ALPHA, C)


def test_the_search_repeats_itself_and_asks_short_numbers_once() -> None:
    searches = [Formulas(lambda c, alpha: [abs(c - 1.3) + (alpha - c) ** 2]) for _ in range(2)]
    for one in searches:
        tune("shirman-sequin", [C, ALPHA], cast("Trials", one))
    first, second = (list(one.done) for one in searches)
    assert first == second
    for setting in first[1:]:
        found = scheme(setting)
        for name in ("jensen_c", "alpha2"):
            value = getattr(found, name)
            assert float(f"{value:.{DIGITS}g}") == value
    assert len(first) == len(set(first))


def test_gregorys_patch_on_the_octahedron_is_nearly_a_sphere_at_one_c(tmp_path: Path) -> None:
    base, spread = "triangular-gregory[boundary=hermite]", objective("gauss_spread")
    plan = make_plan([base], ["octahedron"], "0", measures_for([spread]))

    def search() -> tuple[Tuned, Trials]:
        with Trials(plan, spread, {"octahedron": {}}, tmp_path, jobs=1) as trials:
            return tune(base, [Interval("jensen_c", 1.1, 1.4)], trials), trials

    found, trials = search()
    assert dict(found.parameters)["jensen_c"] == pytest.approx(1.2343, abs=5e-4)
    measured = found.best.outcomes[0].values
    assert measured is not None
    assert [measured["gauss_min"], measured["gauss_max"]] == pytest.approx([0.978, 1.028], abs=1e-3)
    assert found.gain == pytest.approx(0.963, abs=2e-3)
    table = trace(trials, [Interval("jensen_c", 1.1, 1.4)])
    assert len(table) == found.settings == trials.computed
    assert table["gauss_spread"].min() <= found.best.values[0] <= (1.0 + ROUNDING) * table["gauss_spread"].min()
    # the journal has it all: a search that was interrupted goes on where it was
    again, trials = search()
    assert (trials.computed, trials.reused) == (0, found.settings)
    assert again == found
