"""The equations of the bicubic interpolant: matrices by subdivision, data of given patches, misprints, degeneracy."""

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.bezier import BezierQuads
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS as DOMAIN_CORNERS
from testbed.geometry.face_data import Centres
from testbed.geometry.vectors import Float, dot, norm, quadratic_form
from testbed_schemes.mathematics.bicubic_centre import Branch, CentreSystem, inner_points
from testbed_schemes.mathematics.bicubic_nets import (
    CORNERS,
    QUARTER,
    I,
    J,
    adini_points,
    corner_legs,
    in_tangent_planes,
    zero_twist_points,
)
from testbed_schemes.mathematics.three_quadrics import real_roots, values


def bumpy_nets(count: int, bump: float, seed: int) -> Float:
    """Nets near the unit square, with heights and displacements."""
    i, j = np.meshgrid(np.arange(4), np.arange(4), indexing="ij")
    flat = np.stack([i / 3.0, j / 3.0, 0.0 * i], axis=-1)
    bowl = np.stack([0.0 * i, 0.0 * i, 0.1 * (i - 1.5) ** 2 + 0.15 * (j - 1.4) ** 2], axis=-1)
    nets: Float = flat + bowl + bump * np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 4, 4, 3))
    return nets


def sampled(nets: Float) -> tuple[Float, Float, Centres]:
    """Normals and second forms at the corners next to the inner control points, (F, 4, ...), samples at the centres."""
    corners = BezierQuads(nets).jets(DOMAIN_CORNERS[4])
    centre = BezierQuads(nets).jets(np.full((1, 2), 0.5))
    at_centre = Centres(centre.f[:, 0], centre.normal[:, 0], second_form_matrix(centre)[:, 0])
    return corners.normal[:, CORNERS], second_form_matrix(corners)[:, CORNERS], at_centre


def halved_at(net: Float, axis: int) -> Float:
    """The first half of a net along an axis, by de Casteljau's algorithm."""
    points, first = np.moveaxis(net, axis, 0), []
    while len(points):
        first.append(points[0])
        points = 0.5 * (points[1:] + points[:-1])
    return np.moveaxis(np.stack(first), 0, axis)


def quarter_points(net: Float) -> dict[str, Float]:
    quarter = halved_at(halved_at(net, 0), 1)
    places = {"p": (3, 3), "t1": (3, 2), "t2": (2, 3), "c1": (3, 1), "c2": (1, 3), "m": (2, 2)}
    return {name: quarter[place] for name, place in places.items()}


def test_weights_of_the_quarter_are_those_of_subdivision() -> None:
    net = np.random.default_rng(1).normal(size=(4, 4, 3))
    for name, point in quarter_points(net).items():
        assert norm(np.einsum("ij,ijx->x", QUARTER[name], net) - point) < 1e-15


#: The parts of 32 t1 and 32 t2 that the boundary has, as printed above (4.4) on page 66, and as they are.
KNOWN = {
    "t1": (
        [[1, 2, 1, 0], [3, 0, 0, 0], [3, 0, 0, 0], [1, 0, 0, 0]],
        [[1, 2, 1, 0], [3, 0, 0, 0], [3, 0, 0, 0], [1, 2, 1, 0]],
    ),
    "t2": (
        [[1, 3, 3, 0], [2, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]],
        [[1, 3, 3, 1], [2, 0, 0, 2], [1, 0, 0, 1], [0, 0, 0, 0]],
    ),
}
#: The parts of the inner control points 11, 12, 21, 22 in 32 t1 and 32 t2, printed left of the equals sign.
UNKNOWN = {"t1": [6, 3, 6, 3], "t2": [6, 6, 3, 3]}


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_the_printed_known_sides_of_the_tangent_plane_are_misprints(name: str) -> None:
    net = np.random.default_rng(2).normal(size=(4, 4, 3))
    point = 32.0 * quarter_points(net)[name]
    unknown = np.einsum("k,kx->x", UNKNOWN[name], net[I, J])
    printed, right = (np.einsum("ij,ijx->x", np.array(known), net) + unknown for known in KNOWN[name])
    assert norm(right - point) < 1e-13
    assert norm(printed - point) > 1.0


def test_the_printed_factors_of_the_quadrics_belong_to_sums_that_are_not_normalised() -> None:
    net = bumpy_nets(1, 0.05, 3)
    _, _, centres = sampled(net)
    N, W = centres.normals[0], centres.second_forms[0]
    points = {name: point - centres.points[0] for name, point in quarter_points(net[0]).items()}
    sums = {"t1": 32.0, "t2": 32.0, "c1": 16.0, "c2": 16.0, "m": 16.0}
    for factor, high, one, other in ((64.0, "m", "t1", "t2"), (128.0 / 3.0, "c1", "t1", "t1")):
        height = [-dot(N, scale * points[high]) for scale in (1.0, sums[high])]
        bent = [
            quadratic_form(a * points[one], W, b * points[other]) for a, b in ((1.0, 1.0), (sums[one], sums[other]))
        ]
        assert factor * height[1] == pytest.approx(bent[1], rel=1e-12)
        assert abs(factor * height[0] - bent[0]) > 10.0 * abs(bent[0])


