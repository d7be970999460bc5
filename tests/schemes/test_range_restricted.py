"""Range-restricted surfaces: on the data's side of the plane, G1, through the data, and what is refused."""

import numpy as np
import pytest

import testbed
from testbed.conformance.meshes import GENERIC, Case, cases, fan, graph, octahedron
from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import side_indices
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, unit
from testbed_schemes.mathematics.edgewise_quartics import EdgewiseQuartics
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate
from testbed_schemes.range_restricted import RangeRestricted

#: G1 in radians, on every edge.
SMOOTH = 1e-10
AT = lattice(3, 15)
T = np.linspace(0.0, 1.0, 13)
TILTED = unit(np.array([0.2, 0.3, 1.0]))
SCATTERED = [
    *(f"scattered[field=peak,seed={seed}]" for seed in range(4)),
    *(f"scattered[field=peak,seed={seed},normals=estimated]" for seed in range(4, 7)),
    *(f"scattered[field=rainfall,seed={seed}]" for seed in range(4)),
    *(f"scattered[field=rainfall,seed={seed},normals=none]" for seed in range(4, 7)),
    *(f"scattered[field=noise,seed={seed},normals=none]" for seed in range(4)),
]
ZOO = {case.name: case.mesh for case in cases(3)}
CLOSED = ["octahedron", "icosahedron with perturbed normals", "coarse torus", "ellipsoid"]


def scattered(spec: str) -> HermiteMesh:
    """Return the scattered heights of a dataset."""
    return testbed.dataset(spec).mesh(0)


def above(mesh: HermiteMesh, normal: Float, gap: float) -> tuple[float, float, float, float]:
    """Return the plane with a normal that is so far below the lowest vertex."""
    a, b, c = normal.tolist()
    return a, b, c, gap - float(dot(mesh.points, normal).min())


def batch(surface: Surface) -> EdgewiseQuartics:
    """Return the patches, one a face."""
    patches = surface.batches[0]
    assert isinstance(patches, EdgewiseQuartics)
    return patches


def quartics(surface: Surface) -> list[BezierTriangles]:
    """Return the three quartics of all faces."""
    components = [one for one in batch(surface).convex_components if isinstance(one, BezierTriangles)]
    assert [one.degree for one in components] == [4, 4, 4]
    return components


def heights(surface: Surface, plane: tuple[float, float, float, float]) -> Float:
    """Distances of many points of the surface from a plane, (F, S)."""
    return np.asarray((dot(batch(surface).jets(AT, 0).f, np.array(plane[:3])) + plane[3]) / norm(np.array(plane[:3])))


def check_joined(surface: Surface, mesh: HermiteMesh, normals: bool = True) -> None:
    """Position, tangent planes along the edges, points and normals at the vertices."""
    size = float(norm(np.ptp(mesh.points, axis=0)))
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, 1)
    assert norm(left.f - right.f).max(initial=0.0) < 1e-14 * size
    assert angle_between(left.normal, right.normal).max(initial=0.0) < SMOOTH
    corners = batch(surface).jets(CORNERS[3], 1)
    assert norm(corners.f - mesh.corner_points()).max() < 1e-15 * size
    if normals and mesh.normals is not None:
        assert angle_between(corners.normal, mesh.corner_normals()).max() < 1e-11


def check_bounds(surface: Surface, mesh: HermiteMesh, plane: tuple[float, float, float, float]) -> None:
    """No control point lies lower than the sufficient bound of its face, no point of the surface below the plane."""
    length = norm(np.array(plane[:3]))
    vertices = (dot(mesh.corner_points(), np.array(plane[:3])) + plane[3]) / length
    bounds = lower_ordinate(*np.maximum(vertices, 0.0).T)
    for component in quartics(surface):
        ordinates = (dot(component.control_points, np.array(plane[:3])) + plane[3]) / length
        assert (ordinates + bounds[:, None]).min() >= -1e-15
    assert heights(surface, plane).min() >= -1e-15


