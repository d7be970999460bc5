"""Levels that a bounded amount of work allows: never more than the bound, coarse ones first, alike everywhere."""

from hypothesis import given
from hypothesis import strategies as st

from testbed.harness.selection import affordable, cell_weight

sizes = st.dictionaries(
    st.sampled_from("abcd"),
    st.integers(1, 10_000).map(lambda n: {level: n * 4**level for level in range(4)}),
    min_size=1,
)
works = st.lists(st.floats(0.1, 100.0), min_size=1, max_size=5)


@given(sizes, works, st.floats(0.0, 1e8))
def test_the_work_is_bounded_and_a_level_comes_with_those_below_it(
    faces: dict[str, dict[int, int]], work: list[float], budget: float
) -> None:
    levels, left_out = affordable(faces, dict.fromkeys(faces, sum(work)), budget)
    spent = sum(sum(work) * cell_weight(faces[dataset][level]) for dataset, some in levels.items() for level in some)
    assert spent <= budget * (1.0 + 1e-12)
    for dataset, some in levels.items():
        assert some == tuple(range(len(some)))
        rest = [level for one in left_out if one.dataset == dataset for level in one.levels]
        assert [*some, *rest] == sorted(faces[dataset])


@given(sizes, works, st.floats(0.0, 1e8), st.floats(1.0, 10.0))
def test_more_work_allows_more(
    faces: dict[str, dict[int, int]], work: list[float], budget: float, factor: float
) -> None:
    together = dict.fromkeys(faces, sum(work))
    fewer, _ = affordable(faces, together, budget)
    more, _ = affordable(faces, together, budget * factor)
    assert all(set(fewer[dataset]) <= set(more[dataset]) for dataset in faces)


def test_a_dataset_too_large_leaves_the_others_alone() -> None:
    levels, left_out = affordable({"small": {0: 10, 1: 40}, "huge": {0: 10**9}}, {"small": 1.0, "huge": 1.0}, 1e4)
    assert levels == {"small": (0, 1), "huge": ()}
    assert [one.dataset for one in left_out] == ["huge"]


def test_a_dataset_that_costs_more_to_measure_gets_fewer_levels() -> None:
    faces = {name: {level: 100 * 4**level for level in range(4)} for name in ("plain", "dear")}
    levels, _ = affordable(faces, {"plain": 1.0, "dear": 5.0}, 30_000.0)
    assert len(levels["dear"]) < len(levels["plain"])
