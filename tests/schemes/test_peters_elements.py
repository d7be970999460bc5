"""The split element as a linear system, solved blindly: Clough-Tocher-type G1 is Peters with cubics, Jensen with
quartics, and the functional Clough-Tocher element is a split cubic on edges where Peters' system is singular."""

import numpy as np
import pytest
from scipy.interpolate import CloughTocher2DInterpolator
from scipy.spatial import Delaunay

from testbed.conformance.meshes import graph, icosahedron, octahedron, perturbed_icosahedron, torus
from testbed.geometry.bernstein import triangle_tables
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.domain import lattice, side_points
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm, unit
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.peters import CubicJoin, quadratic_boundary_point
from testbed_schemes.jensen import Jensen
from testbed_schemes.mathematics.split_domain import J, K, c1_cubics
from testbed_schemes.peters import Peters, legs_by_edge, spoke_legs

#: More samples of an edge than the degree of anything on it.
T = np.linspace(0.0, 1.0, 6)
#: Parameters on the sides of the sub-patches: the edge, V_k to S, and S to V_j.
EDGE, OUTWARD, INWARD = (side_points(3, np.array([side]), T)[0] for side in range(3))
#: Place of N_i in a quartic sub-patch.
INNER = 8

MESHES = {
    "octahedron": octahedron(),
    "icosahedron": icosahedron(),
    "perturbed": perturbed_icosahedron(),
    "torus": torus(10, 5, 3),
}


class System:
    """Equations for the 3 n control points of a split face and for the coefficients of fields along its edges."""

    def __init__(self, degree: int) -> None:
        self.count = (degree + 1) * (degree + 2) // 2
        self.tables = {
            name: triangle_tables(degree, at, 1) for name, at in zip("eoi", (EDGE, OUTWARD, INWARD), strict=True)
        }
        self.points = 9 * self.count
        self.rows: list[Float] = []
        self.right: list[float] = []

    def row(self, *terms: tuple[int, Float, float], axis: int) -> Float:
        """Coefficients of one coordinate of a sum of (sub-patch, weights of its control points, factor)."""
        result = np.zeros(self.points + 12)
        for patch, weights, factor in terms:
            places = (patch * self.count + np.arange(self.count)) * 3 + axis
            result[places] += factor * weights
        return result

    def add(self, row: Float, right: float) -> None:
        self.rows.append(row)
        self.right.append(right)

    def interpolate(self, patch: int, edge: Float) -> None:
        """The sub-patch has the curve's points (S, 3) on its edge."""
        for weights, point in zip(self.tables["e"][0], edge, strict=True):
            for axis in range(3):
                self.add(self.row((patch, weights, 1.0), axis=axis), float(point[axis]))

    def join(self, patch: int) -> None:
        """Position and derivatives by the face's parameters agree on the spoke from V_k to S with the next patch."""
        after = (patch + 1) % 3
        for s in range(len(T)):
            here = self.tables["o"][:, s]  # value, d/du, d/dv of the patch with corners V_j, V_k, S
            there = self.tables["i"][:, len(T) - 1 - s]  # and of that with V_k, V_i, S, whose side runs back
            for axis in range(3):
                self.add(self.row((patch, here[0], 1.0), (after, there[0], -1.0), axis=axis), 0.0)
                # along V_k V_i, the neighbour's own u; in this patch V_i = 3 S - V_j - V_k
                towards = 3.0 * here[2] - 2.0 * here[1]
                self.add(self.row((after, there[1], 1.0), (patch, towards, -1.0), axis=axis), 0.0)

    def field(self, patch: int, across: Float, along: Float) -> None:
        """Towards S the derivative is k C + h V along the edge, k and h linear and unknown; C and V are (S, 3)."""
        for s, t in enumerate(T):
            for axis in range(3):
                row = self.row((patch, self.tables["e"][2, s], 1.0), axis=axis)
                place = self.points + 4 * patch
                row[place : place + 4] = -np.concatenate(
                    [across[s, axis] * np.array([1.0 - t, t]), along[s, axis] * np.array([1.0 - t, t])]
                )
                self.add(row, 0.0)

    def set_point(self, patch: int, place: int, value: Float) -> None:
        weights = np.eye(self.count)[place]
        for axis in range(3):
            self.add(self.row((patch, weights, 1.0), axis=axis), float(value[axis]))

    def solve(self) -> tuple[Float, float, int]:
        """The least-squares solution (3, n, 3), its largest residual, and how many unknowns are left open."""
        matrix, right = np.array(self.rows), np.array(self.right)
        solution, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=1e-12)
        residual = float(np.abs(matrix @ solution - right).max())
        return solution[: self.points].reshape(3, self.count, 3), residual, matrix.shape[1] - int(rank)


