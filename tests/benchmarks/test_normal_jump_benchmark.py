"""Speed of the exact largest angle along edges against sampling, as ratios within one process.

Run with ``OPENBLAS_NUM_THREADS=1 pytest tests/benchmarks -n 0 --benchmark-enable -o addopts="" -s``. No assertion is
about seconds: what is compared is timed in turns on the same edges, and the best time of each counts.
"""

import time
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.edges import PatchEdges
from testbed.geometry.surface import Surface
from testbed.measures.continuity import Continuity, edge_jumps, interior_edges
from testbed.measures.edge_angles import edge_angles
from testbed.measures.exact_continuity import ExactContinuity
from testbed.plugins.measure import Survey
from testbed.registry import dataset, scheme

SAMPLES = 200
#: Edges sampled at once: a chunk of samples stays in the cache.
CHUNK = 80
#: Cubics with angles of all sizes, quartics that join smoothly, and cubics without any order.
KINDS = ("cubic-interpolant", "pn-triangle", "shirman-sequin", "random cubics")
every_kind = pytest.mark.parametrize("kind", KINDS)


def surface(kind: str) -> Surface:
    mesh = dataset("torus").mesh(2)
    if kind != "random cubics":
        return scheme(kind).fit(mesh)
    batch = scheme("pn-triangle").fit(mesh).batches[0]
    assert isinstance(batch, BezierTriangles)
    noise = 0.01 * np.random.default_rng(0).normal(size=batch.control_points.shape)
    return Surface.over_faces(mesh, BezierTriangles(batch.control_points + noise))


def sample(of: Surface, edges: PatchEdges, count: int = SAMPLES) -> list[object]:
    """Largest of even samples on every edge."""
    t = np.arange(count) / (count - 1)
    chunks = (edges[start : start + CHUNK] for start in range(0, len(edges), CHUNK))
    return [edge_jumps(of, some, t)[0].max(axis=1) for some in chunks]


def best_of(works: Sequence[Callable[[], object]], rounds: int = 7) -> list[float]:
    """Return the best time of each; in turns, so that what else the machine does meets all alike."""
    best = [float("inf")] * len(works)
    for _ in range(rounds):
        for place, work in enumerate(works):
            start = time.perf_counter()
            work()
            best[place] = min(best[place], time.perf_counter() - start)
    return best


def report(benchmark: BenchmarkFixture, title: str, ratio: float, seconds: float, edges: int) -> None:
    benchmark.extra_info["ratio"] = ratio
    print(f"\n{title}: {ratio:.3f} ({seconds / edges * 1e6:.1f} us an edge)")  # noqa: T201 - what a benchmark is for


@every_kind
def test_exact_and_enclosed_is_faster_than_200_samples_an_edge(benchmark: BenchmarkFixture, kind: str) -> None:
    one = surface(kind)
    edges = interior_edges(one)
    sampled, exact = best_of([lambda: sample(one, edges), lambda: edge_angles(one, edges)])
    benchmark.pedantic(edge_angles, args=(one, edges), rounds=3)  # type: ignore[no-untyped-call]
    report(benchmark, f"exact, with bounds, / {SAMPLES} samples an edge, {kind}", exact / sampled, exact, len(edges))
    assert exact < sampled


@every_kind
def test_the_exact_maximum_of_a_surface_costs_about_what_the_sampled_one_does(
    benchmark: BenchmarkFixture, kind: str
) -> None:
    one = surface(kind)
    survey = Survey(one)
    sampled, exact = best_of([lambda: Continuity().measure(survey), lambda: ExactContinuity().measure(survey)])
    benchmark.pedantic(ExactContinuity().measure, args=(survey,), rounds=3)  # type: ignore[no-untyped-call]
    count = int(one.edges.interior.sum())
    report(benchmark, f"largest exact angle / largest sampled one, {kind}", exact / sampled, exact, count)
    assert exact < 1.25 * sampled
