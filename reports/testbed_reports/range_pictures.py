"""Pictures of surfaces over data above a plane: heights in one scale, what lies below, and sections near the plane."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, get_args

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed.plugins.dataset import Dataset
from testbed_reports.formatting import shorten
from testbed_reports.plots import SETTINGS
from testbed_reports.range_comparison import Uses
from testbed_reports.range_sections import BELOW, SECTIONS, PlaneView, draw_sections
from testbed_reports.range_tables import SMOOTH_DEG, RangeRow
from testbed_reports.rendering.camera import MARGIN, Camera
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.fields import fields
from testbed_reports.rendering.visibility import Sights, rasterise, sights

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Pixels along a side of a picture, and dots an inch.
SIZE: Final = 230
DPI: Final = 110
#: Pictures in a row.
COLUMNS: Final = 6
#: Inches above a picture and beside the last of a row.
ABOVE: Final = 0.5
BESIDE: Final = 0.95
#: Heights go from light to dark blue; what lies below the plane is orange and striped: apart without colour vision too.
HEIGHTS: Final = "GnBu"
RANGE: Final = (0.12, 1.0)
STRIPES: Final = 5
#: Below the plane by less than this part of the scale is on it.
ON_PLANE: Final = 1e-9
#: Share of the light that does not depend on the direction of the surface.
AMBIENT: Final = 0.78
#: Titles of more letters are smaller.
LONG: Final = 24
#: Curves of equal height, from the plane to the top of the scale.
CONTOURS: Final = 10
#: The truth is drawn on a mesh so many levels finer, of so many faces at most.
REFINED: Final = 4
MOST_FACES: Final = 20_000


@dataclass(frozen=True, eq=False)
class _Seen:
    """What the pixels of a picture look at, with signed distances from the plane (N,) and normals (N, 3)."""

    sights: Sights
    distance: Float
    normals: Float


def views_of(
    rows: Sequence[RangeRow], surfaces: Mapping[str, Surface], dataset: Dataset, level: int
) -> tuple[PlaneView, ...]:
    """Return the surfaces of a set to be drawn, with what was measured on them, and the truth where it is known."""
    views = []
    groups = [[row.label for row in rows if row.uses == uses] for uses in get_args(Uses)]
    places = {label: number for group in groups for number, label in enumerate(group)}
    for row in rows:
        if row.label in surfaces:
            remarks = [f"lowest {shorten(row.lowest)}"]
            remarks += [f"edges {shorten(row.epsilon_deg)}°"] if row.epsilon_deg > SMOOTH_DEG else []
            remarks += [f"creases {shorten(row.crease_deg)}°"] if row.crease_deg > 0.0 else []
            views.append(PlaneView(row.label, ", ".join(remarks), surfaces[row.label], row.uses, places[row.label]))
    mesh = None if dataset.surface is None else _finest(dataset, level)
    if mesh is not None:
        flat = Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()))
        views.append(PlaneView("the truth", f"by {len(mesh.faces)} flat faces", flat, views[-1].group, truth=True))
    return tuple(views)


def _finest(dataset: Dataset, level: int) -> HermiteMesh | None:
    """Return the finest mesh of triangles that shows an exact surface well, None if there is none."""
    mesh = None
    for finer in range(level + 1, level + REFINED + 1):
        try:
            candidate = dataset.mesh(finer)
        except Refused:
            break
        if candidate.sides != 3 or len(candidate.faces) > MOST_FACES:
            break
        mesh = candidate
    return mesh


def draw_set(views: Sequence[PlaneView], plane: tuple[float, ...], title: str) -> bytes:
    """Return a PNG file's content: a picture of each surface, with one scale, and two sections of all.

    Surfaces with a boundary are seen from above the plane, others from below it, where they come near.

    Parameters
    ----------
    views
        At least one, over one mesh, but for the truth.
    plane
        a, b, c, d of the plane a x + b y + c z + d = 0.
    title
        Above the figure.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    normal, offset = _normalised(plane)
    points = [facets_of(one.surface, 4000).points for one in views]
    above = bool(views[0].surface.mesh.boundary_edges.any())
    camera = _camera(np.concatenate(points), normal if above else -normal)
    seen = [_look(one.surface, camera, normal, offset) for one in views]
    # of surfaces that go astray the scale takes no notice: what is above it has its last colour
    highest = float((dot(views[0].surface.mesh.points, normal) + offset).max())
    top = 1.1 * highest if highest > 0.0 else 1.0
    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        figure = _draw(views, seen, camera, top, title, above=above)
        draw_sections(figure, views, normal, offset)
        FigureCanvasAgg(figure)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    return stream.getvalue()


