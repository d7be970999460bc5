"""Offsets: against 40 digits and closed forms, back to the base, and as far as the focal distance and no farther."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from testbed.errors import SpecError
from testbed.geometry.charted import Charts
from testbed.geometry.charted_surface import ChartedSurface
from testbed.geometry.curvature import principal, second_form_matrix
from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, dot, norm, unit
from testbed_datasets.bicubic_spline import PARTIALS, BicubicSpline
from testbed_datasets.offset import BASE, CERTAINLY_REGULAR, Offset, check_focal_distance, principal_range
from testbed_datasets.offset_charts import OffsetSpline, Parametrised, offset_form, offset_jet

KNOTS = [0, 0, 0, 0, 1, 2, 3, 3, 3, 3]
DISTANCES = [0.35, -0.4]


def parameters(count: int, seed: int = 0) -> Float:
    return np.random.default_rng(seed).uniform(0.0, 3.0, (count, 2))


def many_jets(charts: Charts, at: Float, order: int = 2) -> Jet:
    return charts.jets(np.zeros(len(at), dtype=np.int64), at, order)


# The offset in 60 digits, straight from its definition.

Vector = tuple[Decimal, Decimal, Decimal]


def basis(t: Decimal) -> list[Decimal]:
    """The six cubic B-splines at t in [0, 3), by Cox's and de Boor's recursion."""
    values = [Decimal(int(KNOTS[k] <= t < KNOTS[k + 1])) for k in range(len(KNOTS) - 1)]
    for degree in (1, 2, 3):
        raised = []
        for k in range(len(values) - 1):
            left, right = KNOTS[k + degree] - KNOTS[k], KNOTS[k + degree + 1] - KNOTS[k + 1]
            term = (t - KNOTS[k]) * values[k] / left if left else Decimal(0)
            raised.append(term + ((KNOTS[k + degree + 1] - t) * values[k + 1] / right if right else Decimal(0)))
        values = raised
    return values


def spline_point(u: Decimal, v: Decimal) -> Vector:
    along_u, along_v = basis(u), basis(v)
    # the control points are multiples of a tenth
    tenths = np.rint(10.0 * np.array(BASE.control_points)).astype(int).tolist()
    x, y, z = (
        sum((along_u[i] * along_v[j] * tenths[i][j][k] / 10 for i in range(6) for j in range(6)), start=Decimal(0))
        for k in range(3)
    )
    return x, y, z


def difference(function: Callable[[Decimal, Decimal], Vector], along_u: int, along_v: int) -> Callable[..., Vector]:
    """Central differences of a function, of an order along u and v; errors are about 1e-24."""
    if along_u + along_v == 0:
        return function
    h = Decimal(10) ** -12
    du, dv = (h, Decimal(0)) if along_u else (Decimal(0), h)
    lower = difference(function, along_u - bool(along_u), along_v if along_u else along_v - 1)

    def central(u: Decimal, v: Decimal) -> Vector:
        ahead, behind = lower(u + du, v + dv), lower(u - du, v - dv)
        x, y, z = ((a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True))
        return x, y, z

    return central


def offset_point(distance: Decimal) -> Callable[[Decimal, Decimal], Vector]:
    def point(u: Decimal, v: Decimal) -> Vector:
        (a, b, c), (d, e, f) = difference(spline_point, 1, 0)(u, v), difference(spline_point, 0, 1)(u, v)
        n = (b * f - c * e, c * d - a * f, a * e - b * d)
        length = sum((x * x for x in n), start=Decimal(0)).sqrt()
        x, y, z = (s + distance * x / length for s, x in zip(spline_point(u, v), n, strict=True))
        return x, y, z

    return point


@pytest.mark.parametrize("distance", DISTANCES)
def test_derivatives_against_forty_digits(distance: float) -> None:
    at = parameters(4, seed=5)
    jet = many_jets(OffsetSpline(BASE, distance), at)
    with localcontext() as context:
        context.prec = 90
        point = offset_point(Decimal(repr(distance)))
        for row, (along_u, along_v) in zip(jet.coefficients, PARTIALS, strict=False):
            derivative = difference(point, along_u, along_v)
            exact = np.array([derivative(Decimal(float(u)), Decimal(float(v))) for u, v in at]).astype(np.float64)
            assert np.abs(row - exact).max() < 5e-15 * max(1.0, np.abs(exact).max())


def test_spline_against_another_evaluation() -> None:
    reference = NdBSpline((np.array(KNOTS, float), np.array(KNOTS, float)), np.array(BASE.control_points), 3)
    at = np.concatenate([parameters(300), [[0.0, 0.0], [1.0, 2.0], [2.0, 0.5], [3.0, 3.0], [0.0, 3.0]]])
    for row, orders in zip(BASE.jet(at, 3), PARTIALS, strict=True):
        assert np.abs(row - reference(at, nu=orders)).max() < 1e-13


def test_spline_patches_join_with_two_derivatives_and_go_on_beyond() -> None:
    nets = BASE.patches()
    for cells in (nets, nets.transpose(1, 0, 3, 2, 4)):
        left, right = cells[:-1], cells[1:]
        for order in range(3):
            ahead = np.diff(left, n=order, axis=2)[:, :, -1]
            assert np.abs(ahead - np.diff(right, n=order, axis=2)[:, :, 0]).max() < 1e-14
        assert np.abs(np.diff(left, n=3, axis=2)[:, :, -1] - np.diff(right, n=3, axis=2)[:, :, 0]).max() > 0.1
    inside, beyond = BASE.jet(np.array([[0.0, 1.3], [3.0, 3.0]]), 3), BASE.jet(np.array([[-0.2, 1.3], [3.2, 3.0]]), 1)
    step = np.array([[-0.2], [0.2]])
    taylor = inside[0] + step * inside[1] + step**2 / 2.0 * inside[3] + step**3 / 6.0 * inside[6]
    assert norm(beyond[0] - taylor).max() < 1e-14


@dataclass(frozen=True)
class Sphere:
    """A sphere by longitude and latitude."""

    radius: float

    def jet(self, at: Float, order: int) -> Float:
        u, v = at.T
        rows = []
        for r, s in PARTIALS[: (1, 3, 6, 10)[order]]:
            across = np.cos(v + 0.5 * np.pi * s)
            up = np.sin(v + 0.5 * np.pi * s) if r == 0 else 0.0 * v
            rows.append(np.stack([across * np.cos(u + 0.5 * np.pi * r), across * np.sin(u + 0.5 * np.pi * r), up], -1))
        return self.radius * np.stack(rows)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about the z axis, normals outward, its parametrisation askew."""

    radius: float

    def jet(self, at: Float, order: int) -> Float:
        u, v = at.T
        rows = []
        for r, s in PARTIALS[: (1, 3, 6, 10)[order]]:
            angle = u + 2.0 * v + 0.5 * np.pi * (r + s)
            height = (v - u, -1.0 + 0.0 * u, 1.0 + 0.0 * u)[0 if r + s == 0 else 1 + s] if r + s < 2 else 0.0 * u
            rows.append(np.stack([2.0**s * np.cos(angle), 2.0**s * np.sin(angle), height / self.radius], axis=-1))
        return self.radius * np.stack(rows)


