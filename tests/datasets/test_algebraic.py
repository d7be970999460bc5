"""Datasets of algebraic surfaces: their text, meshes, levels, boundaries, and refusals with a place."""

import pickle
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, unit
from testbed_datasets.algebraic import Algebraic
from testbed_datasets.algebraic_start import grid_about, marched, topology
from testbed_datasets.even_triangles import SHORT, SurfaceMesh, collapsed, evened, flipped
from testbed_datasets.halving import MOST_FACES

TORUS = "(x^2+y^2+z^2+3/4)^2-4*(x^2+y^2)"
QUARTIC = "x^4+y^4+z^4-4*(x^2+y^2+z^2)+5.5"
#: Texts of datasets, pieces, boundaries and Euler characteristic.
SURFACES = {
    "algebraic": (1, 0, 2),
    "algebraic[flip=true]": (1, 0, 2),
    "algebraic[box=100.0]": (1, 0, 2),
    f"algebraic[cells=8]:{TORUS}": (1, 0, 0),
    f"algebraic[box=(-2.0 -2.0 0.0 2.0 2.0 1.0),cells=5]:{TORUS}": (1, 2, 0),
    f"algebraic[cells=8]:{QUARTIC}": (1, 0, -8),
    "algebraic:x^2+y^2-z^2-1": (1, 2, 0),
    "algebraic:x^2+y^2-z^2+1": (2, 2, 2),
    "algebraic:z-x*y": (1, 1, 1),
    "algebraic:x+0.3*y-0.1": (1, 1, 1),
    "algebraic[cells=8]:((x-1)^2+y^2+z^2-0.5)*((x+1.3)^2+y^2+z^2-1)+0.01": (2, 0, 4),
    "algebraic[box=(98.5 198.5 -1.5 101.5 201.5 1.5)]:(x-100)^2+(y-200)^2+z^2-1": (1, 0, 2),
    "algebraic:1e-20*x^2+1e-20*y^2+1e-20*z^2-1e-20": (1, 0, 2),
}
every_surface = pytest.mark.parametrize("spec", SURFACES)
polynomials = st.text(st.sampled_from("xyz123+-*^()/ "), max_size=20)


@cache
def dataset_of(spec: str) -> Algebraic:
    dataset = registry.dataset(spec)
    assert isinstance(dataset, Algebraic)
    return dataset


@cache
def mesh_of(spec: str, level: int) -> HermiteMesh:
    return dataset_of(spec).mesh(level)


def face_normals(mesh: HermiteMesh) -> Float:
    a, b, c = np.moveaxis(mesh.corner_points(), 1, 0)
    return unit(cross(b - a, c - a))


def angles(mesh: HermiteMesh) -> Float:
    corners = mesh.corner_points()
    return np.degrees(angle_between(np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners))


@pytest.mark.parametrize(
    ("spec", "polynomial", "box", "cells"),
    [
        ("algebraic", "4*x**2+2*y**2+z**2-4", 3.0, 4),
        ("algebraic:x^2+y^2+z^2-1", "x^2+y^2+z^2-1", 3.0, 4),
        ('algebraic:"x^2 + y^2 - 1"', "x^2 + y^2 - 1", 3.0, 4),
        ("algebraic[cells=6,box=2]:(x)*(y)-1", "(x)*(y)-1", 2.0, 6),
        ("algebraic[box=(-1 -2 -3 1 2 3)]:z", "z", (-1.0, -2.0, -3.0, 1.0, 2.0, 3.0), 4),
        ('algebraic[polynomial="x*(y+1)-z",cells=9]', "x*(y+1)-z", 3.0, 9),
    ],
)
def test_text_of_a_dataset(spec: str, polynomial: str, box: object, cells: int) -> None:
    dataset = dataset_of(spec)
    assert (dataset.polynomial, dataset.box, dataset.cells) == (polynomial, box, cells)
    assert registry.dataset(str(dataset)) == dataset


