"""The surfaces that a report shows: fitted again from what the results say, if nothing they depend on has changed.

Results hold numbers, not surfaces. A surface follows from the texts of its scheme and dataset and the level, bit for
bit, as long as the sources are those that the results were computed with; a report never shows another one.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from testbed import registry
from testbed.errors import Refused, TestbedError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.grid import NEARLY, Grid, is_ok


@dataclass(frozen=True, eq=False)
class ShownSurface:
    """A surface in a report, or why there is none.

    Parameters
    ----------
    scheme, dataset, level
        Texts of the plugins, and the level.
    surface
        The surface, or None.
    exact
        The surface that it approximates, or None.
    reason
        Why there is no surface, in one sentence; empty where there is one.
    """

    scheme: str
    dataset: str
    level: int
    surface: Surface | None
    exact: ExactSurface | None
    reason: str = ""


def shown_level(grid: Grid, dataset: str) -> int:
    """Return the level whose surfaces are shown: the coarsest on which nearly as many cells are ok as on any.

    There schemes differ to the eye; on fine meshes all of them look alike.
    """
    levels = grid.levels(dataset)
    counts = {level: sum(is_ok(row) for row in grid.at(dataset, level)) for level in levels}
    most = max(counts.values(), default=0)
    return min((level for level, count in counts.items() if count >= NEARLY * most), default=0)


def shown_surfaces(
    results: Results, dataset: str, level: int | None = None, sources: Sources | None = None
) -> Iterator[ShownSurface]:
    """Yield the surfaces of all schemes on a dataset, one by one, in the order of the plan.

    Parameters
    ----------
    results
        The results of a run, finished or not.
    dataset
        Text of a dataset of the plan.
    level
        The level; None for :func:`shown_level`.
    sources
        Source hashes, to be shared by several datasets; None to read the files again.
    """
    grid = Grid.of(results)
    chosen = shown_level(grid, dataset) if level is None else level
    cells = {(one.scheme, one.dataset, one.level) for one in results.plan.cells}
    sources = sources or Sources()
    planned = next(one for one in results.plan.datasets if one.spec == dataset)
    try:
        registered = registry.dataset(dataset)
        changed = sources.content(registered) != planned.source
        mesh, exact = registered.mesh(chosen), registered.surface
    except TestbedError as error:
        for text in grid.schemes:
            yield ShownSurface(text, dataset, chosen, None, None, str(error))
        return
    for scheme in results.plan.schemes:
        if (scheme.spec, dataset, chosen) not in cells:
            continue
        row = grid.cells.get((scheme.spec, dataset, chosen))
        surface, reason = None, ""
        if row is None:
            reason = "not computed yet"
        elif row["status"] != "ok":
            reason = str(row["reason"])
        else:
            try:
                one = registry.scheme(scheme.spec)
                if changed or sources.content(one) != scheme.source:
                    reason = "its source has changed since the results were computed: run again"
                else:
                    surface = one.fit(mesh)
            except (TestbedError, Refused) as error:
                reason = str(error)
        yield ShownSurface(scheme.spec, dataset, chosen, surface, exact if surface else None, reason)
