"""Price of certified curvature extremes beside sampled and searched ones.

Run with ``OPENBLAS_NUM_THREADS=1 pytest tests/benchmarks -n 0 --benchmark-enable -o addopts="" -s``. No assertion is
about seconds: ratios are of best times within one process.
"""

import time

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import testbed
from testbed.geometry.curvature_bounds import surface_bounds
from testbed.geometry.surface import Surface
from testbed.measures.certified_curvature import EXTREMES, CertifiedCurvature
from testbed.measures.curvature import CurvatureExtremes
from testbed.plugins.measure import Survey

ROUNDS = 5


def fitted(scheme: str, level: int) -> Surface:
    return testbed.scheme(scheme).fit(testbed.dataset("torus").mesh(level))


def times(surface: Surface) -> tuple[float, float]:
    """Best seconds of sampling and searching, and of certifying what was found."""
    best = [float("inf")] * 2
    certified = CertifiedCurvature(coefficients=10**9)
    for _ in range(ROUNDS):
        survey = Survey(surface)
        for place, measure in enumerate((CurvatureExtremes(), certified)):
            start = time.perf_counter()
            measure.measure(survey)
            best[place] = min(best[place], time.perf_counter() - start)
    return best[0], best[1]


@pytest.mark.parametrize(
    ("scheme", "level"), [("nagata", 2), ("cubic-interpolant", 2), ("shirman-sequin", 1), ("shirman-sequin", 2)]
)
def test_certified_extremes_against_sampled_ones(benchmark: BenchmarkFixture, scheme: str, level: int) -> None:
    surface = fitted(scheme, level)
    sampled, certified = times(surface)
    bounds = surface_bounds(surface.batches)
    gaps = []
    for name in EXTREMES:
        enclosure = getattr(bounds, name)
        kind = name.split("_")[0]
        largest = max(abs(getattr(bounds, f"{kind}_min").low[0]), abs(getattr(bounds, f"{kind}_max").high[0]))
        gaps.append(float((enclosure.high - enclosure.low)[0]) / largest)
    benchmark.extra_info["ratio"] = certified / sampled
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        surface_bounds, args=(surface.batches,), rounds=2
    )
    patches = surface.patch_count
    print(  # noqa: T201 - the measured ratio is what a benchmark is for
        f"\n{scheme} on {len(surface.mesh.faces)} faces, {patches} patches: certified / sampled "
        f"{certified / sampled:.2f} ({certified / patches * 1e6:.0f} µs a patch), relative gap {max(gaps):.1e}"
    )
    assert max(gaps) <= 1e-6
    assert certified <= 20.0 * sampled