@settings(max_examples=200, deadline=None)
@given(polynomials, st.sampled_from([3.0, 0.1, (-1.0, -1.0, -1.0, 2.0, 2.0, 2.5)]), st.integers(1, 64), st.booleans())
def test_any_dataset_parses_back_from_its_text(polynomial: str, box: float, cells: int, flip: bool) -> None:
    try:
        dataset = Algebraic(polynomial, box, cells, flip)
    except SpecError:
        return
    assert registry.dataset(str(dataset)) == dataset


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("algebraic:2x", "the polynomial of algebraic cannot be read at column 2"),
        ("algebraic:__import__('os')", "'__import__' is not known: use x, y and z"),
        ("algebraic:", "the polynomial of algebraic is empty"),
        ("algebraic:3", "the polynomial of algebraic is constant, 3 everywhere"),
        ("algebraic[polynomial=x]:y", "parameter polynomial of algebraic is given twice"),
        ("algebraic[box=0]", "parameter box of algebraic cannot be 0.0"),
        ("algebraic[box=-1]", "parameter box of algebraic cannot be -1.0"),
        ("algebraic[box=1e-300]", "parameter box of algebraic cannot be 1e-300"),
        ("algebraic[box=(1 1 1 0 2 2)]", "the lowest x, y, z and then the highest"),
        ("algebraic[box=(0 0 0 1 1 1e-5)]", "no side much shorter"),
        ("algebraic[box=(0 0 0 1)]", "takes 6 values"),
        ("algebraic[cells=0]", "parameter cells of algebraic cannot be 0: give 1 to 64"),
        ("algebraic[cells=65]", "parameter cells of algebraic cannot be 65"),
        ('algebraic:"x', "quoted text that does not end"),
    ],
)
def test_bad_parameters_are_named(spec: str, words: str) -> None:
    with pytest.raises(SpecError) as caught:
        registry.dataset(spec)
    assert words in str(caught.value)


@every_surface
def test_the_topology_is_that_of_the_surface_at_every_level(spec: str) -> None:
    for level in range(3):
        assert topology(mesh_of(spec, level).faces) == SURFACES[spec]


@every_surface
def test_vertices_are_on_the_surface_and_faces_along_its_normals(spec: str) -> None:
    surface = dataset_of(spec).surface
    for level in range(3):
        mesh = mesh_of(spec, level)
        assert mesh.normals is not None
        assert mesh.second_forms is not None
        residual = np.abs(surface.evaluated.values(mesh.points)) / norm(surface.gradient(mesh.points))
        assert residual.max() <= 4e-16 * np.abs(mesh.points).max() + 1e-15
        assert dot(face_normals(mesh)[:, None], mesh.normals[mesh.faces]).min() > (0.1, 0.4, 0.65)[level]
        assert np.abs(np.einsum("nij,nj->ni", mesh.second_forms, mesh.normals)).max() < 1e-14 * (
            1.0 + np.abs(mesh.second_forms).max()
        )
        assert angles(mesh).min() > 11.0


@every_surface
def test_boundary_vertices_are_on_the_sides_of_the_box(spec: str) -> None:
    surface = dataset_of(spec).surface
    for level in range(3):
        mesh = mesh_of(spec, level)
        on_boundary = np.any(surface.on_sides(mesh.points), axis=1)
        assert np.array_equal(on_boundary, mesh.boundary_vertices)
        assert (mesh.points >= surface.low).all()
        assert (mesh.points <= surface.high).all()
        tangents = mesh.face_data.side_tangents
        assert (tangents is None) == (not np.any(on_boundary))
        if tangents is not None:
            boundary = mesh.boundary_edges[mesh.face_edges]
            assert np.isfinite(tangents[boundary]).all()
            assert np.isnan(tangents[~boundary]).all()


def test_boundary_curves_that_follow_the_tangents_stay_on_the_sides_of_the_box() -> None:
    spec = "algebraic:x^2+y^2-z^2-1"
    mesh, surface = mesh_of(spec, 1), dataset_of(spec).surface
    curves = registry.boundary_curve("hermite").network(mesh).control_points[mesh.boundary_edges]
    on_sides = surface.on_sides(curves)  # (edges, 4, 3)
    assert np.any(np.all(on_sides, axis=1), axis=1).all()


