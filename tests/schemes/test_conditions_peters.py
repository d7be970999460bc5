"""Peters' conditions: one row on a quadratic boundary, both rows on a cubic one, and when there are none."""

from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.vectors import Float, cross, dot, norm, tangential, unit
from testbed_schemes.continuity_conditions.chiyokura_kimura import cross_boundary_points
from testbed_schemes.continuity_conditions.peters import CubicJoin, quadratic_boundary_point

T = np.linspace(0.0, 1.0, 21)
seeds = st.integers(0, 2**32 - 1)


def bernstein(coefficients: Float, t: Float = T) -> Float:
    """A Bezier curve with coefficients (n + 1, ...) at the parameters t."""
    n = len(coefficients) - 1
    basis = np.stack([comb(n, r) * t**r * (1.0 - t) ** (n - r) for r in range(n + 1)], axis=-1)
    values: Float = basis @ coefficients
    return values


class EdgeCase:
    """A boundary with end normals, and the legs of two patches on its two sides, in the tangent planes."""

    def __init__(self, seed: int, degree: int = 3) -> None:
        self.rng = np.random.default_rng(seed)
        points = np.cumsum(self.rng.normal(loc=(1.5, 0.0, 0.0), scale=0.5, size=(degree + 1, 3)), axis=0)
        self.curve = points if degree == 3 else elevate_curve(points)
        self.v = np.diff(self.curve, axis=0)
        self.n0 = unit(tangential(np.array([0.0, 0.0, 1.0]) + self.rng.normal(scale=0.3, size=3), unit(self.v[0])))
        self.n1 = unit(tangential(np.array([0.0, 0.0, 1.0]) + self.rng.normal(scale=0.3, size=3), unit(self.v[2])))

    def legs(self, side: float) -> tuple[Float, Float]:
        """F0 - H0 and F2 - H3 of a patch on one side (1 or -1)."""
        start = self.rng.uniform(0.2, 1.0) * self.v[0] + side * self.rng.uniform(0.2, 1.0) * cross(self.n0, self.v[0])
        end = -self.rng.uniform(0.2, 1.0) * self.v[2] + side * self.rng.uniform(0.2, 1.0) * cross(self.n1, self.v[2])
        return start, end

    def row(self, legs: tuple[Float, Float], middle: Float) -> Float:
        """F_r - H_r, (3, 3)."""
        return np.stack([legs[0], middle - self.curve[1], legs[1] + self.v[2]])

    def alone(self, legs: tuple[Float, Float]) -> Float:
        """The row by (2.8)."""
        return self.row(legs, quadratic_boundary_point(self.curve, *legs, self.n0, self.n1))

    def alone_from_the_other_end(self, legs: tuple[Float, Float]) -> Float:
        middle = quadratic_boundary_point(self.curve[::-1], legs[1], legs[0], self.n1, self.n0)
        return self.row(legs, middle)

    def join(self, f: tuple[Float, Float], g: tuple[Float, Float]) -> CubicJoin:
        return CubicJoin.between(self.curve, f, g, (self.n0, self.n1))

    def largest_determinant(self, f: Float, g: Float) -> float:
        """Of det(H', F, G) along the edge, over the product of the fields' sizes."""
        h, f, g = bernstein(self.v), bernstein(f), bernstein(g)
        size = np.prod([norm(field).max() for field in (h, f, g)])
        return float(np.abs(dot(h, cross(f, g))).max() / size)


def mirrored(seed: int, degree: int = 3) -> tuple[EdgeCase, tuple[Float, Float], tuple[Float, Float]]:
    """A cubic in a plane and two patches that are mirror images in that plane: b_0 = b_1 = 1 / 2."""
    edge = EdgeCase(seed, degree)
    edge.curve[:, 1] = 0.0
    edge.v = np.diff(edge.curve, axis=0)
    across = np.array([0.0, 1.0, 0.0])
    edge.n0, edge.n1 = unit(cross(edge.v[0], across)), unit(cross(edge.v[2], across))
    f = edge.legs(1.0)
    g = (f[0] * [1.0, -1.0, 1.0], f[1] * [1.0, -1.0, 1.0])
    return edge, f, g


@given(seeds)
def test_rows_along_a_quadratic_share_its_tangent_planes_and_read_nothing_else(seed: int) -> None:
    edge = EdgeCase(seed, degree=2)
    assert edge.largest_determinant(edge.alone(edge.legs(1.0)), edge.alone(edge.legs(-1.0))) < 1e-13
    assert edge.largest_determinant(edge.alone(edge.legs(1.0)), edge.alone_from_the_other_end(edge.legs(-1.0))) < 1e-13


@given(seeds)
def test_a_row_along_a_quadratic_is_k_c_plus_h_v(seed: int) -> None:
    edge = EdgeCase(seed, degree=2)
    legs = edge.legs(1.0)
    f = edge.alone(legs)
    across = np.stack([cross(edge.n0, edge.v[0]), cross(edge.n1, edge.v[2])])
    ends = f[[0, 2]]
    k = dot(ends, across) / dot(across, across)
    h = dot(ends, edge.v[[0, 2]]) / dot(edge.v[[0, 2]], edge.v[[0, 2]])
    field = bernstein(k)[:, None] * bernstein(across) + bernstein(h)[:, None] * bernstein(edge.v[[0, 2]])
    assert bernstein(f) == pytest.approx(field, abs=1e-12)


