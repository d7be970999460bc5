"""Speed and memory of fitting, beside the vertex normals that trimesh computes on the same mesh.

Run as the jets' benchmark is. What is compared is timed in turns in one process, and the best time of each counts.
"""

import time
import tracemalloc
from collections.abc import Callable

import pytest
import trimesh
from pytest_benchmark.fixture import BenchmarkFixture

import testbed
from testbed.geometry.mesh import HermiteMesh

#: 102,400 and 25,600 faces, with exact normals and second forms.
FINE, COARSE = 5, 4
ROUNDS = 9


def fresh(level: int) -> HermiteMesh:
    return testbed.dataset("torus").mesh(level)


def vertex_normals(mesh: HermiteMesh) -> Callable[[], object]:
    return lambda: trimesh.Trimesh(mesh.points, mesh.faces, process=False).vertex_normals


def fit(spec: str, mesh: HermiteMesh) -> Callable[[], object]:
    """From arrays to a surface: the checks of the mesh and its edge table are part of it."""
    scheme = testbed.scheme(spec)
    return lambda: scheme.fit(HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms))


def best_of(*works: Callable[[], object]) -> list[float]:
    best = [float("inf")] * len(works)
    for _ in range(ROUNDS):
        for place, work in enumerate(works):
            start = time.perf_counter()
            work()
            best[place] = min(best[place], time.perf_counter() - start)
    return best


@pytest.mark.parametrize(("spec", "aim"), [("shirman-sequin", 30.0), ("cubic-interpolant", 80.0)])
def test_fitting_against_vertex_normals(benchmark: BenchmarkFixture, spec: str, aim: float) -> None:
    mesh = fresh(FINE)
    normals, seconds = best_of(vertex_normals(mesh), fit(spec, mesh))
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        fit(spec, mesh), rounds=2
    )
    benchmark.extra_info["ratio"] = seconds / normals
    print(f"\nfit of {spec} / vertex normals, {len(mesh.faces)} faces: {seconds / normals:.1f}")  # noqa: T201 - as above
    assert seconds <= aim * normals


@pytest.mark.parametrize("spec", ["shirman-sequin", "cubic-interpolant"])
def test_fitting_grows_no_faster_than_the_mesh(benchmark: BenchmarkFixture, spec: str) -> None:
    small, large = best_of(fit(spec, fresh(COARSE)), fit(spec, fresh(FINE)))
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        fit(spec, fresh(COARSE)), rounds=2
    )
    benchmark.extra_info["ratio"] = large / small
    print(f"\nfit of {spec}, four times the faces: {large / small:.2f} times the time")  # noqa: T201 - as above
    assert large <= 4.4 * small


@pytest.mark.parametrize("spec", ["shirman-sequin", "cubic-interpolant"])
def test_peak_memory_of_fitting(benchmark: BenchmarkFixture, spec: str) -> None:
    """No aim: bytes a face at the peak, the surface included."""
    mesh = fresh(COARSE)
    benchmark.pedantic(  # type: ignore[no-untyped-call]
        fit(spec, mesh), rounds=1
    )
    tracemalloc.start()
    surface = fit(spec, mesh)()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert surface is not None
    benchmark.extra_info["bytes_per_face"] = peak / len(mesh.faces)
    print(f"\nfit of {spec}: {peak / len(mesh.faces):.0f} bytes a face at the peak")  # noqa: T201 - as above
