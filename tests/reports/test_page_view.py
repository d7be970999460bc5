"""What the page says of results: who is best, how claims stand, what is compared and what is missing."""

from dataclasses import replace

from hand_made_results import COLUMNS, good, results, without
from hypothesis import given
from hypothesis import strategies as st

from testbed.harness.cell import Outcome
from testbed.plugins.measure import Column
from testbed_reports.formatting import Entry
from testbed_reports.grid import Grid, Row
from testbed_reports.orders import every_order
from testbed_reports.panels import panels
from testbed_reports.summary import sentences
from testbed_reports.tables import Quantity, best, comparison, every_level
from testbed_reports.verdicts import RANKED, judgements, rank
from testbed_reports.view import view

DISTANCE = Quantity("distance_max", "", "", "least")
SPREAD = Quantity("gauss_max", "", "", "spread")


def row(status: str = "ok", **values: float | None) -> Row:
    return {"status": status, "reason": "", "diameter": 1.0, "h": 0.5, **values}


def shown(entries: tuple[Entry, ...], headings: tuple[tuple[str, str], ...], heading: str) -> Entry:
    return entries[[name for name, _ in headings].index(heading)]


@given(st.lists(st.floats(1e-6, 1e6), min_size=3, max_size=8, unique=True))
def test_the_least_value_is_marked_and_never_a_cell_without_one(values: list[float]) -> None:
    rows = [row(distance_max=value) for value in values]
    bad = [row("refused", distance_max=0.0), row(distance_max=None), None]
    marked = best([*bad, *rows], DISTANCE)
    assert all(position >= len(bad) for position in marked)
    assert not marked or values.index(min(values)) + len(bad) in marked
    assert 2 * len(marked) <= len(values)


def test_values_that_read_the_same_are_equally_good_and_rounding_is_equal() -> None:
    assert best([row(distance_max=value) for value in (1.0001, 1.0002, 2.0, 3.0)], DISTANCE) == {0, 1}
    assert best([row(distance_max=value) for value in (1e-16, 3e-15, 2.0, 3.0)], DISTANCE) == {0, 1}
    assert not best([row(distance_max=value) for value in (1.0, 1.0, 2.0)], DISTANCE)


def test_the_spread_of_curvature_is_ranked_where_the_exact_one_is_constant() -> None:
    rows = [row(gauss_min=0.0, gauss_max=0.0), row(gauss_min=0.9, gauss_max=1.1), row(gauss_min=0.5, gauss_max=2.0)]
    assert best(rows, SPREAD, "spheres") == {1}
    assert best(rows, SPREAD, "planes") == {0}
    assert not best(rows, SPREAD, "quadrics")
    assert best([*rows, row(gauss_min=-1e-25, gauss_max=1e-17)], SPREAD, "planes") == {0, 3}


@given(st.lists(st.tuples(st.sampled_from(RANKED), st.sampled_from("abcd")), max_size=12))
def test_judgements_name_every_dataset_once_and_the_worst_first(given_: list[tuple[str, str]]) -> None:
    pairs = dict.fromkeys((dataset, verdict) for verdict, dataset in given_)
    rows = [{"claim": "order 2", "verdict": verdict, "dataset": dataset} for dataset, verdict in pairs]
    found = judgements(rows)
    assert sorted((dataset, one.verdict) for one in found for dataset in one.datasets) == sorted(pairs)
    assert [rank(one.verdict) for one in found] == sorted(rank(one.verdict) for one in found)


def test_claims_with_the_same_fate_share_a_judgement() -> None:
    rows = [{"claim": f"matches {what}", "verdict": "not testable", "dataset": ""} for what in ("points", "normals")]
    (one,) = judgements(rows)
    assert (one.claims, one.datasets) == (("points", "normals"), ())


def test_a_claim_met_and_missed_shows_both_with_the_datasets() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return good(scheme, dataset, level, gap_max=1.0 if (scheme, dataset) == ("p2", "cube") else 0.0)

    page = view(results(datasets=("ball", "cube", "egg"), make=make))
    continuity = page.matrix.kinds.index("continuity")
    p2, p4 = page.matrix.rows
    assert [(one.verdict, one.datasets) for one in p2.cells[continuity]] == [
        ("missed", ("cube",)),
        ("met", ("ball", "egg")),
    ]
    assert [(one.verdict, one.everywhere) for one in p4.cells[continuity]] == [("met", True)]
    assert any("p2, continuity C0, on cube" in sentence for sentence in page.sentences)


def test_orders_are_shown_with_their_interval_and_verdict() -> None:
    page = view(results())
    (p2,), (p4,) = page.overview
    assert (p2.order.text, p2.verdict) == ("2.00", "met")
    assert (p4.order.text, p4.verdict) == ("4.00", "exceeded")
    assert p2.order.place == "[2.00, 2.00]"


def test_schemes_are_compared_at_the_finest_level_that_most_have() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome | None:
        if scheme == "p4" and level == 3:
            return Outcome("failed", "it broke", "Traceback", faces=512)
        return good(scheme, dataset, level)

    grid = Grid.of(results(make=make))
    assert grid.compared("ball") == 2
    assert "level 2" in view(results(make=make)).sections[0].remark


def test_a_cell_that_is_not_ok_tells_its_reason_and_a_missing_one_that_it_is() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome | None:
        fates = {"p4": good(scheme, dataset, level), "no": Outcome("refused", "not this mesh")}
        return fates.get(scheme)

    found = results(("p4", "no", "later"), make=make)
    table = comparison(Grid.of(found), "ball", 3)
    assert [one.trouble for one in table.rows] == ["", "refused: not this mesh", "not computed yet"]
    assert [cell.order.text for (cell,) in view(found).overview][1] == "refused"
    assert "4 cells have no result yet." in view(found).sentences
    assert len(view(found).missing) == 4