@pytest.mark.parametrize("spec", SCATTERED)
def test_heights_stay_above_the_plane_that_they_cross_otherwise(spec: str) -> None:
    mesh, plane = scattered(spec), (0.0, 0.0, 1.0, 0.0)
    free, restricted = RangeRestricted(constrain="never").fit(mesh), RangeRestricted(constrain="always").fit(mesh)
    assert heights(free, plane).min() < -1e-4
    check_bounds(restricted, mesh, plane)
    for surface in (free, restricted):
        check_joined(surface, mesh)
    assert restricted.branches["faces kept on one side of the plane"] == len(mesh.faces)
    assert sum(restricted.branches.values()) > len(mesh.faces)


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("normals", ["data", "inverse-area"])
def test_closed_meshes_stay_above_a_tilted_plane_close_below(name: str, normals: str) -> None:
    mesh = ZOO[name]
    plane = above(mesh, TILTED, 0.002)
    scheme = RangeRestricted(plane, constrain="always", normals="data" if normals == "data" else "inverse-area")
    restricted, free = scheme.fit(mesh), RangeRestricted(constrain="never").fit(mesh)
    assert heights(free, plane).min() < -1e-4
    check_bounds(restricted, mesh, plane)
    for surface in (free, restricted):
        check_joined(surface, mesh, normals == "data")


def test_the_restriction_moves_the_surface_little_and_most_faces_of_a_peak_not_at_all() -> None:
    mesh = scattered(SCATTERED[0])
    free, restricted = RangeRestricted(constrain="never").fit(mesh), RangeRestricted(constrain="always").fit(mesh)
    moved = norm(batch(free).jets(AT, 0).f - batch(restricted).jets(AT, 0).f).max(axis=1)
    assert 1e-4 < moved.max() < 0.05
    assert (moved < 1e-15).sum() > len(mesh.faces) // 3
    far = RangeRestricted((0.0, 0.0, 1.0, 5.0), constrain="always").fit(mesh)
    assert np.abs(batch(far).control_points - batch(free).control_points).max() < 1e-15


def test_either_side_of_the_plane_and_any_length_of_its_normal() -> None:
    mesh = scattered(SCATTERED[1])
    expected = batch(RangeRestricted(constrain="always").fit(mesh)).control_points
    for plane, side in (
        ((0.0, 0.0, -3.0, 0.0), "below"),
        ((0.0, 0.0, -3.0, 0.0), "auto"),
        ((0.0, 0.0, 7.0, 0.0), "above"),
    ):
        scheme = RangeRestricted(plane, side=side, constrain="always")  # type: ignore[arg-type]
        assert batch(scheme.fit(mesh)).control_points == pytest.approx(expected, abs=1e-14)
    mirrored = mesh.transformed(np.diag([1.0, -1.0, -1.0]))
    found = batch(RangeRestricted(side="below", constrain="always").fit(mirrored)).control_points
    assert found == pytest.approx(expected * [1.0, -1.0, -1.0], abs=1e-14)


def test_data_on_the_wrong_side_are_refused_naming_the_vertex() -> None:
    mesh = scattered(SCATTERED[0])
    points = mesh.points.copy()
    points[7, 2] = -0.25
    low = HermiteMesh(points, mesh.faces, mesh.normals)
    with pytest.raises(Refused, match=r"stays above the plane, and vertex 7 is 0\.25 below it, the first of 1"):
        RangeRestricted(constrain="always").fit(low)
    with pytest.raises(Refused, match="stays below the plane, and vertex 0 is"):
        RangeRestricted(constrain="always", side="below").fit(mesh)
    unrestricted = RangeRestricted().fit(low)
    assert unrestricted.branches["faces not restricted: data on the other side of the plane"] == len(mesh.faces)
    never = RangeRestricted(constrain="never").fit(low)
    assert np.array_equal(batch(unrestricted).control_points, batch(never).control_points)


