"""Speed of jets and of curvature, as ratios within one process, on one thread of the matrix product.

Run with ``OPENBLAS_NUM_THREADS=1 pytest tests/benchmarks -n 0 --benchmark-enable -o addopts="" -s``. No assertion is
about seconds: what is compared is timed in turns, a chunk of patches at a time, and the best time of each counts.
"""

import time
from collections.abc import Callable, Sequence
from itertools import cycle

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from testbed.geometry.bernstein import point_count, triangle_tables
from testbed.geometry.bezier import BezierTriangles, RationalBezierTriangles
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch

PATCHES, CHUNK = 8000, 800
#: 66 samples a patch.
AT = lattice(3, 10)


def chunked(batch: PatchBatch) -> list[PatchBatch]:
    return [batch.take(slice(start, start + CHUNK)) for start in range(0, len(batch), CHUNK)]


def best_of(works: Sequence[Callable[[PatchBatch], object]], chunks: Sequence[PatchBatch], rounds: int) -> list[float]:
    """Return the best time of each on a chunk; in turns, so that what else the machine does meets all alike."""
    best = [float("inf")] * len(works)
    for _, chunk in zip(range(rounds), cycle(chunks), strict=False):
        for place, work in enumerate(works):
            start = time.perf_counter()
            work(chunk)
            best[place] = min(best[place], time.perf_counter() - start)
    return best


def quartics() -> list[PatchBatch]:
    rng = np.random.default_rng(0)
    return chunked(BezierTriangles(rng.standard_normal((PATCHES, point_count(4), 3))))


def jets(chunk: PatchBatch) -> object:
    return chunk.jets(AT)


def curvatures(chunk: PatchBatch) -> object:
    return analyse(chunk.jets(AT))


def report(benchmark: BenchmarkFixture, title: str, ratio: float, seconds: float) -> None:
    benchmark.extra_info["ratio"] = ratio
    print(  # noqa: T201 - the measured ratio is what a benchmark is for
        f"\n{title}: {ratio:.3f} ({CHUNK * len(AT) / seconds / 1e6:.1f} million points a second)"
    )


def test_jets_of_quartic_triangles_take_at_most_1_25_of_the_bare_product(benchmark: BenchmarkFixture) -> None:
    table = np.ascontiguousarray(triangle_tables(4, AT).reshape(6 * len(AT), -1))
    columns = np.random.default_rng(1).standard_normal((table.shape[1], 3 * CHUNK))
    chunks = quartics()
    bare, seconds = best_of([lambda _: table @ columns, jets], chunks, rounds=300)
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        jets, args=(chunks[0],), rounds=20
    )
    report(benchmark, "jets of quartic triangles / bare matrix product", seconds / bare, seconds)
    assert seconds <= 1.25 * bare


def test_normals_and_curvatures_with_jets_take_at_most_6_times_the_jets(benchmark: BenchmarkFixture) -> None:
    chunks = quartics()
    alone, seconds = best_of([jets, curvatures], chunks, rounds=150)
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        curvatures, args=(chunks[0],), rounds=20
    )
    report(benchmark, "jets, normals, K and H / jets", seconds / alone, seconds)
    assert seconds <= 6.0 * alone


@pytest.mark.parametrize("kind", ["own points", "rational"])
def test_other_jets_against_quartic_jets(benchmark: BenchmarkFixture, kind: str) -> None:
    """No aim: the price of points of their own, and of weights, beside that of shared points."""
    chunks = quartics()
    own = np.broadcast_to(AT, (CHUNK, *AT.shape))
    rng = np.random.default_rng(2)
    points = rng.standard_normal((CHUNK, point_count(4), 3))
    rational = RationalBezierTriangles(points, rng.uniform(0.5, 2.0, points.shape[:2]))

    def other(chunk: PatchBatch) -> object:
        return rational.jets(AT) if kind == "rational" else chunk.jets(own)

    alone, seconds = best_of([jets, other], chunks, rounds=60)
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        other, args=(chunks[0],), rounds=5
    )
    report(benchmark, f"jets, {kind} / jets, shared points", seconds / alone, seconds)
