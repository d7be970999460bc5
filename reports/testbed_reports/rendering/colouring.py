"""Colourings of surfaces: shading, curvature and distance maps, isophotes, reflection lines, patches."""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, get_args

import numpy as np

from testbed.geometry.vectors import Float, Int, dot, unit
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.fields import Fields
from testbed_reports.rendering.visibility import Sights

Style: TypeAlias = Literal["shaded", "patches", "gauss", "mean", "distance", "isophotes", "zebra", "thesis", "jump"]
STYLES: Final[tuple[Style, ...]] = get_args(Style)

#: Which styles show curvature, which need the exact surface, which vary within a pixel.
CURVED: Final = ("gauss", "mean", "thesis")
EXACT: Final = ("distance",)
STRIPED: Final = ("isophotes", "zebra", "gauss", "mean", "distance")
#: What a style's numbers are, with the unit.
LABELS: Final = {
    "gauss": "Gaussian curvature K (1/length²)",
    "mean": "mean curvature H (1/length)",
    "distance": "distance from the exact surface (length)",
    "thesis": "Gaussian curvature K (1/length²)",
}
#: Limits of the thesis's colouring: red above, green at zero, blue below.
THESIS_LIMIT: Final = 4.0
#: Colours: of the outer and of the inner side, of places without a value, of the background.
OUTER: Final = np.array([0.78, 0.82, 0.88])
INNER: Final = np.array([0.86, 0.72, 0.52])
MISSING: Final = np.array([1.0, 0.0, 1.0])
BACKGROUND: Final = np.array([1.0, 1.0, 1.0])
#: Colours of surfaces whose edges matter, and of the dark and the light bands of isophotes and reflection lines.
PALE: Final = np.array([0.93, 0.93, 0.94])
BANDS: Final = np.array([[0.13, 0.15, 0.2], [0.88, 0.89, 0.9]])
#: The light is above the viewer's left shoulder: so much to the right, upwards and towards the viewer.
LIGHT: Final = (-0.45, 0.55, 0.75)
#: Faces and what lies beside them in turn, after Okabe and Ito: light enough to be shaded.
PATCHES: Final = np.array([[0.55, 0.75, 0.92], [0.98, 0.78, 0.42], [0.60, 0.83, 0.70], [0.90, 0.68, 0.80]])
#: matplotlib's colour maps: zero is grey on the diverging one, small is light on the others.
PALETTES: Final = {"gauss": "coolwarm", "mean": "coolwarm", "jump": "plasma_r"}
#: Degrees between isophotes; stripes of the reflected surroundings from pole to pole.
ISOPHOTE_DEG: Final = 10.0
ZEBRA: Final = 18
#: Pixels between the lines that mark values beyond the limits.
HATCH: Final = 6


@dataclass(frozen=True)
class Scale:
    """What the colours of a map mean.

    Parameters
    ----------
    low, high
        Limits; values beyond them have the colour of the limit, and lines across.
    """

    low: float
    high: float

    @classmethod
    def of(cls, style: Style, values: Float) -> "Scale":
        """Return the scale that suits all pictures with these values together: round limits, symmetric for curvature.

        Curvature is cut at what 98 of 100 pixels do not exceed, so that peaks at single points leave the rest visible.
        """
        known = values[np.isfinite(values)]
        if style == "thesis":
            return cls(-THESIS_LIMIT, THESIS_LIMIT)
        if not len(known):
            return cls(-1.0 if style in CURVED else 0.0, 1.0)
        limit = rounded_up(float(np.quantile(np.abs(known), 0.98 if style in CURVED else 1.0)))
        return cls(-limit if style in CURVED else 0.0, limit)


