"""S-patches: boundaries, precision, exact derivatives, the patches inside them, and misprints of their formulas."""

from fractions import Fraction
from functools import cache, reduce
from itertools import product
from math import factorial, prod

import numpy as np
import pytest

from testbed.geometry.bernstein import evaluate_curve
from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.polygon_coordinates import regular_polygon
from testbed.geometry.s_patches import SPatches
from testbed.geometry.simplex_bernstein import blossom_table, simplex_multi_indices, simplex_places, simplex_point_count
from testbed.geometry.vectors import Float

SIZES = [(3, 1), (3, 4), (4, 3), (5, 2), (5, 4), (6, 3), (7, 3), (8, 3)]
every_size = pytest.mark.parametrize(("sides", "depth"), SIZES)


def some_patches(sides: int, depth: int, count: int = 3) -> SPatches:
    random = np.random.default_rng(10 * sides + depth)
    return SPatches(random.normal(size=(count, simplex_point_count(sides, depth), 3)), sides, depth)


def some_points(sides: int, count: int = 12) -> Float:
    """Points of the regular polygon: inside, on a side, a corner."""
    weights = np.random.default_rng(sides).dirichlet(np.ones(sides), count)
    weights[0], weights[1] = np.eye(sides)[1], np.eye(sides)[0]
    weights[2] = 0.3 * np.eye(sides)[0] + 0.7 * np.eye(sides)[1]
    return np.asarray(weights @ regular_polygon(sides))


# An implementation of its own: Taylor arithmetic in rational numbers, so that nothing is rounded.


def times(f: list[Fraction], g: list[Fraction]) -> list[Fraction]:
    """Product of two jets f | f_x, f_y | f_xx, f_xy, f_yy."""
    return [
        f[0] * g[0],
        f[1] * g[0] + f[0] * g[1],
        f[2] * g[0] + f[0] * g[2],
        f[3] * g[0] + 2 * f[1] * g[1] + f[0] * g[3],
        f[4] * g[0] + f[1] * g[2] + f[2] * g[1] + f[0] * g[4],
        f[5] * g[0] + 2 * f[2] * g[2] + f[0] * g[5],
    ]


def reciprocal(f: list[Fraction]) -> list[Fraction]:
    r = 1 / f[0]
    x, y = -f[1] * r * r, -f[2] * r * r
    xx, xy, yy = (
        (2 * a * b * r - c) * r * r for a, b, c in ((f[1], f[1], f[3]), (f[1], f[2], f[4]), (f[2], f[2], f[5]))
    )
    return [r, x, y, xx, xy, yy]


def rational_basis(sides: int, depth: int, at: Float) -> Float:
    """Jets (6, N, S) of the basis functions on the regular polygon, rounded once at the end."""
    corners = [[Fraction(c) for c in corner] for corner in regular_polygon(sides).tolist()]
    indices = simplex_multi_indices(sides, depth).tolist()
    one, columns = [Fraction(1), *[Fraction(0)] * 5], []
    for point in at.tolist():
        x, y = map(Fraction, point)
        alpha = []
        for (px, py), (qx, qy) in zip(corners, [*corners[1:], corners[0]], strict=True):
            along_x, along_y = py - qy, qx - px
            value = (x - px) * along_x + (y - py) * along_y
            alpha.append([value, along_x, along_y, Fraction(0), Fraction(0), Fraction(0)])
        # with Wachspress's weights: the corners are rounded, and the polygon is regular to rounding only
        weights = []
        for i in range(sides):
            (ax, ay), (bx, by), (cx, cy) = corners[i - 1], corners[i], corners[(i + 1) % sides]
            weights.append((bx - ax) * (cy - by) - (by - ay) * (cx - bx))
        pi = [
            reduce(times, [alpha[j] for j in range(sides) if j not in (i, (i - 1) % sides)], [weights[i], *one[1:]])
            for i in range(sides)
        ]
        inverse = reciprocal([sum(row, start=Fraction(0)) for row in zip(*pi, strict=True)])
        powers = [[one] for _ in range(sides)]
        for i, _ in product(range(sides), range(depth)):
            powers[i].append(times(powers[i][-1], pi[i]))
        scale = reduce(times, [inverse] * depth)
        column = []
        for s in indices:
            term = reduce(times, [powers[i][k] for i, k in enumerate(s) if k], one)
            count = factorial(depth) // prod(map(factorial, s))
            column.append([float(count * value) for value in times(term, scale)])
        columns.append(column)
    return np.array(columns).transpose(2, 1, 0)