@pytest.mark.parametrize("distance", [0.5, -0.7, 3.0])
@pytest.mark.parametrize(("base", "other"), [(Sphere(2.0), Sphere), (Cylinder(2.0), Cylinder)])
def test_offsets_of_spheres_and_cylinders_are_such(
    base: Parametrised, other: Callable[[float], Parametrised], distance: float
) -> None:
    at = np.random.default_rng(1).uniform(-1.2, 1.2, (50, 2))
    jet, expected = offset_jet(base, distance, at), Jet(other(2.0 + distance).jet(at, 2))
    if isinstance(base, Cylinder):  # it becomes thicker, not longer
        height = base.jet(at, 2)[:, :, 2]
        expected.coefficients[..., 2] = height
    assert np.abs(jet.coefficients - expected.coefficients).max() < 5e-15 * np.abs(expected.coefficients).max()
    W = second_form_matrix(Jet(base.jet(at, 2)))
    assert np.abs(offset_form(W, distance) - second_form_matrix(expected)).max() < 1e-14


def test_the_offset_of_a_plane_is_the_plane_moved() -> None:
    grid = tuple(
        tuple((float(i), j + 0.2 * i**2, 0.5 * i - 0.3 * (j + 0.2 * i**2)) for j in range(5)) for i in range(5)
    )
    plane, at = BicubicSpline(grid), parameters(40) / 1.5
    normal = unit(np.array([-0.5, 0.3, 1.0]))
    jet = offset_jet(plane, 1.7, at)
    assert norm(jet.f - plane.jet(at, 0)[0] - 1.7 * normal).max() < 1e-14
    assert np.abs(jet.coefficients[1:] - plane.jet(at, 2)[1:]).max() < 1e-13