@given(seeds)
def test_the_row_does_not_depend_on_the_direction_of_the_edge(seed: int) -> None:
    edge = EdgeCase(seed, degree=2)
    legs = edge.legs(1.0)
    # at the other end F1 is measured from H2, and the result is the same point
    assert edge.alone_from_the_other_end(legs) == pytest.approx(edge.alone(legs), abs=1e-12)


@given(seeds)
def test_a_cubic_boundary_needs_more_than_the_quadratic_rule(seed: int) -> None:
    edge = EdgeCase(seed)
    edge.curve[1] += [0.0, 0.0, 0.3]  # away from a quadratic, whatever the seed
    edge.curve[2] -= [0.0, 0.0, 0.3]
    edge.v = np.diff(edge.curve, axis=0)
    edge.n0, edge.n1 = (unit(tangential(n, unit(v))) for n, v in ((edge.n0, edge.v[0]), (edge.n1, edge.v[2])))
    assert edge.largest_determinant(edge.alone(edge.legs(1.0)), edge.alone(edge.legs(-1.0))) > 1e-6


@given(seeds)
def test_on_a_quadratic_with_equal_legs_the_row_raised_is_that_of_chiyokura_and_kimura(seed: int) -> None:
    edge = EdgeCase(seed, degree=2)
    first, last = edge.v[0], edge.v[2] * norm(edge.v[0]) / norm(edge.v[2])
    quadratic = np.stack([np.zeros(3), 1.5 * first, 1.5 * (first + last)])
    edge.curve = elevate_curve(quadratic)
    edge.v = np.diff(edge.curve, axis=0)
    legs = edge.legs(1.0)
    row = edge.alone(legs) + edge.curve[:3]  # a cubic's second row F_0, F_1, F_2
    raised = np.stack([raised_row_point(edge.curve, row, r) for r in range(4)])
    start, end = raised[0] - edge.curve[0], raised[3] - edge.curve[3]
    expected = cross_boundary_points(edge.curve, start, end, edge.n0, edge.n1)
    assert raised[1:3] == pytest.approx(np.stack(expected), abs=1e-12)


def raised_row_point(curve: Float, row: Float, r: int) -> Float:
    """Point r of the second row of the quartic: (3 - r) F_r / 4 + r F_{r-1} / 4 + H_r / 4."""
    own = (3 - r) * row[r] if r < 3 else np.zeros(3)
    before = r * row[r - 1] if r > 0 else np.zeros(3)
    point: Float = (own + before + curve[r]) / 4.0
    return point


@given(seeds)
def test_both_rows_along_a_cubic_satisfy_the_linear_relation_and_so_share_tangent_planes(seed: int) -> None:
    edge = EdgeCase(seed)
    f, g = edge.legs(1.0), edge.legs(-1.0)
    join = edge.join(f, g)
    if abs(float(join.determinant)) < 1e-3:
        return
    rows = [edge.row(legs, middle) for legs, middle in zip((f, g), join.points(), strict=True)]
    assert edge.largest_determinant(*rows) < 1e-13
    a, b = np.array(join.a), np.array(join.b)
    left = bernstein(a)[:, None] * bernstein(edge.v)
    right = bernstein(b)[:, None] * bernstein(rows[0]) + bernstein(1.0 - b)[:, None] * bernstein(rows[1])
    assert left == pytest.approx(right, abs=1e-13 * (1.0 + norm(rows[0]).max()))
    # b and c do not vanish: the patches stay on their sides, and their normals agree in orientation
    assert (b > 0.0).all()
    assert (b < 1.0).all()


@given(seeds)
def test_the_join_does_not_depend_on_sides_and_direction(seed: int) -> None:
    edge = EdgeCase(seed)
    f, g = edge.legs(1.0), edge.legs(-1.0)
    join, swapped = edge.join(f, g), edge.join(g, f)
    back = CubicJoin.between(edge.curve[::-1], f[::-1], g[::-1], (edge.n1, edge.n0))
    assert float(swapped.determinant) == pytest.approx(-float(join.determinant), abs=1e-14)
    assert float(back.determinant) == pytest.approx(-float(join.determinant), abs=1e-14)
    if abs(float(join.determinant)) > 1e-3:
        expected = np.stack(join.points())
        size = 1.0 + np.abs(expected).max()
        assert np.stack(swapped.points()[::-1]) == pytest.approx(expected, abs=1e-12 * size)
        # seen from the other end H_2 takes the place of H_1, and the points stay
        assert np.stack(back.points()) == pytest.approx(expected, abs=1e-12 * size)


def meeting(a: Float, b: Float, c: Float, d: Float) -> tuple[float, float]:
    """Where the lines a b and c d meet: the ratios a P / b P and c P / d P, unsigned."""
    s, t = np.linalg.lstsq(np.stack([b - a, c - d], axis=-1), c - a, rcond=None)[0]
    return float(abs(s / (1.0 - s))), float(abs(t / (1.0 - t)))


