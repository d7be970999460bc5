"""What the page needs for its viewers and tables besides its template: settings and data as JSON, scripts, styles."""

import base64
import hashlib
import json
from importlib.resources import files
from typing import Any, Final

import numpy as np

from testbed.geometry.vectors import unit
from testbed_reports.rendering.colouring import (
    BANDS,
    INNER,
    ISOPHOTE_DEG,
    LIGHT,
    MISSING,
    OUTER,
    PALE,
    THESIS_LIMIT,
    ZEBRA,
    Style,
    palette,
)
from testbed_reports.rendering.figure import EDGE_COLOUR, SMOOTH_DEG, caption
from testbed_reports.view import Page
from testbed_reports.viewer.model import STILL, Scene

#: The colourings to choose from, as they are named there.
STYLES: Final[tuple[tuple[Style, str], ...]] = (
    ("gauss", "Gaussian curvature K"),
    ("mean", "mean curvature H"),
    ("thesis", "K, thesis's red, green, blue"),
    ("distance", "distance"),
    ("jump", "normal jump on edges"),
    ("shaded", "shaded"),
    ("isophotes", "isophotes"),
    ("zebra", "reflection lines (zebra)"),
)
#: Those whose colours are looked up.
PALETTES: Final[tuple[Style, ...]] = ("gauss", "mean", "thesis", "distance", "jump")
#: Scripts in the order they are run in.
SCRIPTS: Final = ("elements.js", "decode.js", "camera.js", "paint.js", "viewer.js", "tables.js")


def script() -> str:
    """Return the page's script."""
    parts = [_text(name).replace("</", "<\\/") for name in SCRIPTS]
    return "\n".join(['"use strict";', "(() => {", *parts, "startTables();", "startViewers();", "})();"])


def digest(text: str) -> str:
    """Return what a page's security policy names a script by: ``sha256-...``."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


def stylesheet() -> str:
    """Return the styles of viewers and tables."""
    return _text("viewer.css").replace("GRADIENT", gradient())


def _text(name: str) -> str:
    return files("testbed_reports.viewer").joinpath(name).read_text("utf-8")


def embedded(value: Any) -> str:
    """Return JSON that stays JSON within a script element, whatever its texts hold."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def settings() -> dict[str, Any]:
    """Return what all viewers share: colourings, look-up tables, colours, as the pictures have them."""
    tables = np.concatenate([np.rint(palette(style) * 255.0).astype(np.uint8) for style in PALETTES])
    colours = {"outer": OUTER, "inner": INNER, "missing": MISSING, "pale": PALE, "dark": BANDS[0], "bright": BANDS[1]}
    return {
        "styles": [{"name": name, "title": title, "caption": caption(name)} for name, title in STYLES],
        "palettes": list(PALETTES),
        "texels": base64.b64encode(tables.tobytes()).decode("ascii"),
        "colours": {name: colour.tolist() for name, colour in colours.items()} | {"edge": list(EDGE_COLOUR)},
        "light": unit(np.array(LIGHT)).tolist(),
        "thesis": [-THESIS_LIMIT, THESIS_LIMIT],
        "isophoteDeg": ISOPHOTE_DEG,
        "zebra": ZEBRA,
        "smoothDeg": SMOOTH_DEG,
    }


def scene_data(scene: Scene, number: int) -> dict[str, Any]:
    """Return what the viewer of a scene reads; its surfaces are in elements of their own."""
    return {
        "view": dict(scene.view),
        "scales": {name: list(limits) for name, limits in scene.scales.items()},
        "surfaces": [
            {"scheme": card.scheme, "data": data_id(number, place), "extremes": dict(card.extremes)}
            | dict(card.about or {})
            for place, card in enumerate(scene.shown)
        ],
    }


def data_id(scene: int, card: int) -> str:
    """Return the id of the element that holds a surface."""
    return f"surface-{scene}-{card}"


def run_data(page: Page) -> dict[str, Any]:
    """Return what commands are made of: schemes, datasets with their levels and schemes, the run's own command."""
    return {
        "command": page.command,
        "schemes": list(page.schemes),
        "datasets": [
            {"spec": section.dataset.spec, "levels": list(section.planned), "schemes": list(section.schemes)}
            for section in page.sections
        ],
    }


def gradient(style: Style = STILL, stops: int = 17) -> str:
    """Return a style's colours as stops of a gradient."""
    colours = np.rint(palette(style, stops) * 255.0).astype(int)
    return ", ".join(f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in colours)


def legend(scene: Scene) -> tuple[str, str] | None:
    """Return the limits of a scene's still pictures as text; None where they have no values."""
    limits = scene.scales.get(STILL)
    return None if limits is None else (f"{limits[0]:.3g}".replace("-", "\N{MINUS SIGN}"), f"{limits[1]:.3g}")