@pytest.mark.parametrize("distance", [*DISTANCES, -0.6, 0.9])
def test_offsetting_back_gives_the_base(distance: float) -> None:
    at = parameters(500)
    jet, base = many_jets(OffsetSpline(BASE, distance), at), Jet(BASE.jet(at, 2))
    assert norm(jet.normal - base.normal).max() < 1e-13
    assert norm(jet.f - distance * jet.normal - base.f).max() < 1e-13
    W, before = second_form_matrix(jet), second_form_matrix(base)
    assert np.abs(offset_form(before, distance) - W).max() < 1e-12 * np.abs(W).max()
    assert np.abs(offset_form(W, -distance) - before).max() < 1e-11
    for k, k_before in zip(principal(jet), principal(base), strict=True):
        assert np.abs(k - k_before / (1.0 + distance * k_before)).max() < 1e-11 * (1.0 + np.abs(k).max())


@pytest.mark.parametrize("distance", DISTANCES)
def test_feet_beat_a_dense_sampling(distance: float) -> None:
    surface = Offset(distance=distance).surface
    grid = np.linspace(-0.25, 3.25, 351)
    at = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    everywhere = surface.charts.jets(np.zeros(len(at), dtype=np.int64), at, 0).f
    # near the surface and far from it, beyond its centres of curvature too
    random = np.random.default_rng(2)
    points = random.uniform([-1.0, -1.0, -2.0], [6.0, 6.0, 3.0], (150, 3))
    found = surface.locate(points)
    distances = norm(found.points - points)
    sampled = np.concatenate([norm(everywhere[None] - some[:, None]).min(axis=1) for some in np.split(points, 15)])
    assert (distances <= sampled + 1e-13).all()
    assert (sampled - distances < 0.02).all()
    inside = ~found.on_side
    off = unit(points - found.points) - unit(dot(points - found.points, n := surface.normal(found.points))[:, None] * n)
    assert norm(off)[inside & (distances > 1e-3)].max() < 1e-9


def test_a_foot_of_the_offset_lies_over_the_foot_on_the_base() -> None:
    # points on a common normal have a common foot's parameters
    base, offset = ChartedSurface(OffsetSpline(BASE, 0.0)), Offset().surface
    points = base.charts.jets(np.zeros(300, dtype=np.int64), parameters(300), 0).f
    points = points + 0.2 * base.normal(points)
    assert np.abs(base.locate(points).at - offset.locate(points).at).max() < 1e-13


def test_the_extreme_curvatures_of_the_base() -> None:
    extremes = principal_range(BASE)
    assert extremes.lowest.value == pytest.approx(-1.0796186921, abs=1e-9)
    assert extremes.highest.value == pytest.approx(1.5609280843, abs=1e-9)
    k_max, k_min = principal(Jet(BASE.jet(parameters(100_000), 2)))
    assert (
        extremes.lowest.value - 2e-5
        < extremes.low
        < extremes.lowest.value
        <= k_min.min()
        < extremes.lowest.value + 1e-3
    )
    assert k_max.max() <= extremes.highest.value < extremes.high < extremes.highest.value * (1.0 + 1.1e-5)
    assert -1.0 / extremes.high < CERTAINLY_REGULAR[0]
    assert CERTAINLY_REGULAR[1] < -1.0 / extremes.low


@pytest.mark.parametrize("distance", [-0.641, -5.0, 0.927, 40.0])
def test_distances_beyond_focal_ones_are_refused_with_the_place(distance: float) -> None:
    with pytest.raises(SpecError, match=r"^parameter distance of offset cannot be ") as caught:
        Offset(distance=distance)
    message = str(caught.value)
    numbers = re.search(r"in patch \((\d), (\d)\) at \(u, v\) = \(([\d.]+), ([\d.]+)\).* from (\S+) to (\S+)$", message)
    assert numbers is not None
    i, j, u, v, low, high = map(float, numbers.groups())
    k = np.array(principal(Jet(BASE.jet(np.array([[i + u, j + v]]), 2))))
    assert (1.0 + distance * k).min() < 0.0
    for allowed, refused in ((low, low - 1e-4), (high, high + 1e-4)):
        assert Offset(distance=allowed).distance == allowed
        with pytest.raises(SpecError):
            Offset(distance=refused)


def test_surfaces_that_bend_one_way_have_one_focal_distance() -> None:
    bowl = BicubicSpline(tuple(tuple((float(i), float(j), 0.1 * (i * i + j * j)) for j in range(4)) for i in range(4)))
    check_focal_distance("bowl", bowl, -100.0)
    with pytest.raises(SpecError, match=r"distance from -infinity to "):
        check_focal_distance("bowl", bowl, 100.0)