@cache
def exact_jets(sides: int, depth: int) -> Float:
    """Jets (6, P, S, 3) of some patches at some points by rational arithmetic."""
    basis = rational_basis(sides, depth, some_points(sides, 6))
    jets: Float = np.einsum("rns,pni->rpsi", basis, some_patches(sides, depth).control_points)
    return jets


@every_size
def test_derivatives_are_those_of_rational_arithmetic(sides: int, depth: int) -> None:
    patches, at, exact = some_patches(sides, depth), some_points(sides, 6), exact_jets(sides, depth)
    for given in (at, np.broadcast_to(at, (len(patches), *at.shape))):
        error = np.abs(patches.jets(given).coefficients - exact).max(axis=(1, 2, 3))
        assert (error <= 2e-15 * np.abs(exact).max(axis=(1, 2, 3)).clip(1.0)).all()
        assert error.max() < 1e-12


@every_size
def test_they_are_affine_invariant_and_have_linear_precision(sides: int, depth: int) -> None:
    # partition of unity: moved control points move the patch and leave its derivatives
    patches, at = some_patches(sides, depth), some_points(sides)
    moved = SPatches(patches.control_points + np.array([1.0, -2.0, 3.0]), sides, depth).jets(at).coefficients
    difference = moved - patches.jets(at).coefficients
    assert np.abs(difference[0] - [1.0, -2.0, 3.0]).max() < 1e-14
    assert np.abs(difference[1:]).max() < 1e-14 * np.abs(moved).max()
    # control points that are means of corners: the polygon itself
    flat = simplex_multi_indices(sides, depth) @ regular_polygon(sides) / depth
    jet = SPatches(np.pad(flat, ((0, 0), (0, 1)))[None], sides, depth).jets(at)
    assert np.abs(jet.f[0, :, :2] - at).max() < 2e-15
    assert np.abs(jet.fu[0] - [1.0, 0.0, 0.0]).max() < 2e-14
    assert np.abs(jet.fv[0] - [0.0, 1.0, 0.0]).max() < 2e-14
    assert np.abs(jet.coefficients[3:]).max() < 5e-13


@every_size
def test_boundaries_are_bezier_curves(sides: int, depth: int) -> None:
    patches, t = some_patches(sides, depth), np.linspace(0.0, 1.0, 11)
    corners, unit = regular_polygon(sides), np.eye(sides, dtype=np.int64)
    for i in range(sides):
        j = (i + 1) % sides
        places = simplex_places(np.array([(depth - k) * unit[i] + k * unit[j] for k in range(depth + 1)]))
        at = (1.0 - t)[:, None] * corners[i] + t[:, None] * corners[j]
        curve = evaluate_curve(patches.control_points[:, places], t)[0]
        assert np.abs(patches.jets(at, 0).f - curve).max() < 4e-15


@every_size
def test_elevated_patches_are_the_same(sides: int, depth: int) -> None:
    patches, at = some_patches(sides, depth), some_points(sides)
    jets = patches.jets(at).coefficients
    elevated = patches.elevated(2)
    assert elevated.depth == depth + 2
    assert np.abs(elevated.jets(at).coefficients - jets).max() < 1e-14 * np.abs(jets).max()


