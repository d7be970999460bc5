"""Hagen and Pottmann's scheme: data met at the vertices from every direction, curvature along the edges, the signs."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron, tetrahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry import curvature
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS, corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, quadratic_form, unit
from testbed.measures.corner_forms import corner_forms
from testbed_schemes.hagen_pottmann import HagenPottmann, side_data, stretch
from testbed_schemes.mathematics.side_vertex import separable_blend

VARIANTS = [HagenPottmann(), HagenPottmann("arc"), HagenPottmann(mu=0.7), HagenPottmann("arc", -0.4)]
MESHES = {case.name: case.mesh for case in cases(3)}
every_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())
every_variant = pytest.mark.parametrize("scheme", VARIANTS, ids=str)
T = np.concatenate([[1e-3, 1e-2], np.linspace(0.03, 0.97, 24), [0.99, 0.999]])
#: Samples away from the corners.
INTERIOR = lattice(3, 20)[corner_distance(3, lattice(3, 20)) > 0.0]


def jump(surface: Surface) -> float:
    """Largest difference of second fundamental forms over interior edges, relative to them."""
    left, right = (second_form_matrix(jet) for jet in surface.edge_jets(surface.edges[surface.edges.interior], T))
    size = norm(np.ptp(surface.mesh.points, axis=0))
    scale = np.maximum(np.abs(left), np.abs(right)).max(axis=(-1, -2)) + 1.0 / size
    return float((np.abs(left - right).max(axis=(-1, -2)) / scale).max(initial=0.0))


def second_forms(mesh: HermiteMesh) -> Float:
    """Given second fundamental forms by face and corner, (F, 3, 3, 3)."""
    assert mesh.second_forms is not None
    return mesh.second_forms[mesh.faces]


@every_variant
@every_mesh
def test_second_forms_agree_across_every_edge(scheme: HagenPottmann, mesh: HermiteMesh) -> None:
    needles = len(mesh.points) == 15  # a hundred times longer than wide
    assert jump(scheme.fit(mesh)) < (3e-8 if needles else 2e-11)


def test_without_the_squares_in_the_blend_second_forms_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nielson's weights (2.12) keep tangent planes only."""
    monkeypatch.setattr("testbed_schemes.hagen_pottmann.separable_blend", lambda *args: separable_blend(*args[:5]))
    assert jump(HagenPottmann().fit(perturbed_icosahedron())) > 0.1


@every_variant
@every_mesh
def test_points_and_normals_are_interpolated(scheme: HagenPottmann, mesh: HermiteMesh) -> None:
    jet = scheme.fit(mesh).parts[0].batch.jets(CORNERS[3], 1)
    np.testing.assert_array_equal(jet.f, mesh.corner_points())
    assert np.degrees(angle_between(jet.normal, mesh.corner_normals())).max() < 1e-10


@every_variant
@pytest.mark.parametrize("mesh", [octahedron(), perturbed_icosahedron(), torus(8, 5, 3)], ids=["8", "20", "80"])
def test_curvature_goes_to_the_data_from_every_direction(scheme: HagenPottmann, mesh: HermiteMesh) -> None:
    """In proportion to the distance; Nielson's goes elsewhere, and from every direction to another place."""
    batch = scheme.fit(mesh).parts[0].batch
    turns = np.linspace(0.0, 1.0, 9)
    worst = []
    for distance in (1e-3, 1e-4, 1e-5):
        b1, b2 = distance * (1.0 - turns), distance * turns
        corners = [np.stack([b1, b2]), np.stack([1.0 - b1 - b2, b1]), np.stack([b2, 1.0 - b1 - b2])]
        found = second_form_matrix(batch.jets(np.concatenate(corners, axis=1).T)).reshape(-1, 3, 9, 3, 3)
        worst.append(np.abs(found - second_forms(mesh)[:, :, None]).max())
    scale = np.abs(second_forms(mesh)).max()
    assert worst[0] < 0.03 * scale
    np.testing.assert_allclose(worst[1:], [worst[0] / 10, worst[0] / 100], rtol=0.1)