@pytest.mark.parametrize("cells", [0, -3, 65])
def test_numbers_of_cells_that_make_no_mesh(cells: int) -> None:
    with pytest.raises(SpecError, match=r"^parameter cells of offset cannot be "):
        Offset(cells=cells)


@pytest.mark.parametrize(("cells", "vertices", "faces"), [(3, 16, 18), (1, 4, 2), (2, 9, 8)])
def test_start_meshes(cells: int, vertices: int, faces: int) -> None:
    dataset = Offset(cells=cells)
    mesh = dataset.mesh(0)
    assert (len(mesh.points), len(mesh.faces)) == (vertices, faces)
    charted = dataset.charted()
    assert charted.followed.sum() == 4 * cells
    edges = mesh.boundary_edges[mesh.face_edges]
    assert np.array_equal(edges, charted.followed)


def test_faces_stay_in_the_patches_of_the_spline() -> None:
    at = Offset().charted().halved(2).at
    low, high = at.min(axis=1), at.max(axis=1)
    assert np.array_equal(np.minimum(np.floor(low), 2.0), np.ceil(high) - 1.0)


@pytest.mark.parametrize("level", [0, 2])
def test_given_tangents_are_those_of_the_boundary_curves(level: int) -> None:
    charted = Offset().charted().halved(level)
    mesh = charted.sampled()
    tangents = mesh.face_data.side_tangents
    assert tangents is not None
    face, side = np.nonzero(charted.followed)
    start, end = charted.at[face, side], charted.at[face, (side + 1) % 3]
    # exactly one parameter runs along the side; the curve's own differences, without the chart's derivatives, and to
    # one side, because second derivatives jump at the knots
    assert np.array_equal((start == end).sum(axis=1), np.ones(len(face)))
    assert np.isnan(tangents[~charted.followed]).all()
    h = 1e-3 * (end - start)
    for which, at, inward in ((0, start, h), (1, end, -h)):
        points = [charted.charts.jets(charted.chart[face], at + k * inward, 0).f for k in range(5)]
        slope = sum(
            (w * x for w, x in zip((-25, 48, -36, 16, -3), points, strict=True)), start=np.zeros_like(points[0])
        )
        forward = slope if which == 0 else -slope
        assert norm(unit(forward) - tangents[face, side, which]).max() < 1e-10


def test_curvature_is_continuous_across_knots_and_second_derivatives_are_not() -> None:
    charts, t = OffsetSpline(BASE, 0.35), parameters(50)[:, 0]
    for knot in (1.0, 2.0):
        before, after = (many_jets(charts, np.stack([np.full(50, at), t], axis=-1)) for at in (knot - 1e-14, knot))
        assert np.abs(second_form_matrix(before) - second_form_matrix(after)).max() < 1e-12
        assert norm(before.fuu - after.fuu).max() > 0.01


@pytest.mark.parametrize("distance", [0.35, -0.6])
def test_curvature_bounds_hold_in_boxes(distance: float) -> None:
    surface = Offset(distance=distance).surface
    at = parameters(20_000, seed=9) * (3.5 / 3.0) - 0.25
    jet = surface.charts.jets(np.zeros(len(at), dtype=np.int64), at)
    curvature = np.abs(np.array(principal(jet))).max(axis=0)
    # boxes about single points, and one about everything
    bounds = surface.curvature_bound(jet.f, jet.f)
    assert (bounds >= curvature).all()
    assert np.median(bounds / curvature) < 2.0
    whole = surface.curvature_bound(jet.f.min(axis=0)[None], jet.f.max(axis=0)[None])
    assert curvature.max() <= whole[0] < 1.3 * curvature.max()
    assert surface.curvature_bound(np.full((1, 3), 50.0), np.full((1, 3), 51.0))[0] == 0.0


def test_the_surface_ends_at_the_sides_of_its_polygon_only() -> None:
    surface = Offset().surface
    t = np.linspace(-0.25, 3.25, 200)
    low, high = np.full(200, -0.25), np.full(200, 3.25)
    rim = np.concatenate([np.stack(side, axis=-1) for side in ((t, low), (t, high), (low, t), (high, t))])
    on_rim = many_jets(surface.charts, rim, 0).f
    assert surface.may_end(on_rim, on_rim).all()
    # not on the mesh, nor a little around it
    inside = many_jets(surface.charts, parameters(500), 0).f
    assert not surface.may_end(inside, inside).any()
    assert surface.may_end(inside - 0.05, inside + 0.05).mean() < 0.1