def test_the_best_scheme_is_marked_and_named_in_the_summary() -> None:
    grid = Grid.of(results(("p2", "p4", "no"), make=lambda *at: None if at[0] == "no" else good(*at)))
    table = comparison(grid, "ball", 3)
    assert [shown(one.entries, table.headings, "max").best for one in table.rows[:2]] == [False, True]
    assert any(text.startswith("The smallest distance") and "p4 on ball" in text for text in sentences(grid, 4))


def test_the_summary_stays_short_however_much_there_is_to_say() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return good(scheme, dataset, level, gap_max=1.0, distance_max=0.5**level * (1.0 + len(scheme) // 4))

    page = view(results([f"p{'x' * number}" for number in range(30)], [f"d{number}" for number in range(5)], 3, make))
    missed = page.sentences[-1]
    assert missed.startswith("Missed: ")
    assert missed.endswith("; and 87 more.")
    assert all(len(sentence) < 300 for sentence in page.sentences)


def test_what_most_schemes_reach_does_not_stand_out() -> None:
    page = view(results(make=lambda *at: good(at[0], at[1], at[2], distance_max=0.1)))
    winner = page.contests[0].winners[0]
    assert winner is not None
    assert winner.alike
    assert not any(sentence.startswith("The smallest distance") for sentence in page.sentences)


def test_all_columns_have_numbers_with_their_places() -> None:
    table = every_level(Grid.of(results()), "ball")
    assert len(table.rows) == 8
    epsilon = shown(table.rows[2].entries, table.headings, "epsilon_deg")
    assert epsilon.place == "face 2 (0.500 0.250 0.250)"
    assert float(epsilon.exact) == 10.0 * 0.25**2


def test_without_exact_surface_its_columns_are_left_out() -> None:
    found = results(make=lambda *at: without(good(*at), "distance_max", "normal_max_deg"), shape=None)
    section = view(found).sections[0]
    assert section.table is not None
    assert "normal error (°)" not in dict(section.table.headings)
    assert "no exact surface" in section.remark
    assert [panel.title for panel in section.drawings[0].panels] == [
        "Largest normal jump ε",
        "Gaussian curvature, max and min",
    ]


def test_guaranteed_bounds_stand_with_their_value_and_in_no_column_of_their_own() -> None:
    bounds = (Column("gauss_max_low", "lower bound"), Column("gauss_max_high", "upper bound"))

    def make(scheme: str, dataset: str, level: int) -> Outcome:
        done = good(scheme, dataset, level)
        return done if scheme == "p2" else good(scheme, dataset, level, gauss_max_low=1.0, gauss_max_high=3.5)

    found = Grid.of(results(("p2", "p4"), ("ball",), 1, make, columns=(*COLUMNS, *bounds)))
    whole, compared = every_level(found, "ball"), comparison(found, "ball", 0)
    names = [name for name, _ in whole.headings]
    assert not [name for name in names if name.endswith(("_low", "_high"))]
    without_bounds, with_bounds = (row.entries[names.index("gauss_max")].exact for row in whole.rows)
    assert without_bounds == "3.0"
    assert with_bounds == "3.0; guaranteed from 1.0 to 3.5"
    assert with_bounds in {entry.exact for entry in compared.rows[1].entries}


def test_a_value_that_its_guaranteed_bounds_refute_stands_at_the_bound() -> None:
    bounds = (Column("distance_max_low", "lower bound"), Column("distance_max_high", "upper bound"))

    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return good(scheme, dataset, level, distance_max=0.0, distance_max_low=0.25, distance_max_high=0.5)

    found = Grid.of(results(("p2", "p4"), ("ball",), 1, make, columns=(*COLUMNS, *bounds)))
    assert [row["distance_max"] for row in found.on("ball")] == [0.25, 0.25]
    assert "0.25; guaranteed from 0.25 to 0.5" in {
        entry.exact for entry in comparison(found, "ball", 0).rows[0].entries
    }


def test_levels_left_out_of_the_fit_are_hollow() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return good(scheme, dataset, level, distance_max=3.0 if level == 0 else 0.1 * 0.5 ** (2 * level))

    (line, _) = panels(Grid.of(results(make=make)), "ball")[0].lines
    assert line.used == (False, True, True, True)


def test_a_zero_is_not_drawn_on_a_logarithmic_axis_but_named() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return good(scheme, dataset, level, distance_max=0.0) if scheme == "p2" else good(scheme, dataset, level)

    distance = panels(Grid.of(results(make=make)), "ball")[0]
    assert (distance.zeros, [line.position for line in distance.lines]) == (("p2",), [1])


def test_a_single_level_has_tables_and_plots_and_says_why_there_is_no_order() -> None:
    page = view(results(levels=1))
    (section,) = page.sections
    assert section.table is not None
    assert section.level == 0
    assert all(one.order.text == "–" and "needs 3" in one.reason for one in section.orders if one.quantity != "gap")


def test_results_without_a_single_cell_are_a_page_too() -> None:
    page = view(results(make=lambda *_: None, run={}))
    assert page.sections[0].table is None
    assert page.contests == ()
    assert page.facts == (("Run", "not ended yet: there is no record of it"),)


def test_measures_that_give_nothing_known_still_have_their_columns_shown() -> None:
    columns = (replace(COLUMNS[0], name="roundness", meaning="how round"),)
    found = results(columns=columns, make=lambda *at: replace(good(*at), values={"roundness": 0.5}))
    grid = Grid.of(found)
    assert "roundness" in dict(every_level(grid, "ball").headings)
    assert every_order(grid, "ball") == ()
    assert view(found).sections[0].drawings == ()
