"""PNG files of figures: the same figure has the same bytes, whatever matplotlib's user has set."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from testbed_reports.plots import SETTINGS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Pixels of a figure an inch; titles and labels are in points.
DPI: Final = 120


def write_png(path: Path, draw: "Callable[[], Figure]", dpi: int = DPI) -> Path:
    """Write the figure that a function draws, and return the path.

    Parameters
    ----------
    path
        The file; folders are made.
    draw
        Called with our settings of matplotlib.
    dpi
        Pixels an inch.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        figure = draw()
        FigureCanvasAgg(figure)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(stream.getvalue())
    return path