def rounded_up(value: float) -> float:
    """Return the least of 1, 1.5, 2, 3, 5, 7 times a power of ten that is not below; 1 for zero."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0]) * power
    return float(steps[np.searchsorted(steps, value * (1.0 - 1e-12))])


def mapped(style: Style, fields: Fields) -> Float:
    """Values (N,) that a map shows."""
    return {"gauss": fields.gauss, "thesis": fields.gauss, "mean": fields.mean, "distance": fields.distance}[style]


def palette(style: Style, count: int = 256) -> Float:
    """Colours (count, 3) from the low to the high limit of a map."""
    t = np.linspace(0.0, 1.0, count)
    if style == "thesis":
        return np.stack([(2.0 * t - 1.0).clip(0, 1), 1.0 - np.abs(2.0 * t - 1.0), (1.0 - 2.0 * t).clip(0, 1)], axis=-1)
    import matplotlib as mpl

    colours: Float = np.asarray(mpl.colormaps[PALETTES.get(style, "viridis_r")](t)[:, :3])
    return colours


def coloured(
    style: Style,
    fields: Fields,
    sights: Sights,
    camera: Camera,
    scale: Scale,
    group: Int,
    base: Float | None = None,
) -> Float:
    """Colours (N, 3), from 0 to 1, of the places that a picture looks at.

    Parameters
    ----------
    group
        (N,) whole numbers that tell the colours of ``patches`` apart.
    base
        (N, 3) colours to be shaded in place of the usual ones, the same on both sides of the surface; for styles that
        shade.
    """
    towards = camera.towards
    facing = dot(fields.normals, towards)
    # seen from behind a surface shows its inner side
    normals = fields.normals * np.where(facing < 0.0, -1.0, 1.0)[:, None]
    if style in LABELS:
        colours = _map(style, mapped(style, fields), scale, sights, camera, normals)
    elif style == "isophotes":
        light = _light(camera)
        angle = np.degrees(np.arccos(np.clip(dot(normals, light), -1.0, 1.0)))
        colours = _bands(angle / ISOPHOTE_DEG, facing)
    elif style == "zebra":
        reflected = 2.0 * dot(normals, towards)[:, None] * normals - towards
        height = np.arcsin(np.clip(dot(reflected, np.array(camera.axes[1])), -1.0, 1.0)) / np.pi
        colours = _bands(ZEBRA * (height + 0.5), facing)
    else:
        outer = PATCHES[group % len(PATCHES)] if style == "patches" else PALE if style == "jump" else OUTER
        if base is None:
            colours = _shaded(np.where((facing < 0.0)[:, None], INNER, outer), normals, camera)
        else:
            # colours that mean something are to be told apart in the shade too
            colours = base * (0.66 + 0.34 * dot(normals, _light(camera)).clip(0.0))[:, None]
    known: Float = np.where(np.isfinite(colours).all(axis=-1, keepdims=True), colours, MISSING)
    return known


def _light(camera: Camera) -> Float:
    """Direction to the light in space."""
    right, up, towards = (share * np.array(axis) for share, axis in zip(LIGHT, camera.axes, strict=True))
    return unit(towards + up + right)


def _shaded(base: Float, normals: Float, camera: Camera, gloss: float = 0.25) -> Float:
    """Lambert's diffuse and Blinn's specular reflection of one light, and some light from everywhere."""
    light = _light(camera)
    diffuse = dot(normals, light).clip(0.0)
    shine = dot(normals, unit(light + camera.towards)).clip(0.0) ** 40
    colours: Float = (base * (0.32 + 0.72 * diffuse)[:, None] + gloss * shine[:, None]).clip(0.0, 1.0)
    return colours


def _map(style: Style, values: Float, scale: Scale, sights: Sights, camera: Camera, normals: Float) -> Float:
    """Colours of a map, slightly shaded; lines across what lies beyond the limits."""
    colours = palette(style)
    t = (values - scale.low) / (scale.high - scale.low)
    place = (np.nan_to_num(t, nan=0.0).clip(0.0, 1.0) * (len(colours) - 1) + 0.5).astype(np.int64)
    shown = colours[place] * (0.86 + 0.14 * dot(normals, _light(camera)).clip(0.0))[:, None]
    row, column = np.divmod(sights.pixel, sights.size)
    beyond = (t < -1e-9) | (t > 1.0 + 1e-9)
    shown = np.where((beyond & ((row + column) % HATCH == 0))[:, None], 0.35 * shown, shown)
    return np.where(np.isnan(values)[:, None], np.nan, shown)


def _bands(phase: Float, facing: Float) -> Float:
    """Dark and light bands, a period each two units of the phase; of the inner side's colour seen from behind."""
    dark = np.floor(phase).astype(np.float64) % 2.0 == 0.0
    light = np.where((facing < 0.0)[:, None], INNER, BANDS[1])
    colours = np.where(dark[:, None], BANDS[0], light)
    return np.where(np.isnan(phase)[:, None], np.nan, colours)
