"""Every registered dataset: meshes on the surface, oriented, halving; normals, second forms and feet that check out."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.charted_surface import ChartedSurface
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, angle_between, cross, dot, norm, quadratic_form, tangential, unit
from testbed.plugins.dataset import Dataset

EVERYTHING = sorted(registry.catalogue(Dataset))  # type: ignore[type-abstract]
#: Sampled from an exact surface: with the default parameters, and where parameters change the character, with others.
SPECS = [spec for spec in EVERYTHING if registry.dataset(spec).surface is not None]
WITHOUT_SURFACE = [spec for spec in EVERYTHING if spec not in SPECS]
VARIANTS = [
    *("octahedron[radius=3]", "torus[phase=0]", "torus[major=2,minor=1.9,phase=0.4]", "ellipsoid[a=3,b=0.5,c=1]"),
    *("ellipsoid[a=1,b=1,c=1]", "ellipsoid[a=2,b=2,c=0.3]", "hyperboloid[a=1,b=1,c=1]", "hyperboloid[a=0.3,b=2,c=5]"),
    *("offset[distance=-0.4]", "offset[cells=1]"),
    *("graph[height=3,bowl=0]", "graph[height=0,bowl=0]", "monkey-saddle[height=0.2]"),
    *("quad-torus[twist=1]", "quad-torus[phase=0]", "quad-sphere[crooked=0]", "quad-graph[height=3,bowl=0]"),
]
#: The ring's patches with six sides are long, and level 0 joins their corners to the middle; the spline's parameter
#: lines, which the offset's triangles follow, are slanted; scattered sites are steep.
SHARPEST_DEG = {"ring": 10.0, "offset": 17.0, "scattered": 11.0}
every_dataset = pytest.mark.parametrize("spec", SPECS)
every_variant = pytest.mark.parametrize("spec", SPECS + VARIANTS)


@cache
def mesh_of(spec: str, level: int) -> HermiteMesh:
    return registry.dataset(spec).mesh(level)


def surface_of(spec: str) -> ExactSurface:
    surface = registry.dataset(spec).surface
    assert surface is not None
    return surface


def normals_of(mesh: HermiteMesh) -> Float:
    assert mesh.normals is not None
    return mesh.normals


def second_forms_of(mesh: HermiteMesh) -> Float:
    assert mesh.second_forms is not None
    return mesh.second_forms


def size(mesh: HermiteMesh) -> float:
    return float(np.ptp(mesh.points, axis=0).max())


def gauss(W: Float) -> Float:
    """Product of the two principal curvatures: the second elementary symmetric function of W's eigenvalues."""
    trace = np.trace(W, axis1=-2, axis2=-1)
    curvature: Float = 0.5 * (trace**2 - np.einsum("nij,nji->n", W, W))
    return curvature


def smooth(mesh: HermiteMesh) -> Bool:
    """(V,) false on curves to follow, where a surface ends or has other second forms on either side."""
    result = np.ones(len(mesh.points), dtype=np.bool_)
    tangents = mesh.face_data.side_tangents
    if tangents is not None:
        followed = ~np.isnan(tangents).any(axis=(2, 3))
        result[mesh.faces[followed]] = False
        result[np.roll(mesh.faces, -1, axis=1)[followed]] = False
    return result


def beyond_rim(surface: ExactSurface, points: Float) -> Bool:
    """(N,) true for points whose nearest point may be one of the rim, where a surface in charts ends."""
    if not isinstance(surface, ChartedSurface):
        return np.zeros(len(points), dtype=np.bool_)
    return surface.locate(points).on_side