def test_a_vertex_on_the_plane_needs_its_normal() -> None:
    mesh = scattered(SCATTERED[0])
    points = mesh.points.copy()
    points[:, 2] = np.abs(points[:, 2] - points[9, 2])
    assert mesh.normals is not None
    normals = mesh.normals.copy()
    normals[9] = unit(np.array([0.1, 0.0, 1.0]))
    tilted = HermiteMesh(points, mesh.faces, normals)
    with pytest.raises(Refused, match=r"at vertex 9, which lies on it with a normal 5\.71 degrees off the plane's"):
        RangeRestricted(constrain="always").fit(tilted)
    surface = RangeRestricted().fit(tilted)
    assert surface.branches["faces not restricted: a normal on the plane is not the plane's"] == len(mesh.faces)
    # normals of the scheme's own are the plane's there
    own = RangeRestricted(constrain="always", normals="inverse-area").fit(tilted)
    face, corner = (int(index[0]) for index in np.nonzero(mesh.faces == 9))
    assert batch(own).jets(CORNERS[3], 1).normal[face, corner] == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)
    assert own.branches["vertices with turned normals"] >= 1
    check_bounds(own, tilted, (0.0, 0.0, 1.0, 0.0))


def test_tangents_that_hardly_are_left_are_refused_naming_the_vertex() -> None:
    mesh = ZOO["octahedron"]
    turned = HermiteMesh(mesh.points, mesh.faces, unit(mesh.points + np.array([0.3, 0.1, 0.0])))
    with pytest.raises(Refused, match=r"would have to shorten tangents at vertex 5 to .* of their length"):
        RangeRestricted((0.0, 0.0, 1.0, 1.0 + 1e-9), constrain="always").fit(turned)


def test_planes_without_a_normal_and_folds_are_refused() -> None:
    for plane in ((0.0, 0.0, 0.0, 1.0), (np.nan, 0.0, 1.0, 0.0), (0.0, 0.0, 1.0, np.inf)):
        with pytest.raises(SpecError, match="range-restricted: plane must be four finite numbers"):
            RangeRestricted(plane)
    mesh = octahedron()
    assert mesh.normals is not None
    normals = mesh.normals.copy()
    normals[::2] *= -1.0
    with pytest.raises(Refused, match="folds over at vertex"):
        RangeRestricted().fit(HermiteMesh(mesh.points, mesh.faces, normals))


def test_a_mesh_without_normals_gets_those_by_inverse_areas() -> None:
    mesh = graph(*fan())
    found = RangeRestricted(constrain="never").fit(mesh.without_normals())
    expected = RangeRestricted(constrain="never", normals="inverse-area").fit(mesh)
    assert np.array_equal(batch(found).control_points, batch(expected).control_points)


QUADRATIC = np.array([[0.3, -0.4, 0.35], [0.2, -0.5, 0.0], [0.7, 0.0, 0.0]])


def off_graph(surface: Surface, coefficients: Float) -> float:
    """Return how far points are above or below a graph z = p(x, y)."""
    x, y, z = np.moveaxis(batch(surface).jets(AT, 0).f, -1, 0)
    return float(np.abs(z - np.polynomial.polynomial.polyval2d(x, y, coefficients)).max())


def test_quadratic_graphs_come_out_if_chords_are_projected_along_the_axis() -> None:
    mesh = graph(*fan(), QUADRATIC)
    assert off_graph(RangeRestricted(constrain="never", tangents="plane").fit(mesh), QUADRATIC) < 2e-15
    assert off_graph(RangeRestricted(constrain="never").fit(mesh), QUADRATIC) > 1e-3
    # other graphs do not
    assert off_graph(RangeRestricted(constrain="never", tangents="plane").fit(graph(*fan())), GENERIC) > 1e-4


