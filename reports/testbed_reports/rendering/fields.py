"""What a picture shows of a surface: normals, curvatures and distances, evaluated on the patches where pixels look."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.curvature import analyse
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed_reports.rendering.visibility import Sights

#: Points evaluated at once.
CHUNK = 16_384


@dataclass(frozen=True, eq=False)
class Fields:
    """Values at the places that a picture looks at.

    Parameters
    ----------
    normals
        (N, 3) unit normals; NaN where a patch has none.
    gauss, mean
        (N,) curvatures; NaN where not asked for, or where a patch has none.
    distance
        (N,) distance from the exact surface; NaN where not asked for or not known.
    """

    normals: Float
    gauss: Float
    mean: Float
    distance: Float

    def some(self, chosen: slice) -> "Fields":
        """Return the values at some of the places."""
        return Fields(self.normals[chosen], self.gauss[chosen], self.mean[chosen], self.distance[chosen])


def fields(surface: Surface, sights: Sights, *, curved: bool = True, exact: ExactSurface | None = None) -> Fields:
    """Evaluate a surface where pixels look.

    Parameters
    ----------
    curved
        Whether curvatures are asked for.
    exact
        The surface that distances are asked from, or None.
    """
    normals = np.full((len(sights), 3), np.nan)
    gauss, mean, distance = np.full((3, len(sights)), np.nan)
    for index, part in enumerate(surface.parts):
        (mine,) = np.nonzero(sights.part == index)
        for some in np.array_split(mine, max(1, -(-len(mine) // CHUNK))):
            jet = part.batch.take(sights.patch[some]).jets(sights.at[some][:, None], 2 if curved else 1)
            # a patch without a normal at a place has NaN there, and the picture shows that
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                normals[some] = jet.normal[:, 0]
                if curved:
                    analysis = analyse(jet)
                    gauss[some], mean[some] = analysis.gauss[:, 0], analysis.mean[:, 0]
            if exact is not None:
                points = jet.f[:, 0]
                distance[some] = norm(points - exact.closest(points))
    return Fields(normals, gauss, mean, distance)
