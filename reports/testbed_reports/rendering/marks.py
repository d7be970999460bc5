"""Places of the extremes of curvature, to be marked in pictures."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.surface import Surface
from testbed.measures.curvature import searched_extremes
from testbed.plugins.measure import Survey
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.colouring import Style
from testbed_reports.rendering.lines import in_front
from testbed_reports.rendering.visibility import GRID, Buffer

#: Samples of a surface, and patches in which extremes are searched for: those of the measures.
BUDGET = 60_000
CANDIDATES = 256
#: Which of the extremes found a style shows: the largest value and the smallest.
SHOWN = {"gauss": (1, 0), "thesis": (1, 0), "mean": (3, 2)}


@dataclass(frozen=True)
class Mark:
    """An extreme value in a picture.

    Parameters
    ----------
    value
        The value.
    largest
        Whether it is the largest; else the smallest.
    place
        Pixels to the right and downwards, or None where the place is not known.
    seen
        Whether the place is seen, and not behind something.
    """

    value: float
    largest: bool
    place: tuple[float, float] | None
    seen: bool


def extremes(surface: Surface, style: Style, camera: Camera, buffer: Buffer) -> tuple[Mark, ...]:
    """Return the largest and the smallest curvature of the kind that a style shows; nothing for other styles.

    They are searched for on the whole surface, as in the columns ``gauss_max`` and the like of results.
    """
    if style not in SHOWN:
        return ()
    found = Survey(surface).shared(searched_extremes, BUDGET, CANDIDATES)
    marks = []
    for sign, index in zip((1.0, -1.0), SHOWN[style], strict=True):
        extremum = found[index]
        place, seen = None, False
        if extremum.within is not None:
            at = extremum.within
            batch = surface.parts[at.part].batch.take(np.array([at.patch]))
            point = camera.screen(batch.jets(at.at[None, None], 0).f[:, 0], len(buffer.facet) // GRID)
            if np.isfinite(point).all():
                place, seen = (float(point[0, 0]), float(point[0, 1])), bool(in_front(point, buffer)[0])
        marks.append(Mark(sign * extremum.value + 0.0, sign > 0.0, place, seen))
    return tuple(marks)
