"""The scenes of a page, computed in worker processes where there are many surfaces."""

from pathlib import Path
from typing import Final

from testbed.harness.results import Results, read_results
from testbed_reports.grid import Grid
from testbed_reports.viewer.model import Card, Scene, scene, surface_count, triangles_for

#: Up to so many surfaces are made here: workers take seconds to start.
FEW: Final = 24
#: Seconds that the surfaces of a dataset may take.
LIMIT: Final = 600.0


def scenes(results: Results, directory: Path | None = None, jobs: int | None = None) -> tuple[Scene, ...]:
    """Return a scene for each dataset of the plan, the same however many processes make them.

    Parameters
    ----------
    results
        The results.
    directory
        Where they were read from, for workers to read them again; None to work here.
    jobs
        Worker processes; None for one a processor.
    """
    grid = Grid.of(results)
    count = surface_count(grid)
    each = triangles_for(count)
    if directory is None or count <= FEW:
        return tuple(scene(results, dataset, each) for dataset in grid.datasets)
    return _in_workers(grid, directory, each, jobs)


def scene_of(directory: Path, dataset: str, triangles: int) -> Scene:
    """Return a scene of the results in a directory; runs in a worker."""
    return scene(read_results(directory), dataset, triangles)


def _in_workers(grid: Grid, directory: Path, triangles: int, jobs: int | None) -> tuple[Scene, ...]:
    from testbed.harness.run import processors
    from testbed.harness.workers import Died, Returned, TimedOut, Workers

    waiting = list(enumerate(grid.datasets))
    made: dict[int, Scene] = {}

    def without(number: int, reason: str) -> Scene:
        dataset = grid.datasets[number]
        planned = [(p, one) for p, one in enumerate(grid.schemes) if grid.planned(one, dataset)]
        return Scene(dataset, 0, tuple(Card(position, one, reason) for position, one in planned), {}, {})

    with Workers(min(jobs or processors(), len(waiting)), LIMIT) as workers:
        while waiting or workers.tasks:
            while waiting and workers.free > 0:
                number, dataset = waiting.pop(0)
                workers.submit(number, scene_of, directory, dataset, triangles)
            for outcome in workers.wait(1.0):
                match outcome:
                    case Returned(task=number, value=value):
                        made[number] = value
                    case TimedOut(task=number):
                        made[number] = without(number, f"its surfaces take more than {LIMIT:g} s")
                    case Died(task=number, reason=reason):
                        made[number] = without(number, reason)
    return tuple(made[number] for number in range(len(grid.datasets)))
