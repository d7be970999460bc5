"""The scenes of a page, computed in worker processes where there are many surfaces."""

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from testbed import registry
from testbed.errors import TestbedError
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.grid import Grid
from testbed_reports.viewer.model import BUDGET, Card, Scene, scene, surface_count

#: Up to so many surfaces are made here: workers take seconds to start.
FEW: Final = 24
#: Seconds that the surfaces of a dataset may take.
LIMIT: Final = 600.0


def scenes(results: Results, jobs: int | None = None) -> tuple[Scene, ...]:
    """Return a scene for each dataset of the plan, the same however many processes make them.

    Parameters
    ----------
    results
        The results.
    jobs
        Worker processes; None for one a processor where there are many surfaces, else this one.
    """
    from testbed.harness.run import processors

    grid = Grid.of(results)
    count = surface_count(grid)
    each = BUDGET / max(count, 1)
    sources = _known(results)
    parts = [part_of(results, dataset) for dataset in grid.datasets]
    if jobs is None:
        jobs = 1 if count <= FEW else processors()
    if jobs == 1:
        return tuple(scene_of(part, dataset, each, sources) for part, dataset in zip(parts, grid.datasets, strict=True))
    return _in_workers(grid, parts, each, sources, jobs)


def part_of(results: Results, dataset: str) -> Results:
    """Return the results of one dataset, all schemes in their places."""
    cells = tuple(cell for cell in results.plan.cells if cell.dataset == dataset)
    return replace(
        results,
        plan=replace(results.plan, cells=cells),
        cells=results.cells[results.cells["dataset"] == dataset],
        orders=results.orders[:0],
        claims=results.claims[:0],
        run={},
        tracebacks={},
        missing=(),
    )


def _known(results: Results) -> Sources:
    """Return the source hashes of all plugins of the plan that exist: every process would read the same files."""
    sources = Sources()
    for find, planned in ((registry.scheme, results.plan.schemes), (registry.dataset, results.plan.datasets)):
        for one in planned:
            with contextlib.suppress(TestbedError):  # who looks for its surfaces will say why there are none
                sources.content(find(one.spec))
    return sources


def scene_of(results: Results, dataset: str, each: float, sources: Sources) -> Scene:
    """Return a scene; one of reasons only where a plugin fails now that did not fail before."""
    try:
        return scene(results, dataset, each, sources)
    except Exception as error:  # noqa: BLE001 - a third party's plugin must not cost the page its other parts
        return _without(Grid.of(results), dataset, f"{type(error).__name__}: {error}")


def _without(grid: Grid, dataset: str, reason: str) -> Scene:
    planned = [(position, one) for position, one in enumerate(grid.schemes) if grid.planned(one, dataset)]
    return Scene(dataset, 0, tuple(Card(position, one, reason) for position, one in planned), {}, {})


def _in_workers(grid: Grid, parts: Sequence[Results], each: float, sources: Sources, jobs: int) -> tuple[Scene, ...]:
    from testbed.harness.workers import Died, Returned, TimedOut, Workers

    # the longest first
    waiting = sorted(range(len(parts)), key=lambda number: -len(parts[number].plan.cells))
    made: dict[int, Scene] = {}
    with Workers(min(jobs, len(parts)), LIMIT) as workers:
        while waiting or workers.tasks:
            while waiting and workers.free > 0:
                number = waiting.pop(0)
                workers.submit(number, scene_of, parts[number], grid.datasets[number], each, sources)
            for outcome in workers.wait(1.0):
                match outcome:
                    case Returned(task=number, value=value):
                        made[number] = value
                    case TimedOut(task=number):
                        late = f"its surfaces take more than {LIMIT:g} s"
                        made[number] = _without(grid, grid.datasets[number], late)
                    case Died(task=number, reason=reason):
                        made[number] = _without(grid, grid.datasets[number], reason)
    return tuple(made[number] for number in range(len(parts)))