@every_variant
def test_edges_are_quintics_that_bend_as_the_data_say(scheme: HagenPottmann) -> None:
    """The curve's normal curvature at its ends is II(T, T) of the project, with a minus: a sphere's edges bulge out.

    The other sign, which a curvature <N, C''> / |C'|^2 taken for II gives, is as far off as the data are large.
    """
    mesh = perturbed_icosahedron()
    surface = scheme.fit(mesh)
    edges = surface.edges
    t = np.linspace(0.0, 1.0, 6)
    curve = surface.side_jets(edges.left, t, 0).f
    powers = np.linalg.solve(np.vander(t, increasing=True), curve)  # (E, 6, 3): a quintic has six coefficients
    later = np.linspace(0.05, 0.95, 7)
    predicted = np.einsum("tk,ekc->etc", np.vander(later, 6, increasing=True), powers)
    np.testing.assert_allclose(surface.side_jets(edges.left, later, 0).f, predicted, atol=1e-12)
    for end in (0, 1):
        order = np.arange(6)
        weight1 = order if end else (order == 1).astype(float)
        weight2 = order * (order - 1) if end else 2.0 * (order == 2)
        slope, bend = (np.einsum("k,ekc->ec", weight.astype(float), powers) for weight in (weight1, weight2))
        assert mesh.normals is not None
        assert mesh.second_forms is not None
        normal, form = mesh.normals[edges.ids[:, end]], mesh.second_forms[edges.ids[:, end]]
        expected = quadratic_form(slope, form, slope)
        np.testing.assert_allclose(-dot(bend, normal), expected, atol=1e-10)
        assert np.abs(dot(bend, normal) - expected).min() > 0.5


def test_with_the_printed_sign_of_curvature_the_data_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The source has k = <N, C''> / |C'|^2 for curves and II = -<D_uv S, N> for data; V'' with kappa = II(T, T)."""
    mesh = octahedron()
    given = second_forms(mesh)[:, :, None]
    assert np.abs(corner_forms(HagenPottmann().fit(mesh).parts[0].batch) - given).max() < 1e-9

    def printed(chord: Float, *data: Any) -> tuple[Float, Float, Float]:
        side, ends, across = side_data(chord, *data)
        side[..., 3:, :] *= -1.0
        return side, ends, across

    monkeypatch.setattr("testbed_schemes.hagen_pottmann.side_data", printed)
    assert np.abs(corner_forms(HagenPottmann().fit(mesh).parts[0].batch) - given).max() > 1.0


def second_forms_of(mesh: HermiteMesh) -> Float:
    assert mesh.second_forms is not None
    return mesh.second_forms


@pytest.mark.parametrize(
    ("scheme", "low", "high"),
    [(HagenPottmann(), 0.609576, 1.465827), (HagenPottmann("arc"), 0.891409, 1.066638)],
    ids=str,
)
def test_gaussian_curvature_on_the_octahedron(scheme: HagenPottmann, low: float, high: float) -> None:
    batch = scheme.fit(octahedron()).parts[0].batch
    K = curvature.gauss(batch.jets(lattice(3, 60)[corner_distance(3, lattice(3, 60)) > 0.0]))
    assert K.min() == pytest.approx(low, abs=2e-5)
    assert K.max() == pytest.approx(high, abs=2e-3)


def test_arcs_of_circles_are_met_to_the_sixth_order() -> None:
    """Great arcs with tangents of the arc's length; those of the chord's are off at the fourth."""

    def off_circle(scheme: HagenPottmann, angle: float) -> float:
        turn = np.array([0.0, angle, 0.5 * angle])
        points = np.stack([np.cos(turn), np.sin(turn), np.array([0.0, 0.0, 0.2])], axis=1)
        points = unit(points)
        forms = np.eye(3) - points[:, :, None] * points[:, None, :]
        surface = scheme.fit(HermiteMesh(points, np.array([[0, 1, 2]]), points, forms))
        at = np.stack([np.linspace(0.0, 1.0, 33), np.zeros(33)], axis=1)
        return float(np.abs(norm(surface.parts[0].batch.jets(at, 0).f) - 1.0).max())

    for scheme, order in ((HagenPottmann(), 4.0), (HagenPottmann("arc"), 6.0)):
        ratio = off_circle(scheme, 0.8) / off_circle(scheme, 0.4)
        assert np.log2(ratio) == pytest.approx(order, abs=0.15)