@given(seeds)
def test_the_determinant_vanishes_where_the_printed_ratios_are_equal(seed: int) -> None:
    """Mann 1992: F_0 P / G_0 P = F_2 Q / G_2 Q, with P on H_0 H_1 and Q on H_2 H_3."""
    edge = EdgeCase(seed)
    f, g = edge.legs(1.0), edge.legs(-1.0)
    join = edge.join(f, g)
    h, q = edge.curve, edge.v[2]
    along0, across0 = meeting(h[0], h[1], h[0] + f[0], h[0] + g[0])
    along1, across1 = meeting(h[2], h[3], h[3] + f[1], h[3] + g[1])
    c = [1.0 - b for b in join.b]
    # F P / G P = c / b at either end, H_0 P / H_1 P = a / |1 - a|
    assert across0 == pytest.approx(float(c[0] / join.b[0]), rel=1e-9)
    assert across1 == pytest.approx(float(c[1] / join.b[1]), rel=1e-9)
    assert along0 == pytest.approx(abs(float(join.a[0] / (1.0 - join.a[0]))), rel=1e-6)
    assert along1 == pytest.approx(abs(float(join.a[1] / (1.0 - join.a[1]))), rel=1e-6)
    determinant = float(join.b[0] * join.b[1] * (across1 - across0))
    assert float(join.determinant) == pytest.approx(determinant, abs=1e-9)
    # now the second patch's far leg is changed until the ratios agree
    ratio = across0 / across1
    equal = (g[0], tangential(g[1], unit(q)) / ratio + dot(g[1], unit(q)) * unit(q))
    assert abs(float(edge.join(f, equal).determinant)) < 1e-13


@given(seeds)
def test_mirror_images_across_a_cubic_have_no_solution_at_all(seed: int) -> None:
    """As on the octahedron; no placement of F1 and G1 satisfies both equations."""
    edge, f, g = mirrored(seed)
    join = edge.join(f, g)
    assert abs(float(join.determinant)) < 1e-14
    r, s = join.right_sides()
    contradiction = float(norm(join.contradiction))
    assert float(norm(r - s)) == pytest.approx(contradiction, abs=1e-13)
    (b0, b1), unknowns = join.b, np.kron(np.ones((2, 2)), np.eye(3))
    unknowns[:, :3] *= np.repeat([2.0 * b0, 2.0 * b1], 3)[:, None]
    unknowns[:, 3:] *= np.repeat([2.0 - 2.0 * b0, 2.0 - 2.0 * b1], 3)[:, None]
    best = np.linalg.lstsq(unknowns, np.concatenate([r, s]), rcond=1e-12)[0]
    assert float(norm(unknowns @ best - np.concatenate([r, s]))) == pytest.approx(contradiction / 2**0.5, abs=1e-12)


@given(seeds)
def test_mirror_images_do_not_contradict_each_other_where_the_second_ratios_are_equal(seed: int) -> None:
    """H_0 P / H_1 P = H_2 Q / H_3 Q, that is a_0 = a_1."""
    edge, f, g = mirrored(seed)
    join = edge.join(f, g)
    shift = (join.a[0] - join.a[1]) * edge.v[2]
    r, s = edge.join((f[0], f[1] + shift), (g[0], g[1] + shift)).right_sides()
    assert norm(r - s) < 1e-12


@given(seeds)
def test_mirror_images_do_not_contradict_each_other_across_a_quadratic(seed: int) -> None:
    edge, f, g = mirrored(seed, degree=2)
    r, s = edge.join(f, g).right_sides()
    assert norm(r - s) < 1e-12


def test_an_edge_without_an_end_tangent_gives_nan_and_no_point() -> None:
    edge = EdgeCase(3)
    f, g = edge.legs(1.0), edge.legs(-1.0)
    edge.curve[1] = edge.curve[0]
    assert np.isnan(quadratic_boundary_point(edge.curve, *f, edge.n0, edge.n1)).all()
    assert np.isnan(np.stack(edge.join(f, g).points())).all()


@given(seeds)
def test_a_batch_gives_what_its_edges_give_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve, legs, normals = rng.normal(size=(6, 4, 3)), rng.normal(size=(4, 6, 3)), unit(rng.normal(size=(2, 6, 3)))
    rows = quadratic_boundary_point(curve, legs[0], legs[1], normals[0], normals[1])
    join = CubicJoin.between(curve, (legs[0], legs[1]), (legs[2], legs[3]), (normals[0], normals[1]))
    points = np.stack(join.points())
    legs, normals = legs[:, 4], normals[:, 4]
    alone = CubicJoin.between(curve[4], (legs[0], legs[1]), (legs[2], legs[3]), (normals[0], normals[1]))
    assert np.array_equal(rows[4], quadratic_boundary_point(curve[4], legs[0], legs[1], normals[0], normals[1]))
    assert np.array_equal(points[:, 4], np.stack(alone.points()))