@pytest.mark.parametrize("case", [case for case in cases(3) if len(case.mesh.faces) > 1], ids=lambda case: case.name)
def test_the_patch_is_the_blend_of_its_quartics_and_has_their_tangent_planes(case: Case) -> None:
    surface = RangeRestricted(constrain="never").fit(case.mesh)
    size = float(norm(np.ptp(case.mesh.points, axis=0)))
    inside = np.random.default_rng(0).dirichlet(np.ones(3), 20)
    b = inside.T
    weights = np.stack([b[s] * b[(s + 1) % 3] for s in range(3)])
    weights /= weights.sum(axis=0)
    parts = [one.jets(inside[:, 1:], 0).f for one in quartics(surface)]
    blend = sum(weight[:, None] * part for weight, part in zip(weights, parts, strict=True))
    assert norm(batch(surface).jets(inside[:, 1:], 0).f - blend).max() < 1e-14 * size
    for s, component in enumerate(quartics(surface)):
        along = (1.0 - T)[:, None] * CORNERS[3][s] + T[:, None] * CORNERS[3][(s + 1) % 3]
        patch, quartic = batch(surface).jets(along, 1), component.jets(along, 1)
        assert norm(patch.f - quartic.f).max() < 1e-14 * size
        assert angle_between(patch.normal, quartic.normal).max() < 1e-12


def test_the_quartics_share_their_boundary_and_have_the_mean_away_from_their_side() -> None:
    nets = batch(RangeRestricted(constrain="never").fit(ZOO["coarse torus"])).nets()
    sides = np.unique(side_indices(4))
    assert np.array_equal(nets[:, 0][:, sides], nets[:, 1][:, sides])
    assert np.array_equal(nets[:, 0][:, sides], nets[:, 2][:, sides])
    inner = [place for place in range(15) if place not in sides]
    for s in range(3):
        free = inner[(s + 2) % 3]
        others = 0.5 * (nets[:, (s + 1) % 3, free] + nets[:, (s + 2) % 3, free])
        assert nets[:, s, free] == pytest.approx(others, abs=1e-15)


def test_derivatives_of_the_blend_are_those_of_its_points() -> None:
    patches = batch(RangeRestricted(constrain="never").fit(ZOO["icosahedron with perturbed normals"]))
    at, step = np.array([[0.2, 0.3], [0.05, 0.9], [0.4, 0.0]]), 1e-5
    at[2, 1] = 2 * step
    jets = patches.jets(at).coefficients
    u, v = np.array([step, 0.0]), np.array([0.0, step])

    def point(place: Float) -> Float:
        return patches.jets(place, 0).f

    assert jets[1] == pytest.approx((point(at + u) - point(at - u)) / (2 * step), abs=1e-8)
    assert jets[2] == pytest.approx((point(at + v) - point(at - v)) / (2 * step), abs=1e-8)
    mixed = (point(at + u + v) - point(at + u - v) - point(at - u + v) + point(at - u - v)) / (4 * step**2)
    assert jets[4] == pytest.approx(mixed, abs=1e-4)


def test_the_surface_is_regular_and_sees_the_given_normals() -> None:
    for name in ("octahedron", "coarse torus", "open mesh with a vertex of valence 12"):
        jets = batch(RangeRestricted(constrain="never").fit(ZOO[name])).jets(AT, 1)
        mesh = ZOO[name]
        outward = dot(jets.normal, unit(cross(*np.moveaxis(np.diff(mesh.corner_points(), axis=1), 1, 0)))[:, None])
        assert outward.min() > 0.0


def test_the_order_of_convergence_on_a_sphere_is_four_by_symmetry() -> None:
    errors = [
        np.abs(norm(batch(RangeRestricted().fit(testbed.dataset("sphere").mesh(level))).jets(AT, 0).f) - 1.0).max()
        for level in (1, 2, 3)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3.83, abs=0.05)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(3.95, abs=0.05)


def test_specs_parse_back() -> None:
    for text in (
        "range-restricted",
        "range-restricted[plane=(0.5 0.0 1.0 -2.0),side=below,constrain=always,normals=inverse-area,tangents=plane]",
    ):
        assert str(testbed.scheme(text)) == text
    assert testbed.scheme("range-restricted[constrain=never]").support == 1
    assert testbed.scheme("range-restricted[constrain=never,normals=inverse-area]").support == 2
    assert testbed.scheme("range-restricted").support is None
