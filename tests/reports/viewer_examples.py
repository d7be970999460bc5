"""Results whose surfaces a page can show: real plugins, numbers made by hand, places that exist."""

from dataclasses import replace
from typing import Final

from hand_made_results import COLUMNS, good, results

from testbed import registry
from testbed.harness.cell import Outcome
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed.plugins.measure import Column

SCHEMES: Final = ("shirman-sequin", "nielson", "flat")
DATASET: Final = "octahedron"
PLACED: Final = (
    *COLUMNS,
    Column("gauss_max_face", "its face"),
    Column("gauss_max_bary", "its place"),
    Column("gauss_min_face", "its face"),
    Column("gauss_min_bary", "its place"),
)
#: Where the largest Gaussian curvature is said to be.
PLACE: Final = (3, (0.5, 0.25, 0.25))


def placed(scheme: str, dataset: str, level: int) -> Outcome:
    """Return a cell with places, and a distance that tells schemes apart."""
    bary = ";".join(map(str, PLACE[1]))
    places = {"gauss_max_face": PLACE[0], "gauss_max_bary": bary, "gauss_min_face": -1, "gauss_min_bary": ""}
    error = 0.01 * len(scheme)
    return good(scheme, dataset, level, distance_max=error, epsilon_face=0, epsilon_bary="0;0.5;0.5", **places)


def shown_results(
    schemes: tuple[str, ...] = SCHEMES, datasets: tuple[str, ...] = (DATASET,), refused: str = ""
) -> Results:
    """Return results of plugins that exist, with the source hashes that they have; one scheme may be refused."""

    def make(scheme: str, dataset: str, level: int) -> Outcome:
        if scheme == refused:
            return Outcome("refused", "it does not like this mesh", faces=8)
        return placed(scheme, dataset, level)

    found = results(schemes, datasets, 1, make, columns=PLACED)
    sources = Sources()
    planned = found.plan
    schemes_known = (replace(one, source=sources.content(registry.scheme(one.spec))) for one in planned.schemes)
    datasets_known = (replace(one, source=sources.content(registry.dataset(one.spec))) for one in planned.datasets)
    plan = replace(planned, schemes=tuple(schemes_known), datasets=tuple(datasets_known))
    return replace(found, plan=plan)