def test_the_published_ellipsoid() -> None:
    mesh = mesh_of("algebraic", 0)
    assert (len(mesh.points), len(mesh.faces)) == (22, 40)
    assert angles(mesh).min() > 35.0
    quadric = registry.dataset("ellipsoid").surface
    assert quadric is not None
    assert norm(quadric.closest(mesh.points) - mesh.points).max() < 1e-15
    assert mesh.normals is not None
    assert np.abs(quadric.normal(mesh.points) - mesh.normals).max() < 1e-15


def test_flipping_turns_the_surface_inside_out() -> None:
    mesh, flipped_mesh = mesh_of("algebraic", 1), mesh_of("algebraic[flip=true]", 1)
    for one in (mesh, flipped_mesh):
        assert one.normals is not None
        assert one.second_forms is not None
        sign = 1.0 if one is mesh else -1.0
        assert (sign * dot(one.normals, one.points)).min() > 0.0
        assert (sign * np.trace(one.second_forms, axis1=1, axis2=2)).min() > 0.0


def test_the_start_mesh_does_not_depend_on_how_much_larger_the_box_is() -> None:
    for box in ("2.5", "10", "(-3 -4 -5 6 7 8)"):
        mesh = registry.dataset(f"algebraic[box={box}]").mesh(0)
        assert 30 <= len(mesh.faces) <= 60
        assert angles(mesh).min() > 20.0


@pytest.mark.parametrize(
    ("polynomial", "place"),
    [
        ("x**2+y**2-z**2", "(0, 0, 0)"),
        ("x*y*z", "(0, 0, 0)"),
        ("y^2-x^2*(x+1)", "(0, 0, 0)"),
        ("(x-1)^2+(y+0.5)^2-(z-2)^2", "(1, -0.5, 2)"),
        ("(x^2+y^2+z^2-3)^2", "(-1, -1, -1)"),
    ],
)
def test_a_singular_point_is_refused_with_its_place(polynomial: str, place: str) -> None:
    with pytest.raises(Refused) as caught:
        Algebraic(polynomial).mesh(0)
    assert caught.value.reason == (
        f"algebraic:{polynomial} has a singular point at {place}, where the polynomial and its gradient vanish: take a "
        "box without that place, or another polynomial"
    )


def test_a_singular_point_outside_the_box_does_no_harm() -> None:
    mesh = Algebraic("x**2+y**2-z**2", (-3.0, -3.0, 0.5, 3.0, 3.0, 2.5), 6).mesh(1)
    assert topology(mesh.faces) == (1, 2, 0)


@pytest.mark.parametrize(
    ("dataset", "words"),
    [
        (Algebraic("x^2+y^2+z^2+1"), "has no real point in the box from (-3, -3, -3) to (3, 3, 3): take another box"),
        (Algebraic("(x-9)^2+y^2+z^2-1", 2.0), "has no real point in the box from (-2, -2, -2) to (2, 2, 2)"),
        (Algebraic("(x^2+y^2-1)^2-1e-9"), "has too small a gradient near "),
        (Algebraic(TORUS, cells=3), ": take cells="),
        (Algebraic(QUARTIC, cells=4), ": take cells=8"),
        (Algebraic("(x^2+y^2+z^2-4)*((x-2.1)^2+y^2+(z-2)^2-0.01)"), "has a part that 4 cells do not show near (2."),
        (Algebraic("(x^2+y^2+z^2-4)*(x^2+y^2+z^2-4.2)"), "has too small a gradient near "),
        (Algebraic("z+3"), "take another box"),
    ],
)
def test_what_cannot_be_meshed_is_refused_in_a_sentence(dataset: Algebraic, words: str) -> None:
    with pytest.raises(Refused) as caught:
        dataset.mesh(0)
    assert words in caught.value.reason
    assert "\n" not in caught.value.reason


