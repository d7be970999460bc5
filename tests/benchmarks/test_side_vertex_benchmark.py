"""Speed of side-vertex patches: what it saves to differentiate along the side in its own parameter.

Run with ``OPENBLAS_NUM_THREADS=1 pytest tests/benchmarks -n 0 --benchmark-enable -o addopts="" -s``. As in
:mod:`test_jets_benchmark`, two ways are timed in turns and the best time of each counts.
"""

import time
from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from testbed.conformance.meshes import torus
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.plugins.scheme import Scheme
from testbed_schemes.hagen_pottmann import HagenPottmann
from testbed_schemes.nielson import Nielson
from testbed_schemes.nielson_conic import NielsonConic

#: 66 samples a patch, of 320 patches.
AT = lattice(3, 10)
ROUNDS = 40


def seconds(batch: PatchBatch) -> float:
    start = time.perf_counter()
    batch.jets(AT)
    return time.perf_counter() - start


@pytest.mark.parametrize(
    ("scheme", "share"), [(Nielson(), 0.8), (NielsonConic(), 0.8), (HagenPottmann(), 0.7)], ids=str
)
def test_jets_take_a_share_of_the_time_in_two_variables(
    benchmark: BenchmarkFixture, monkeypatch: pytest.MonkeyPatch, scheme: Scheme, share: float
) -> None:
    batch = scheme.fit(torus(16, 10, 3)).batches[0]
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        batch.jets, args=(AT,), rounds=10
    )
    one, two = [], []
    for _ in range(ROUNDS):
        one.append(seconds(batch))
        with monkeypatch.context() as patched:
            patched.setattr("testbed_schemes.mathematics.side_vertex.in_one_parameter", in_two_variables)
            two.append(seconds(batch))
    ratio = min(one) / min(two)
    benchmark.extra_info["ratio"] = ratio
    print(  # noqa: T201 - the measured ratio is what a benchmark is for
        f"\n{scheme}, one parameter / two variables: {ratio:.2f} "
        f"({1e6 * min(one) / (len(batch) * len(AT)):.2f} microseconds a point)"
    )
    assert ratio <= share


def in_two_variables(t: Any, rest: Any) -> tuple[Any, Any]:
    """What ``in_one_parameter`` would return if functions of one parameter were differentiated as any others."""
    return t, rest