@pytest.mark.parametrize("degree", [1, 3, 6])
def test_three_sides_are_a_bezier_triangle(degree: int) -> None:
    triangles = BezierTriangles(some_patches(3, degree).control_points)
    at = np.random.default_rng(5).dirichlet(np.ones(3), 30)[:, 1:]
    ours, theirs = SPatches.from_triangles(triangles).jets(at).coefficients, triangles.jets(at).coefficients
    assert np.abs(ours - theirs)[0].max() < 9e-16
    assert np.abs(ours - theirs).max() < 1e-15 * max(1.0, float(np.abs(theirs).max()))
    # over the regular triangle the net is the same, and so are the points
    corners = regular_polygon(3)
    regular = corners[0] + at @ (corners[1:] - corners[0])
    assert np.abs(some_patches(3, degree).jets(regular, 0).f - triangles.jets(at, 0).f).max() < 2e-15
    assert np.array_equal(some_patches(3, degree).as_triangles().control_points, triangles.control_points)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_tensor_product_patches_are_inside_four_sides(degree: int) -> None:
    points = np.random.default_rng(degree).uniform(-1.0, 1.0, (4, degree + 1, degree + 1, 3))
    quads = BezierQuads(points)
    patches = SPatches.from_quads(quads)
    assert patches.depth == degree
    assert len(np.unique(patches.control_points[0], axis=0)) == (degree + 1) ** 2
    at = np.random.default_rng(6).random((40, 2))
    ours, theirs = patches.jets(at).coefficients, quads.jets(at).coefficients
    assert np.abs(ours - theirs)[0].max() <= 4.5e-16
    assert np.abs(ours - theirs).max() < 2e-15 * max(1.0, float(np.abs(theirs).max()))


def test_tensor_product_patches_with_two_degrees_are_refused() -> None:
    with pytest.raises(ValueError, match=r"bidegree \(2, 3\)"):
        SPatches.from_quads(BezierQuads(np.zeros((1, 3, 4, 3))))


def test_irregular_polygons_have_exact_derivatives_too() -> None:
    # two affine images of a regular polygon and the same patches over them: the coordinates are affine invariant
    patches, at = some_patches(6, 3), some_points(6)
    matrix, shift = np.array([[2.0, 0.5], [-0.3, 1.0]]), np.array([3.0, -1.0])
    image = SPatches(patches.control_points, 6, 3, regular_polygon(6) @ matrix.T + shift)
    jet, expected = image.jets(at @ matrix.T + shift), patches.jets(at)
    along = [jet.fu * matrix[0, z] + jet.fv * matrix[1, z] for z in range(2)]
    assert jet.f == pytest.approx(expected.f, abs=1e-14)
    assert along[0] == pytest.approx(expected.fu, abs=1e-13)
    assert along[1] == pytest.approx(expected.fv, abs=1e-13)


@pytest.mark.parametrize(("sides", "depth"), [(4, 3), (5, 6)])
def test_no_bit_depends_on_what_is_evaluated_together(sides: int, depth: int) -> None:
    patches, at = some_patches(sides, depth, 40), some_points(sides, 50)
    chosen = np.array([7, 3, 31])
    shared = patches.jets(at).coefficients
    assert np.array_equal(patches.take(chosen).jets(at).coefficients, shared[:, chosen])
    assert np.array_equal(patches.jets(at[:9]).coefficients, shared[:, :, :9])
    own = np.broadcast_to(at, (40, *at.shape))
    together = patches.jets(own).coefficients
    assert np.array_equal(patches.take(chosen).jets(own[:3]).coefficients, together[:, chosen])
    assert np.array_equal(patches.jets_of(chosen, at[:3]).coefficients, together[:, chosen, np.arange(3)])
    assert np.array_equal(patches.jets_of(chosen, at[:3], 1).coefficients, together[:3, chosen, np.arange(3)])
    assert np.abs(together - shared).max() < 1e-14 * np.abs(shared).max()