@every_variant
def test_a_point_by_hand(scheme: HagenPottmann) -> None:
    mesh, face, b = perturbed_icosahedron(), 7, np.array([0.2, 0.5, 0.3])
    points, normals, forms = mesh.corner_points()[face], mesh.corner_normals()[face], second_forms(mesh)[face]

    def control(p: Float, n: Float, curve0: float, q: Float, m: Float, curve1: float) -> Float:
        """Bezier points of g_v; curve(T) is II of the tangent at the end, for a tangent of length one."""
        chord = q - p
        ends = [chord - (chord @ x) * x for x in (n, m)]
        ends = [x / np.linalg.norm(x) * np.linalg.norm(chord) for x in ends]
        if scheme.tangents == "arc":
            angles = [np.arccos(chord @ x / np.linalg.norm(chord) / np.linalg.norm(x)) for x in ends]
            ends = [x * angle / np.sin(angle) for x, angle in zip(ends, angles, strict=True)]
        bend0 = -curve0 * (ends[0] @ ends[0]) * n + scheme.mu * ends[0]
        bend1 = -curve1 * (ends[1] @ ends[1]) * m - scheme.mu * ends[1]
        p1, q1 = p + ends[0] / 5, q - ends[1] / 5
        return np.stack([p, p1, bend0 / 20 + 2 * p1 - p, bend1 / 20 + 2 * q1 - q, q1, q])

    def casteljau(points: Float, t: float) -> Float:
        while len(points) > 1:
            points = (1 - t) * points[:-1] + t * points[1:]
        result: Float = points[0]
        return result

    def directed(form: Float, a: Float, b: Float, n: Float) -> float:
        """II of the unit vector along the projection of a chord."""
        chord = b - a
        along = unit(chord - (chord @ n) * n)
        return float(along @ form @ along)

    expected, total = np.zeros(3), 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        s = b[k] / (b[j] + b[k])
        curves = [directed(forms[v], points[j], points[k], normals[v]) for v in (j, k)]
        side = control(points[j], normals[j], curves[0], points[k], normals[k], curves[1])
        foot = casteljau(side, s)
        slope, bend = 5 * casteljau(np.diff(side, axis=0), s), 20 * casteljau(np.diff(side, n=2, axis=0), s)
        ends = []
        for v, t in ((j, side[1] - side[0]), (k, side[5] - side[4])):
            across = unit(np.cross(normals[v], t))
            ends.append((across, -(5 * t @ forms[v] @ across) * normals[v], across @ forms[v] @ across))
        (d0, e0, q0), (d1, e1, q1) = ends
        field = np.stack([d0, d0 + e0 / 3, d1 - e1 / 3, d1])
        D, turn = casteljau(field, s), 3 * casteljau(np.diff(field, axis=0), s)
        n = unit(np.cross(slope, D))
        frame = np.stack([slope, D], axis=1)
        II = np.array([[-bend @ n, -turn @ n], [-turn @ n, ((1 - s) * q0 + s * q1) * (D @ D)]])
        chord = foot - points[i]
        along = unit(chord - (chord @ n) * n)
        uv = np.linalg.lstsq(frame, along)[0]
        radial = control(
            points[i], normals[i], directed(forms[i], points[i], foot, normals[i]), foot, n, float(uv @ II @ uv)
        )
        weight = (b[j] * b[k]) ** 2
        expected, total = expected + weight * casteljau(radial, 1 - b[i]), total + weight
    result = scheme.fit(mesh).evaluate(np.array([face]), b[None], order=0).f[0]
    np.testing.assert_allclose(result, expected / total, atol=1e-13)