def test_the_printed_sign_of_the_corner_equations_turns_the_mixed_part_over() -> None:
    net = bumpy_nets(20, 0.05, 4)
    normals, forms, _ = sampled(net)
    corner, along_u, along_v = corner_legs(net)
    height, bent = dot(net[:, I, J] - corner, normals), quadratic_form(along_u, forms, along_v)
    assert np.abs(height + bent).max() < 1e-15
    assert np.abs(height - bent).max() > 1e-3
    # and what is moved into the tangent planes has the second form of the patch the data came from
    other = net.copy()
    other[:, I, J] = in_tangent_planes(net, net[:, I, J] + 0.1, normals, forms)
    assert np.abs(sampled(other)[1] - forms).max() < 1e-12
    other[:, I, J] = zero_twist_points(net, normals, forms)
    assert np.abs(sampled(other)[1] - forms).max() < 1e-12


def test_adinis_points_are_those_of_a_coons_patch() -> None:
    # a patch that is linear along v, or along u, is the Coons patch of its boundary
    net = np.random.default_rng(5).normal(size=(3, 4, 4, 3))
    t = np.arange(4)[None, None, :, None] / 3.0
    ruled = (1.0 - t) * net[:, :, :1] + t * net[:, :, 3:]
    for one in (ruled, ruled.swapaxes(1, 2)):
        assert norm(adini_points(one) - one[:, I, J]).max() < 1e-15


def system_of(net: Float, normals: Float, centres: Centres) -> tuple[CentreSystem, Float]:
    size = np.full(len(net), 0.9)
    return CentreSystem.of(net, normals, centres, size), size


def with_zero_twist(net: Float, normals: Float, forms: Float) -> Float:
    result = net.copy()
    result[:, I, J] = zero_twist_points(net, normals, forms)
    return result


def test_the_patch_that_the_data_came_from_is_among_the_roots() -> None:
    net = bumpy_nets(200, 0.04, 6)
    normals, forms, centres = sampled(net)
    start = with_zero_twist(net, normals, forms)
    system, size = system_of(start, normals, centres)
    affine, regular = system.solved_linearly()
    assert regular.all()
    roots = real_roots(system.quadrics(affine))
    offsets = affine[:, None, 1:, 0] + np.einsum("fik,frk->fri", affine[:, 1:, 1:], roots)
    points = start[:, None, I, J] + (offsets * size[:, None, None]).reshape(len(net), -1, 4, 3)
    apart = norm(points - net[:, None, I, J]).max(axis=2)
    assert np.nanmin(apart, axis=1).max() < 1e-8
    # half of them and more are the nearest root, too
    found, branch = inner_points(start, normals, centres, size, 10.0)
    nearest = norm(found - net[:, I, J]).max(axis=1) < 1e-8
    assert nearest.mean() > 0.5
    assert set(branch[nearest].tolist()) <= {Branch.ONE_ROOT, Branch.NEAREST_ROOT}


def test_nine_linear_equations_and_three_quadrics_against_derivatives_of_the_patch() -> None:
    net = bumpy_nets(30, 0.04, 7)
    normals, forms, centres = sampled(net)
    start = with_zero_twist(net, normals, forms)
    system, size = system_of(start, normals, centres)
    affine, _ = system.solved_linearly()
    y = 0.2 * np.random.default_rng(8).normal(size=(30, 3))
    offsets = affine[:, 1:, 0] + np.einsum("fik,fk->fi", affine[:, 1:, 1:], y)
    patch = start.copy()
    patch[:, I, J] += (offsets * size[:, None]).reshape(-1, 4, 3)
    jet = BezierQuads(patch).jets(np.full((1, 2), 0.5))
    f, fu, fv, fuu, fuv, fvv = jet.coefficients[:, :, 0]
    N, W = centres.normals, centres.second_forms
    assert norm(f - centres.points).max() < 1e-13
    assert max(np.abs(dot(fu, N)).max(), np.abs(dot(fv, N)).max()) < 1e-12
    assert np.abs(sampled(patch)[1] - forms).max() < 1e-9
    # 36 times the quadrics, in the unit of length: <f_vv, N> + II(f_v, f_v) and so on
    value, _ = values(system.quadrics(affine), y)
    expected = [dot(a, N) + quadratic_form(b, W, c) for a, b, c in ((fvv, fv, fv), (fuu, fu, fu), (fuv, fu, fv))]
    assert np.abs(36.0 * value * size[:, None] - np.stack(expected, axis=1)).max() < 1e-12


