"""A picture of about 50 000 triangles at 800 x 800 pixels, beside matplotlib's ``plot_trisurf`` of the same triangles.

Ours evaluates normals on the patches in every pixel, with four samples a pixel, and hides what is behind exactly;
matplotlib sorts flat triangles by depth and gives each one colour. Rounds alternate; the median of ratios is printed,
and the peak of memory of processes that draw pictures, Python and its libraries included.
"""

import io
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.surface import Surface
from testbed_reports.rendering.colouring import CURVED, Scale, Style
from testbed_reports.rendering.facets import Facets, facets_of
from testbed_reports.rendering.picture import look, pixels

SIZE = 800
ROUNDS = 5
#: How many times as long as matplotlib's a picture may take: exact normals, curvatures in every sample.
SLOWEST = {"shaded": 6.0, "gauss": 14.0}
#: Megabytes.
MOST_MEMORY = 600.0

_PICTURE = f"""
import re, sys
from pathlib import Path
from testbed import registry
from testbed_reports.rendering.figure import Subject, write_figure
surface = registry.scheme("shirman-sequin").fit(registry.dataset("octahedron").mesh(2))
write_figure(Path(sys.argv[1]), [Subject("", surface)], sys.argv[2], size={SIZE})
# of this process alone: what getrusage tells begins with that of the process that started it
print(re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1])
"""


def drawn() -> tuple[Surface, Facets]:
    """A surface, and the triangles that the renderer divides it into."""
    surface = registry.scheme("shirman-sequin").fit(registry.dataset("octahedron").mesh(2))
    facets = facets_of(surface)
    assert 40_000 <= len(facets) <= 60_000
    return surface, facets


def seconds(task: Callable[[], object]) -> float:
    begin = time.perf_counter()
    task()
    return time.perf_counter() - begin


def trisurf(facets: Facets) -> bytes:
    """The same triangles as matplotlib draws them."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 8.0), dpi=SIZE / 8.0)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")
    axes.plot_trisurf(*facets.points.T, triangles=facets.corners, linewidth=0.0)  # type: ignore[attr-defined]  # 3-D axes
    stream = io.BytesIO()
    figure.savefig(stream, format="rgba")
    return stream.getvalue()


@pytest.mark.parametrize("style", ["shaded", "gauss"])
def test_a_picture_beside_matplotlibs(style: Style) -> None:
    surface, facets = drawn()
    scale = Scale(-1.0 if style in CURVED else 0.0, 1.0)
    trisurf(facets)
    rounds = np.array(
        [
            (seconds(lambda: pixels(look(surface, style, SIZE), style, scale)), seconds(lambda: trisurf(facets)))
            for _ in range(ROUNDS)
        ]
    )
    ours, theirs = np.median(rounds, axis=0)
    ratio = float(np.median(rounds[:, 0] / rounds[:, 1]))
    print(  # noqa: T201 - what the benchmark is for
        f"\n{len(facets)} triangles, {SIZE} x {SIZE}, {style}: {ours:.2f} s, plot_trisurf {theirs:.2f} s: {ratio:.1f} "
        "times as long"
    )
    assert ratio < SLOWEST[style]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="this system does not tell the peak of a process")
@pytest.mark.parametrize("style", ["shaded", "gauss", "zebra", "jump"])
def test_memory(style: Style) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", _PICTURE, f"{folder}/one.png", style]
        result = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    peak = float(result.stdout) / 1024.0
    print(f"\n{style}: {peak:.0f} MB at the peak")  # noqa: T201 - what the benchmark is for
    assert peak < MOST_MEMORY