def test_advice_about_cells_is_good() -> None:
    with pytest.raises(Refused) as caught:
        Algebraic(QUARTIC, cells=4).mesh(0)
    cells = int(caught.value.reason.rpartition("=")[2])
    assert topology(Algebraic(QUARTIC, cells=cells).mesh(0).faces) == (1, 0, -8)


def test_levels() -> None:
    dataset = dataset_of("algebraic")
    with pytest.raises(Refused, match="no level -1"):
        dataset.mesh(-1)
    with pytest.raises(Refused, match=f"more than {MOST_FACES} faces: take a level up to 8"):
        dataset.mesh(9)


def test_a_dataset_is_what_it_was_after_use() -> None:
    used, fresh = Algebraic(), Algebraic()
    used.surface.closest(used.mesh(1).points)
    assert used == fresh
    assert hash(used) == hash(fresh)
    again = pickle.loads(pickle.dumps(used))  # noqa: S301 - just dumped
    assert np.array_equal(again.mesh(2).points, fresh.mesh(2).points)


def even_start(spec: str) -> tuple[SurfaceMesh, float]:
    """The marched mesh of a dataset, projected, and the cells' size."""
    dataset = dataset_of(spec)
    surface = dataset.surface
    grid = grid_about(surface, 10)
    points, faces = marched(surface, grid)
    held = surface.on_sides(points)
    return SurfaceMesh(surface.projected(points, held), faces, held, surface.projected, surface.normal), grid.length


@pytest.mark.parametrize(
    "spec", ["algebraic", f"algebraic[cells=8]:{QUARTIC}", "algebraic:z-x*y", "algebraic:x^2+y^2-z^2-1"]
)
def test_evening_keeps_the_topology_and_removes_needles(spec: str) -> None:
    mesh, length = even_start(spec)
    for change in (lambda one: collapsed(one, SHORT * length), flipped):
        changed = change(mesh)
        assert topology(changed.faces) == topology(mesh.faces)
        HermiteMesh(changed.points, changed.faces)  # oriented, manifold, without degenerate faces
        mesh = changed
    even = evened(mesh, length)
    assert topology(even.faces) == topology(mesh.faces)
    corners = even.points[even.faces]
    assert even.facing(corners).min() > 0.3
    assert angles(HermiteMesh(even.points, even.faces)).min() > 25.0
    sides = norm(corners - np.roll(corners, 1, axis=1)) / length
    assert sides.min() > 0.4
    assert sides.max() < 2.2
    start = even_start(spec)[0]
    assert np.array_equal(np.unique(even.held, axis=0), np.unique(start.held, axis=0))


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.integers(-4, 4), *(3 * [st.integers(0, 2)])), min_size=2, max_size=5))
def test_any_polynomial_is_meshed_or_refused(terms: list[tuple[int, int, int, int]]) -> None:
    text = "+".join(f"({c})*x^{i}*y^{j}*z^{k}" for c, i, j, k in terms)
    try:
        dataset = Algebraic(text, 1.5, 8)
        mesh = dataset.mesh(0)
    except (SpecError, Refused) as error:
        assert "\n" not in str(error)  # noqa: PT017 - either is right
        return
    assert mesh.normals is not None
    assert dot(face_normals(mesh)[:, None], mesh.normals[mesh.faces]).min() > 0.1


def test_cubic_patches_converge_to_it() -> None:
    scheme = registry.scheme("cubic-interpolant")
    surface = dataset_of("algebraic").surface
    middle = np.full((1, 2), 1.0 / 3.0)
    distances = []
    for level in (1, 2, 3):
        jets = scheme.fit(mesh_of("algebraic", level)).batches[0].jets(middle, 0)
        points = jets.f.reshape(-1, 3)
        distances.append(norm(surface.closest(points) - points).max())
    orders = np.log2(np.array(distances[:-1]) / np.array(distances[1:]))
    assert orders.min() > 4.5