def test_offsets_are_the_shortest_that_solve_the_linear_equations() -> None:
    net = bumpy_nets(30, 0.04, 9)
    normals, forms, centres = sampled(net)
    affine, _ = system_of(with_zero_twist(net, normals, forms), normals, centres)[0].solved_linearly()
    gram = np.einsum("fik,fil->fkl", affine[:, 1:], affine[:, 1:])
    gram[:, 0, 0] = 1.0
    assert np.abs(gram - np.eye(4)).max() < 1e-12


@pytest.mark.parametrize("form", [np.diag([1.0, 0.6]), np.diag([1.0, -0.7]), np.array([[0.2, 0.5], [0.5, 0.9]])])
def test_a_paraboloid_over_a_parallelogram_has_two_free_parameters_to_first_order(form: Float) -> None:
    """Why the equations are nearly singular on short edges: a tangential displacement, with the heights it asks for.

    With half sides a, b and e(u, v) = -9/2 uv(1 - u)(1 - v)(alpha t + beta s), alpha perpendicular to form b, beta to
    form a, (s, t) in [-1, 1]^2, the bicubic patch stays on the paraboloid up to the square of the displacement.
    """
    a, b = np.array([0.5, 0.1]), np.array([-0.05, 0.4])
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])

    def height(plane: Float) -> Float:
        return np.asarray(-0.5 * np.einsum("...x,xy,...y->...", plane, form, plane))

    at = (np.stack(np.meshgrid(np.arange(4), np.arange(4), indexing="ij"), axis=-1) / 3.0 - 0.5) * 2.0
    plane = at[..., :1] * a + at[..., 1:] * b
    # the net of z over an affine parametrisation: blossoms of the quadratic function
    net = np.concatenate([plane, np.zeros((4, 4, 1))], axis=-1)
    square = {0: 1.0, 1: -1.0 / 3.0, 2: -1.0 / 3.0, 3: 1.0}  # Bernstein coefficients of s^2
    for i in range(4):
        for j in range(4):
            s, t = at[i, j]
            net[i, j, 2] = -0.5 * (square[i] * a @ form @ a + 2.0 * s * t * a @ form @ b + square[j] * b @ form @ b)
    u = np.linspace(0.0, 1.0, 9)
    samples = np.stack(np.meshgrid(u, u, indexing="ij"), axis=-1).reshape(-1, 2)
    exact = BezierQuads(net[None]).jets(samples, 0).f[0]
    assert np.abs(exact[:, 2] - height(exact[:, :2])).max() < 1e-15

    def off(size: float) -> float:
        alpha, beta = size * turned @ form @ b, -1.3 * size * turned @ form @ a
        w = 0.5 * (a @ form @ alpha + b @ form @ beta)
        e = {(1, 1): alpha + beta, (2, 1): alpha - beta, (1, 2): beta - alpha, (2, 2): -alpha - beta}
        moved = net.copy()
        for (i, j), shift in e.items():
            moved[i, j] += np.array([*(0.5 * shift), w if i == j else -w])
        points = BezierQuads(moved[None]).jets(samples, 0).f[0]
        return float(np.abs(points[:, 2] - height(points[:, :2])).max())

    assert off(1e-2) > 1e-9
    assert off(1e-2) / off(1e-3) == pytest.approx(100.0, rel=0.01)


def test_four_of_eight_roots_come_together_on_short_edges() -> None:
    """At the nearest root two singular values of the Jacobian are of order h, the other is not."""
    dataset, found = registry.dataset("quad-graph"), []
    for level in (1, 3):
        mesh = dataset.mesh(level)
        net = np.array(registry.scheme("zero-twist-bicubic").fit(mesh).batches[0].control_points)  # type: ignore[attr-defined]
        assert mesh.face_data.centres is not None
        system = CentreSystem.of(
            net, mesh.corner_normals()[:, CORNERS], mesh.face_data.centres, np.full(len(net), mesh.h)
        )
        quadrics = system.quadrics(system.solved_linearly()[0])
        quadrics /= np.abs(quadrics).max(axis=(2, 3), keepdims=True)
        root = real_roots(quadrics)[:, 0]
        X = np.concatenate([np.ones((len(root), 1)), root], axis=1)
        sizes = np.linalg.svd(2.0 * np.einsum("nqij,ni->nqj", quadrics[..., 1:], X))[1]
        found.append(np.median(sizes, axis=0))
    assert (found[0][1:] / found[1][1:] > 3.5).all()
    assert found[0][0] / found[1][0] == pytest.approx(1.0, rel=0.2)