def _normalised(plane: tuple[float, ...]) -> tuple[Float, float]:
    """Unit normal (3,) of a plane and what is added to the product with it."""
    length = float(norm(np.array(plane[:3])))
    return np.array(plane[:3]) / length, plane[3] / length


def _camera(points: Float, towards: Float) -> Camera:
    """Look at points (N, 3) from a direction, the x axis to the right where it can be."""
    along = np.array([1.0, 0.0, 0.0]) if abs(towards[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = unit(along - dot(along, towards) * towards)
    axes = np.stack([right, cross(towards, right), towards])
    flat = points[np.isfinite(points).all(axis=-1)] @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    centre = 0.5 * (low + high) @ axes
    width = float((high - low)[:2].max()) / (1.0 - 2.0 * MARGIN)
    rows = tuple((float(x), float(y), float(z)) for x, y, z in axes)
    return Camera(rows, (float(centre[0]), float(centre[1]), float(centre[2])), width)


def _look(surface: Surface, camera: Camera, normal: Float, offset: float) -> _Seen:
    facets = facets_of(surface)
    places = sights(facets, *rasterise(facets, camera, SIZE), every_sample=True)
    distance = np.full(len(places), np.nan)
    for index, part in enumerate(surface.parts):
        (mine,) = np.nonzero(places.part == index)
        for some in np.array_split(mine, max(1, len(mine) // 16_384)):
            at = part.batch.take(places.patch[some]).jets(places.at[some][:, None], 0).f[:, 0]
            distance[some] = dot(at, normal) + offset
    return _Seen(places, distance, fields(surface, places, curved=False).normals)


def _image(seen: _Seen, camera: Camera, top: float) -> tuple[Float, Float]:
    """Return the picture (SIZE, SIZE, 3), and the mean distance in each pixel, NaN where nothing is seen."""
    import matplotlib as mpl

    t = np.nan_to_num(seen.distance / top).clip(0.0, 1.0)
    colours = np.asarray(mpl.colormaps[HEIGHTS](RANGE[0] + (RANGE[1] - RANGE[0]) * t))[:, :3]
    row, column = np.divmod(seen.sights.pixel, SIZE)
    striped = np.where(((row + column) % STRIPES == 0)[:, None], 0.6 * np.array(BELOW), BELOW)
    colours = np.where((seen.distance < -ON_PLANE * top)[:, None], striped, colours)
    right, up, towards = (np.array(axis) for axis in camera.axes)
    light = unit(0.8 * towards + 0.5 * up - 0.5 * right)
    shade = AMBIENT + (1.0 - AMBIENT) * np.abs(np.nan_to_num(dot(seen.normals, light)))
    colours = colours * shade[:, None]
    share = np.bincount(seen.sights.pixel, weights=seen.sights.share, minlength=SIZE * SIZE)
    image = np.repeat((1.0 - share)[:, None], 3, axis=1)
    for channel in range(3):
        weights = seen.sights.share * colours[:, channel]
        image[:, channel] += np.bincount(seen.sights.pixel, weights=weights, minlength=SIZE * SIZE)
    total = np.bincount(seen.sights.pixel, weights=seen.sights.share * seen.distance, minlength=SIZE * SIZE)
    mean = total / np.where(share > 0.0, share, np.nan)
    return image.reshape(SIZE, SIZE, 3).clip(0.0, 1.0), mean.reshape(SIZE, SIZE)


def _draw(
    views: Sequence[PlaneView], seen: Sequence[_Seen], camera: Camera, top: float, title: str, *, above: bool
) -> "Figure":
    """Return the figure with the pictures, and room for the sections below them."""
    from matplotlib.figure import Figure

    places, rows = _places(views)
    side = SIZE / DPI
    width, height = COLUMNS * side + BESIDE, rows * (side + ABOVE) + SECTIONS + 0.3
    figure = Figure(figsize=(width, height))
    direction = "from above" if above else "from below the plane"
    figure.text(0.08 / width, 1 - 0.07 / height, f"{title}; seen {direction}", va="top", fontsize=9)
    for (row, column), view, one in zip(places, views, seen, strict=True):
        bottom = height - 0.3 - (row + 1) * (side + ABOVE)
        axes = figure.add_axes((column * side / width, bottom / height, side / width, side / height))
        image, distance = _image(one, camera, top)
        axes.imshow(image, extent=(0, SIZE, SIZE, 0), interpolation="none")
        _contours(axes, distance, top)
        _vertices(axes, views[0].surface, camera)
        axes.set_xlim(0, SIZE)
        axes.set_ylim(SIZE, 0)
        axes.set_axis_off()
        middle, over = (column + 0.5) * side / width, bottom + side
        figure.text(
            middle,
            (over + 0.2) / height,
            view.title,
            ha="center",
            fontsize=8.5 if len(view.title) < LONG else 7.0,
            weight="bold",
        )
        figure.text(middle, (over + 0.04) / height, view.remark, ha="center", fontsize=7.5)
    _bar(
        figure,
        top,
        ((1 + max(column for _, column in places)) * side + 0.2) / width,
        (height - 0.3 - ABOVE - side) / height,
        side / height,
    )
    return figure


def _places(views: Sequence[PlaneView]) -> tuple[list[tuple[int, int]], int]:
    """Return row and column of each picture, a new row for each group, and the number of rows."""
    places: list[tuple[int, int]] = []
    for number, view in enumerate(views):
        row, column = places[-1] if places else (0, -1)
        begins = number > 0 and view.group != views[number - 1].group
        places.append((row + 1, 0) if begins or column + 1 == COLUMNS else (row, column + 1))
    return places, places[-1][0] + 1


def _contours(axes: "Axes", distance: Float, top: float) -> None:
    """Draw curves of equal height, and the one where the surface crosses the plane."""
    middles = np.arange(SIZE) + 0.5
    known = distance[np.isfinite(distance)]
    if not len(known):
        return
    low, high = float(known.min()), float(known.max())
    levels = [level for level in np.arange(1, CONTOURS) * top / CONTOURS if low < level < high]
    if levels:
        axes.contour(middles, middles, distance, levels=levels, colors="#ffffff", linewidths=0.45, alpha=0.8)
    if low < -ON_PLANE * top < high:
        axes.contour(
            middles, middles, distance, levels=[-ON_PLANE * top], colors="#000000", linewidths=0.9, linestyles="solid"
        )


def _vertices(axes: "Axes", surface: Surface, camera: Camera) -> None:
    """Draw the vertices of the mesh that are on the viewer's half."""
    at = camera.screen(surface.mesh.points, SIZE)
    near = at[:, 2] >= (-0.05 * SIZE if not surface.mesh.boundary_edges.any() else -np.inf)
    axes.plot(at[near, 0], at[near, 1], ".", color="#222222", markersize=1.8, markeredgewidth=0.0)


def _bar(figure: "Figure", top: float, left: float, bottom: float, tall: float) -> None:
    """Draw the scale: heights, and the colour of what lies below the plane."""
    import matplotlib as mpl

    axes = figure.add_axes((left, bottom + 0.1 * tall, 0.012, 0.8 * tall))
    heights = np.asarray(mpl.colormaps[HEIGHTS](np.linspace(RANGE[1], RANGE[0], 256)))[:, None, :3]
    axes.imshow(heights, extent=(0, 1, 0.0, top), aspect="auto", interpolation="nearest")
    axes.axhspan(-0.12 * top, 0.0, color=BELOW, linewidth=0)
    axes.axhline(0.0, color="#000000", linewidth=0.9)
    axes.set_ylim(-0.12 * top, top)
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.set_yticks([0.0, 0.5 * top, top], ["0", f"{0.5 * top:.2g}", f"{top:.2g}"])
    axes.tick_params(labelsize=7)
    axes.set_ylabel("distance from the plane", fontsize=7)
    axes.set_xlabel("below", fontsize=7)