def test_planes_keep_their_linear_parameters() -> None:
    mesh = MESHES["flat mesh"]
    for tangents in ("chord", "arc"):
        jet = HagenPottmann(tangents).fit(mesh).parts[0].batch.jets(INTERIOR)
        a, b, c = np.moveaxis(mesh.corner_points()[:, :, None], 1, 0)
        u, v = INTERIOR[:, :1], INTERIOR[:, 1:]
        np.testing.assert_allclose(jet.f, (1 - u - v) * a + u * b + v * c, atol=1e-14)
        assert np.abs(jet.coefficients[3:]).max() < 1e-9


def test_stretch_is_smooth_at_tangents_along_the_chord_and_right_far_from_them() -> None:
    angle = np.array([0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.7, 1.3, 1.55])
    np.testing.assert_allclose(stretch(np.sin(angle) ** 2, "chord"), 1.0 / np.cos(angle), rtol=1e-12)
    sinc = np.sin(angle) / np.where(angle == 0.0, 1.0, angle) + (angle == 0.0)
    np.testing.assert_allclose(stretch(np.sin(angle) ** 2, "arc") * np.cos(angle), 1.0 / sinc, rtol=1e-12)
    # phi / (sin phi cos phi) = 1 + 2 x / 3 + 8 x^2 / 15 + ..., x = sin^2 phi
    x, _ = Taylor.variables(np.zeros((1, 2)))
    np.testing.assert_allclose(stretch(x, "arc").coefficients[:, 0], [1, 2 / 3, 0, 16 / 15, 0, 0], atol=1e-15)  # type: ignore[arg-type, attr-defined]  # formulas take Taylors too


def refused(points: ArrayLike, normals: ArrayLike, forms: ArrayLike | None = None) -> str:
    forms = np.zeros((3, 3, 3)) if forms is None else forms
    with pytest.raises(Refused) as refusal:
        HagenPottmann().fit(HermiteMesh(points, [[0, 1, 2]], unit(np.array(normals, dtype=np.float64)), forms))
    return refusal.value.reason


def test_an_edge_along_a_normal_is_refused_by_its_vertices() -> None:
    assert "vertex 0 to vertex 1" in refused([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 0, 0], [0, 0, 1]])


def test_planes_that_turn_over_along_an_edge_are_refused() -> None:
    reason = refused([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.5, 1.0]])
    assert "folds over at vertex 1" in reason


@pytest.mark.parametrize("factor", [-4.0, 8.0, 20.0, 100.0])
def test_forms_that_bend_a_patch_over_its_sides_are_refused(factor: float) -> None:
    """Accepted, they would have normals that jump by 180 degrees."""
    mesh = torus(8, 5, 3)
    with pytest.raises(Refused, match=r"folds over on \d+ of 240 sides of faces, the first that of face \d+ from"):
        HagenPottmann().fit(HermiteMesh(mesh.points, mesh.faces, mesh.normals, factor * second_forms_of(mesh)))


@pytest.mark.parametrize("factor", [-1.0, 0.0, 2.0, 6.0])
def test_forms_that_are_taken_leave_the_normals_continuous(factor: float) -> None:
    mesh = torus(8, 5, 3)
    surface = HagenPottmann().fit(HermiteMesh(mesh.points, mesh.faces, mesh.normals, factor * second_forms_of(mesh)))
    left, right = surface.edge_jets(surface.edges, T, 1)
    assert np.degrees(angle_between(left.normal, right.normal)).max() < 1e-10
    assert (dot(left.normal, cross(left.fu, left.fv)) > 0.0).all()


def test_data_that_are_needed_and_missing_are_refused() -> None:
    with pytest.raises(Refused, match="second fundamental forms"):
        HagenPottmann().fit(tetrahedron().without_second_forms())


@pytest.mark.parametrize("mu", [np.inf, np.nan])
def test_mu_is_finite(mu: float) -> None:
    with pytest.raises(SpecError, match="mu"):
        HagenPottmann(mu=mu)