def curve_points(curves: Float) -> tuple[Float, Float]:
    """Points and derivatives over 3 (S, 3) at T of a cubic (4, 3)."""
    t = T[:, None]
    v = np.diff(curves, axis=0)
    along = (1 - t) ** 2 * v[0] + 2 * t * (1 - t) * v[1] + t**2 * v[2]
    points = (1 - t) ** 3 * curves[0] + 3 * t * (1 - t) ** 2 * curves[1] + 3 * t**2 * (1 - t) * curves[2]
    return points + t**3 * curves[3], along


def blind_solution(degree: int, curves: Float, normals: Float, inner: Float | None) -> tuple[Float, float, int]:
    """Set up and solve the system of one face: curves (3, 4, 3) opposite its corners, normals (3, 3) by corner."""
    system = System(degree)
    for i in range(3):
        points, along = curve_points(curves[i])
        system.interpolate(i, points)
        system.join(i)
        ends = cross(normals[[J[i], K[i]]], np.stack([curves[i, 1] - curves[i, 0], curves[i, 3] - curves[i, 2]]))
        ends = ends if degree == 3 else unit(ends)
        system.field(i, (1.0 - T)[:, None] * ends[0] + T[:, None] * ends[1], along)
        if inner is not None:
            system.set_point(i, INNER, inner[i])
    return system.solve()


def own_nets(surface: Surface) -> Float:
    """Control points (F, 3, n, 3) of a surface of one batch."""
    (batch,) = surface.batches
    assert isinstance(batch, BezierTriangles)
    return batch.control_points.reshape(-1, 3, *batch.control_points.shape[1:])


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())
def test_the_cubic_element_is_peters_with_quadratics(mesh: HermiteMesh) -> None:
    """C1 joins inside, fields of tangent planes with unnormalised C on the edges: one solution, and it is Peters'."""
    surface = Peters().fit(mesh)
    curves, normals, nets = PetersCurve().network(mesh).opposite_vertices(), mesh.corner_normals(), own_nets(surface)
    assert nets.shape[2] == 10
    for face in range(0, len(nets), 7):
        found, residual, open_unknowns = blind_solution(3, curves[face], normals[face], None)
        assert residual < 1e-13
        assert open_unknowns == 0
        assert found == pytest.approx(nets[face], abs=1e-12)


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())
def test_the_quartic_element_is_jensens_up_to_the_inner_points(mesh: HermiteMesh) -> None:
    """C1 joins inside, Chiyokura-Kimura fields on the edges: the three N_i stay open, nothing else does."""
    curves, normals = Projected().network(mesh).opposite_vertices(), mesh.corner_normals()
    nets = own_nets(Jensen().fit(mesh))
    for face in range(0, len(nets), 7):
        assert blind_solution(4, curves[face], normals[face], None)[2] == 9
        found, residual, open_unknowns = blind_solution(4, curves[face], normals[face], nets[face, :, INNER])
        assert residual < 1e-13
        assert open_unknowns == 0
        assert found == pytest.approx(nets[face], abs=1e-12)


def test_cubic_curves_leave_the_cubic_element_no_fields_of_its_own() -> None:
    """With Chiyokura and Kimura's fields on projected cubics the system contradicts itself: quartics are needed."""
    mesh = MESHES["perturbed"]
    curves = Projected().network(mesh).opposite_vertices()
    assert blind_solution(3, curves[0], mesh.corner_normals()[0], None)[1] > 1e-3