def face_normals(mesh: HermiteMesh) -> Float:
    corners = mesh.corner_points()
    # of quadrilaterals the mean normal, half the product of the diagonals
    first, second = (corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if mesh.sides == 4:
        first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    normals: Float = 0.5 * cross(first, second)
    return normals


def scattered(mesh: HermiteMesh, distance: float, count: int = 4000) -> Float:
    """Points near the surface, at up to a distance relative to the mesh's size."""
    random = np.random.default_rng(7)
    weights = random.dirichlet(np.ones(mesh.sides), count)
    face = random.integers(len(mesh.faces), size=count)
    inside: Float = np.einsum("nc,nci->ni", weights, mesh.corner_points()[face])
    return inside + distance * size(mesh) * random.uniform(-1.0, 1.0, (count, 3))


@every_variant
def test_its_text_names_it(spec: str) -> None:
    dataset = registry.dataset(spec)
    assert registry.dataset(str(dataset)) == dataset


@pytest.mark.parametrize("spec", WITHOUT_SURFACE)
def test_without_an_exact_surface_every_level_is_a_mesh_or_refused(spec: str) -> None:
    dataset = registry.dataset(spec)
    for level in range(dataset.finest + 1):
        mesh, again = dataset.mesh(level), registry.dataset(spec).mesh(level)
        assert np.array_equal(mesh.points, again.points)
        assert np.array_equal(mesh.faces, again.faces)
        assert dataset.closed is None or dataset.closed is not bool(mesh.boundary_edges.any())
        if mesh.normals is not None:
            towards = dot(face_normals(mesh)[:, None, :], mesh.normals[mesh.faces])
            assert (towards > 0.0).mean() > 0.99
    for level in (-1, 1_000_000):
        with pytest.raises(Refused, match=f"{level}"):
            dataset.mesh(level)


@every_variant
def test_closed_is_what_the_mesh_says(spec: str) -> None:
    for level in (0, 1):
        mesh = mesh_of(spec, level)
        closed = registry.dataset(spec).closed  # None where it depends on the parameters
        assert closed is None or closed is not bool(mesh.boundary_edges.any())


@every_variant
def test_vertices_are_their_own_feet(spec: str) -> None:
    for level in range(3):
        mesh = mesh_of(spec, level)
        away = norm(surface_of(spec).closest(mesh.points) - mesh.points)
        assert away.max() <= 1e-14 * size(mesh)


@every_variant
def test_normals_are_unit_and_on_the_faces_outer_side(spec: str) -> None:
    for level in range(1, 4):
        mesh = mesh_of(spec, level)
        normals = normals_of(mesh)
        assert np.abs(norm(normals) - 1.0).max() < 1e-15 * 4
        assert dot(face_normals(mesh)[:, None, :], normals[mesh.faces]).min() > 0.0


@every_variant
def test_second_forms_are_symmetric_and_tangential(spec: str) -> None:
    mesh = mesh_of(spec, 2)
    W, n = second_forms_of(mesh), normals_of(mesh)
    scale = max(np.abs(W).max(), 1e-300)
    assert np.array_equal(W, W.swapaxes(-1, -2))
    assert np.abs(np.einsum("nij,nj->ni", W, n)).max() <= 1e-14 * scale


@every_variant
def test_second_form_is_the_derivative_of_the_normal(spec: str) -> None:
    # dn = W du along the surface, towards either side: W is continuous, and may have a kink where patches join
    mesh, surface = mesh_of(spec, 2), surface_of(spec)
    n, W = normals_of(mesh), second_forms_of(mesh)
    random = np.random.default_rng(3)
    u = unit(tangential(random.normal(size=n.shape), n))
    scale = 1.0 + np.abs(W).max()

    def ahead(step: float) -> Float:
        return surface.normal(surface.closest(mesh.points + step * u))

    for derivative in (forward(ahead, scale), -forward(lambda step: ahead(-step), scale)):
        error = norm(derivative - np.einsum("nij,nj->ni", W, u))
        assert error[smooth(mesh)].max() < 1e-8 * scale


def forward(function: Callable[[float], Float], scale: float) -> Float:
    """Derivatives at 0 of a function on one side of it, of fourth order; ``scale`` is about its change per length."""
    step = 1e-3 / scale
    weights = (-25.0, 48.0, -36.0, 16.0, -3.0)
    values = np.stack([weight * function(k * step) for k, weight in enumerate(weights)])
    derivative: Float = values.sum(axis=0) / (12.0 * step)
    return derivative


@every_variant
@pytest.mark.parametrize("distance", [1e-9, 1e-3, 0.03])
def test_feet_are_feet(spec: str, distance: float) -> None:
    # on the surface, of which closest is the identity, and the way there is along the normal
    mesh, surface = mesh_of(spec, 2), surface_of(spec)
    points = surface.closest(scattered(mesh, 0.0)) + distance * size(mesh) * np.random.default_rng(1).uniform(
        -1.0, 1.0, (4000, 3)
    )
    feet = surface.closest(points)
    assert norm(surface.closest(feet) - feet).max() <= 1e-14 * size(mesh)
    off = norm(tangential(points - feet, surface.normal(feet)))
    assert off[~beyond_rim(surface, points)].max() <= 1e-12 * size(mesh)
    assert beyond_rim(surface, points).mean() < 0.1


@every_variant
def test_feet_are_nearest(spec: str) -> None:
    # no vertex of a fine mesh is nearer, and one is about as near
    mesh, surface = mesh_of(spec, 3), surface_of(spec)
    points = scattered(mesh_of(spec, 2), 0.02, 300)
    distance = norm(surface.closest(points) - points)
    to_vertices = norm(mesh.points[None] - points[:, None]).min(axis=1)
    assert (distance <= to_vertices + 1e-14 * size(mesh)).all()
    assert (to_vertices**2 - distance**2 <= (2.0 * mesh.h) ** 2).all()


@every_variant
def test_a_foot_depends_on_its_point_alone(spec: str) -> None:
    points, surface = scattered(mesh_of(spec, 2), 0.1, 5000), surface_of(spec)
    feet = surface.closest(points)
    some = np.random.default_rng(5).permutation(len(points))[:57]
    assert np.array_equal(surface.closest(points[some]), feet[some], equal_nan=True)
    assert surface.closest(points[:0]).shape == (0, 3)


@every_dataset
def test_what_is_not_a_number_has_no_foot(spec: str) -> None:
    points = mesh_of(spec, 1).points[:4].copy()
    points[1, 2], points[2, 0], points[3] = np.nan, np.inf, np.nan
    feet = surface_of(spec).closest(points)
    assert np.isfinite(feet[0]).all()
    assert np.isnan(feet[1:]).all()


@every_dataset
def test_far_points_have_sensible_feet_or_none(spec: str) -> None:
    mesh, surface = mesh_of(spec, 2), surface_of(spec)
    points = np.random.default_rng(2).normal(size=(2000, 3)) * size(mesh)
    feet = surface.closest(points)
    found = ~np.isnan(feet).any(axis=1)
    assert found.mean() > 0.99
    found &= ~beyond_rim(surface, points)
    off = tangential(points[found] - feet[found], surface.normal(feet[found]))
    assert norm(off).max() <= 1e-9 * size(mesh)


@every_dataset
def test_every_level_splits_one_face_in_four(spec: str) -> None:
    coarse, fine = mesh_of(spec, 1), mesh_of(spec, 2)
    assert len(fine.faces) == 4 * len(coarse.faces)
    middles = 0 if coarse.sides == 3 else len(coarse.faces)
    assert len(fine.points) == len(coarse.points) + len(coarse.edges) + middles
    # nested: the coarser vertices come first and stay where they are
    assert norm(fine.points[: len(coarse.points)] - coarse.points).max() <= 1e-15 * size(coarse)


@every_dataset
def test_h_halves(spec: str) -> None:
    finest = max(registry.dataset(spec).finest, 1)
    assert mesh_of(spec, finest - 1).h / mesh_of(spec, finest).h == pytest.approx(2.0, abs=0.12)


@every_dataset
def test_faces_stay_well_shaped(spec: str) -> None:
    for level in range(registry.dataset(spec).finest + 1):
        corners = mesh_of(spec, level).corner_points()
        to_next, to_previous = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
        assert np.degrees(angle_between(to_next, to_previous).min()) > SHARPEST_DEG.get(spec, 18.0)


@every_dataset
def test_a_plain_run_stays_small(spec: str) -> None:
    dataset = registry.dataset(spec)
    assert dataset.finest >= 3 or dataset.finest == 0  # orders need some levels, or are not asked for
    # the torus begins with 100 faces, and its orders settle on level 2
    assert len(mesh_of(spec, dataset.finest).faces) <= 25600


@every_dataset
@pytest.mark.parametrize("level", [-1, 12, 10**6])
def test_levels_that_do_not_exist_are_refused(spec: str, level: int) -> None:
    with pytest.raises(Refused, match=spec) as caught:
        registry.dataset(spec).mesh(level)
    assert str(level) in caught.value.reason


@every_dataset
def test_a_mesh_is_the_same_every_time(spec: str) -> None:
    again = registry.dataset(spec).mesh(2)
    assert np.array_equal(again.points, mesh_of(spec, 2).points)
    assert np.array_equal(again.faces, mesh_of(spec, 2).faces)


@pytest.mark.parametrize("spec", [spec for spec in SPECS if registry.dataset(spec).closed])
def test_total_curvature_is_that_of_the_topology(spec: str) -> None:
    # Gauss-Bonnet by the mean of the corners' curvatures times the flat area: second order in h
    defects = []
    for level in (2, 3, 4):
        mesh = mesh_of(spec, level)
        characteristic = len(mesh.points) - len(mesh.edges) + len(mesh.faces)
        by_corner = mesh.face_data.corner_second_forms
        forms = second_forms_of(mesh)[mesh.faces] if by_corner is None else by_corner
        curvature = gauss(forms.reshape(-1, 3, 3)).reshape(mesh.faces.shape).mean(axis=1)
        total = float((curvature * norm(face_normals(mesh))).sum())
        defects.append(abs(total - 2.0 * np.pi * characteristic))
    # on the torus equal steps of the angle integrate trigonometric functions exactly: rounding only
    assert defects[2] < max(0.3 * defects[1], 1e-11)
    assert defects[1] < max(0.4 * defects[0], 1e-11)


@every_variant
def test_normal_curvature_by_offsetting(spec: str) -> None:
    # a foot moves by (I + d W)^-1 of what the point moves, at signed distance d: W seen through closest alone
    mesh, surface = mesh_of(spec, 2), surface_of(spec)
    n, W = normals_of(mesh), second_forms_of(mesh)
    d = 0.05 / max(1.0, np.abs(W).max())
    u = unit(tangential(np.random.default_rng(4).normal(size=n.shape), n))
    back = forward(lambda step: surface.closest(mesh.points + d * n + step * u), max(1.0, np.abs(W).max()))
    error = np.abs(dot(back, u) + d * quadratic_form(u, W, back) - 1.0)
    assert error[smooth(mesh)].max() < 1e-8