def test_bad_nets_are_refused_in_one_sentence() -> None:
    good = np.zeros((1, 20, 3))
    for arguments, text in (
        ((good[:, :19], 4, 3), r"control points \(P, 20, 3\), not \(1, 19, 3\)"),
        ((good[0], 4, 3), r"not \(20, 3\)"),
        ((good, 5, 3), r"5 sides and depth 3 have control points \(P, 35, 3\)"),
        ((good, 2, 3), "3 sides or more, not 2"),
        ((good[:, :1], 4, 0), "depth 1 or more, not 0"),
        ((good, 4, 3, regular_polygon(5)), r"has 4 corners \(n, 2\), not \(5, 2\)"),
        ((good, 4, 3, regular_polygon(4)[::-1]), "strictly convex polygon, counterclockwise"),
        ((good, 4, 3, np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]])), "strictly convex"),
    ):
        with pytest.raises(ValueError, match=text) as caught:
            SPatches(*arguments)
        assert "\n" not in str(caught.value)
    pentagram = regular_polygon(5)[[0, 2, 4, 1, 3]]  # turns left everywhere, twice around
    with pytest.raises(ValueError, match="strictly convex"):
        SPatches(np.zeros((1, 5, 3)), 5, 1, pentagram)


# The formulas of Mann 1992, appendix B and section 5.4.3, with what is printed where it is wrong.


def appendix_xx(sides: int, depth: int, at: Float, *, inner: str, last_factor: int) -> Float:
    """D_xx S (P, S, 3) by the appendix; ``inner``: what the products of D_x pi multiply, "pi" as printed or "alpha"."""
    p = regular_polygon(sides)
    q = np.roll(p, -1, axis=0)
    slope = (p - q)[:, 1]
    alpha = slope[:, None] * at[:, 0] + (q - p)[:, :1] * at[:, 1] + (p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1])[:, None]
    kept = [[j for j in range(sides) if j not in (i, (i - 1) % sides)] for i in range(sides)]
    pi = np.stack([np.prod(alpha[js], axis=0) for js in kept])
    factor = pi if inner == "pi" else alpha

    def without(js: list[int], *left_out: int) -> Float:
        return np.asarray(np.prod(factor[[k for k in js if k not in left_out]], axis=0))

    x = np.stack([sum(slope[j] * without(js, j) for j in js) for js in kept])
    xx = np.stack([sum(slope[j] * slope[k] * without(js, j, k) for j in js for k in js if k != j) for js in kept])
    P, P_x, P_xx = pi.sum(axis=0), x.sum(axis=0), xx.sum(axis=0)
    L, L_x = pi / P, (x * P - pi * P_x) / P**2
    L_xx = 2 * pi * P_x**2 / P**3 - 2 * x * P_x / P**2 - pi * P_xx / P**2 + xx / P
    net = some_patches(sides, depth).control_points
    blossom = [blossom_table([u, w, *[L] * (depth - 2)]) for u, w in ((L_x, L_x), (L_xx, L))]
    table = depth * (depth - 1) * blossom[0] + last_factor * blossom[1]
    result: Float = np.einsum("ns,pni->psi", table, net)
    return result


@pytest.mark.parametrize(("sides", "depth"), [(4, 3), (5, 4), (6, 3)])
def test_the_appendix_holds_with_alpha_and_the_depth_and_fails_as_printed(sides: int, depth: int) -> None:
    at, exact = some_points(sides, 6), exact_jets(sides, depth)[3]
    scale = np.abs(exact).max()

    def error(inner: str, last_factor: int) -> float:
        return float(np.abs(appendix_xx(sides, depth, at, inner=inner, last_factor=last_factor) - exact).max() / scale)

    assert error("alpha", depth) < 1e-14
    assert error("pi", depth) > 0.1
    assert error("alpha", sides) > 0.01


def test_the_degree_of_the_simplex_map_is_the_number_of_control_points() -> None:
    # section 5.4.3 says n-simplex, whose nets would have C(n + d, d) points; appendix B says (n - 1)-simplex
    assert [simplex_point_count(n, d) for n, d in ((3, 6), (4, 3), (5, 6), (6, 6))] == [28, 20, 210, 462]