class Functional:
    """Heights and gradients over a random plane triangulation, with Clough and Tocher's interpolant of them."""

    def __init__(self, degree: int) -> None:
        rng = np.random.default_rng(4)
        triangulation = Delaunay(rng.uniform(-1.0, 1.0, (14, 2)))
        coefficients = 0.3 * rng.normal(size=(4, 4))
        i, j = np.indices((4, 4))
        coefficients[i + j > degree] = 0.0
        x, y = triangulation.points.T
        self.mesh = graph(x, y, triangulation.simplices.astype(np.int64), coefficients)
        assert self.mesh.normals is not None
        self.normals = self.mesh.normals
        gradient = -self.normals[:, :2] / self.normals[:, 2:]
        self.interpolant = CloughTocher2DInterpolator(triangulation, self.mesh.points[:, 2])
        # where it keeps the gradients that it estimates; it takes none
        self.interpolant.grad = np.ascontiguousarray(gradient[:, None])  # type: ignore[attr-defined]  # not in the stubs
        # edges with a linear parameter over the plane, and the slopes of the gradients
        start, end = (self.mesh.points[self.mesh.edges[:, k]] for k in (0, 1))
        chord = (end - start) / 3.0
        legs = [chord.copy(), chord.copy()]
        for k in (0, 1):
            legs[k][:, 2] = (gradient[self.mesh.edges[:, k]] * chord[:, :2]).sum(axis=1)
        control_points = np.stack([start, start + legs[0], end - legs[1], end], axis=1)
        self.network = CurveNetwork(self.mesh, control_points)

    def sub_patch_heights(self) -> Float:
        """Bezier heights (F, 3, 10) of the interpolant's cubics, from its values at ten points in each."""
        at = 0.03 + 0.9 * lattice(3, 3)
        table = triangle_tables(3, at, 0)[0]
        corners = self.mesh.corner_points()[..., :2]
        centre = corners.mean(axis=1)[:, None]
        heights = []
        for i in range(3):
            first, second = corners[:, J[i], None], corners[:, K[i], None]
            points = first + at[:, :1] * (second - first) + at[:, 1:] * (centre - first)
            heights.append(np.linalg.solve(table, self.interpolant(points.reshape(-1, 2)).reshape(-1, 10).T).T)
        return np.stack(heights, axis=1)

    def cross_points(self) -> Float:
        """Q_i of the interpolant, (F, 3, 3)."""
        curves = self.network.opposite_vertices()
        middle: Float = (curves[:, :, 1] + curves[:, :, 2] + self.mesh.corner_points().mean(axis=1)[:, None]) / 3.0
        middle[..., 2] = self.sub_patch_heights()[:, :, 4]
        return middle

    def joins(self) -> tuple[Bool, CubicJoin]:
        """Which edges are between two faces, and Peters' system there."""
        inner = ~self.mesh.boundary_edges
        legs = legs_by_edge(self.mesh, spoke_legs(self.network.opposite_vertices()))[:, :, inner]
        ends = self.mesh.edges[inner]
        normals = (self.normals[ends[:, 0]], self.normals[ends[:, 1]])
        f, g = (tuple(one) for one in legs)
        return inner, CubicJoin.between(self.network.control_points[inner], (f[0], f[1]), (g[0], g[1]), normals)


@pytest.mark.parametrize("degree", [2, 3, 6])
def test_the_functional_element_is_a_split_cubic(degree: int) -> None:
    one = Functional(degree)
    nets = c1_cubics(one.network.opposite_vertices(), one.cross_points())
    assert nets[..., 2] == pytest.approx(one.sub_patch_heights(), abs=1e-13)


@pytest.mark.parametrize("degree", [2, 3, 6])
def test_the_functional_element_solves_peters_singular_system(degree: int) -> None:
    """Over a plane the sides' widths have one ratio on the whole edge: singular, and free of contradiction.

    So Peters' construction for cubic edges, which wants a regular system, never is Clough and Tocher's; that one is the
    solution whose derivative along the line of the two centroids is linear.
    """
    one = Functional(degree)
    inner, join = one.joins()
    assert np.abs(join.determinant).max() < 1e-14
    assert np.abs(join.contradiction).max() < 1e-14
    by_side = np.full((2, len(inner), 3), np.nan)
    mesh = one.mesh
    side = np.where(mesh.face_edge_forward, 0, 1)
    by_side[np.roll(side, -1, axis=1), np.roll(mesh.face_edges, -1, axis=1)] = one.cross_points()
    f, g = by_side[:, inner] - one.network.control_points[inner, 1]
    (r, s), (b0, b1) = join.right_sides(), (b[:, None] for b in join.b)
    assert 2.0 * b0 * f + 2.0 * (1.0 - b0) * g == pytest.approx(r, abs=1e-13)
    assert 2.0 * b1 * f + 2.0 * (1.0 - b1) * g == pytest.approx(s, abs=1e-13)


def test_the_quadratic_rule_is_not_the_functional_element_even_on_quadratics() -> None:
    """Clough and Tocher's element is the quadratic itself; (2.8) turns its field of planes linearly in space."""
    one = Functional(2)
    curves, normals = one.network.opposite_vertices(), one.mesh.corner_normals()
    legs = spoke_legs(curves)
    points = quadratic_boundary_point(curves, legs[:, J], legs[:, K], normals[:, J], normals[:, K])
    off = norm(points - one.cross_points()).max()
    assert 1e-4 < off < 1e-1
