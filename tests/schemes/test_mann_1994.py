"""The second report (Mann, CS-94-33): what the free parameters of Shirman and Sequin's scheme cannot do.

Its appendix A: linear precision, with the three patches of an example. Appendix B: a quadratic patch whose
cross-boundary points neither Chiyokura and Kimura nor Jensen reproduce. Section 4: the curvature of the inner
boundaries and the mixed partials at the vertices do not depend on beta and c.
"""

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.bernstein import elevate_triangle
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, dot, unit
from testbed_schemes.continuity_conditions.chiyokura_kimura import cross_boundary_points

#: Appendix A.1, one of the three patches as printed, each row from the spoke of one vertex to that of the other.
PRINTED = (
    ((1.0, 0.0), (0.75, 0.0), (0.5, 0.0), (0.25, 0.0), (0.0, 0.0)),
    ((5 / 6, 1 / 12), (7 / 12, 1 / 12), (1 / 3, 1 / 12), (1 / 12, 1 / 12)),
    ((2 / 3, 1 / 6), (5 / 12, 1 / 6), (1 / 6, 1 / 6)),
    ((0.5, 0.25), (0.25, 0.25)),
    ((1 / 3, 1 / 3),),
)
#: Appendix B: the quadratic patch, 200 110 101 020 011 002, its boundary from (0, 0, 0) to (3, 0, 0) being 200 110 020.
QUADRATIC = np.array([[0.0, 0, 0], [1.5, 0, 3], [0.75, 2, 0], [3.0, 0, 0], [2.25, 2, 0], [1.5, 4, 0]])


@pytest.mark.parametrize(("jensen_c", "alpha2"), [(1.0, 2.25), (1.2, 1.75), (0.7, 3.0)])
def test_flat_data_give_the_printed_linear_patches(jensen_c: float, alpha2: float) -> None:
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0]])
    mesh = HermiteMesh(points, [[0, 1, 2]], np.tile([0.0, 0.0, 1.0], (3, 1)))
    scheme = registry.scheme(f"shirman-sequin[jensen_c={jensen_c},alpha2={alpha2}]")
    batch = scheme.fit(mesh).batches[0]
    assert isinstance(batch, BezierTriangles)
    # the printed control points are those of a linear patch for the original parameters only; the surface always is
    assert np.abs(batch.control_points[..., 2]).max() < 1e-15
    if alpha2 != 2.25:
        return
    opposite_last = batch.control_points[2]  # corners: vertex 0, vertex 1, centre
    rows = [np.array([opposite_last[k] for k in range(15) if index_of_last(k) == row])[:, :2] for row in range(5)]
    for printed, ours in zip(PRINTED, rows, strict=True):
        assert np.allclose(ours, np.array(printed)[::-1], atol=1e-14)


def index_of_last(place: int) -> int:
    """Exponent of the last corner of a control point of a quartic triangle."""
    exponents = [(i, j, 4 - i - j) for i in range(4, -1, -1) for j in range(4 - i, -1, -1)]
    return exponents[place][2]


def second_row(jensen_c: float) -> tuple[Float, Float, Float]:
    """The quadratic's own inner points of the second row along the boundary, ours for them, and the conormals there."""
    quartic, cubic = elevate_triangle(QUADRATIC, 2), elevate_triangle(QUADRATIC, 1)
    curve = cubic[[0, 1, 3, 6]]
    own = quartic[[2, 4, 7, 11]]  # 301 211 121 031
    n0 = unit(np.cross(QUADRATIC[1] - QUADRATIC[0], QUADRATIC[2] - QUADRATIC[0]))
    n1 = unit(np.cross(QUADRATIC[4] - QUADRATIC[3], QUADRATIC[1] - QUADRATIC[3]))
    made = cross_boundary_points(curve, own[0] - curve[0], own[3] - curve[3], n0, n1, jensen_c)
    conormals = np.stack([unit(np.cross(n0, curve[1] - curve[0])), unit(np.cross(n1, curve[3] - curve[2]))])
    return own[1:3], np.stack(made), conormals


def test_no_c_reproduces_a_quadratic() -> None:
    own, made, conormals = second_row(1.0)
    assert np.allclose(own, [[1.125, 1.0, 1.0], [1.875, 1.0, 1.0]], atol=1e-15)
    assert np.allclose(made, [[1.125, 1.0, 1.8], [1.875, 1.0, 1.8]], atol=1e-14)
    # another C moves them along the conormals, in which the missing (0, 0, -0.8) is not
    assert np.allclose(conormals, [[0.28, 0.95, -0.14], [-0.28, 0.95, -0.14]], atol=5e-3)
    moved = second_row(1.4)[1] - made
    assert np.allclose(unit(moved), conormals, atol=1e-12)
    miss = (own - made) - dot(own - made, conormals)[:, None] * conormals
    assert np.abs(miss).max() > 0.7


def surfaces() -> dict[tuple[float, float], Float]:
    """Control points (3, 15, 3) on one curved face, by C and alpha2."""
    dataset = registry.dataset("graph")
    mesh = dataset.mesh(0)
    result = {}
    for jensen_c in (0.8, 1.0, 1.3):
        for alpha2 in (1.6, 2.25, 3.0):
            scheme = registry.scheme(f"shirman-sequin[boundary=hermite,jensen_c={jensen_c},alpha2={alpha2}]")
            batch = scheme.fit(mesh).batches[0]
            assert isinstance(batch, BezierTriangles)
            result[jensen_c, alpha2] = batch.control_points[:3]
    return result


def test_curvature_along_inner_boundaries_and_mixed_partials_at_vertices_do_not_depend_on_beta_and_c() -> None:
    normal_curvature, twist = [], []
    for net in surfaces().values():
        jet = BezierTriangles(net).jets(np.array([[0.0, 0.0]]), 2)
        n, edge, spoke = jet.normal[:, 0], jet.fu[:, 0], jet.fv[:, 0]
        normal_curvature.append(dot(n, jet.fvv[:, 0]) / dot(spoke, spoke))
        # along the edge and the spoke, which keeps its direction
        twist.append(dot(n, jet.fuv[:, 0]) / np.sqrt(dot(edge, edge) * dot(spoke, spoke)))
    for values in (np.array(normal_curvature), np.array(twist)):
        assert np.ptp(values, axis=0).max() < 1e-12 * np.abs(values).max()


def test_that_curvature_is_not_the_datas() -> None:
    mesh = registry.dataset("graph").mesh(0)
    net = next(iter(surfaces().values()))
    jet = BezierTriangles(net).jets(np.array([[0.0, 0.0]]), 2)
    spoke, vertex = jet.fv[:, 0], mesh.faces[0][[1, 2, 0]]
    assert mesh.second_forms is not None
    own = -dot(jet.normal[:, 0], jet.fvv[:, 0]) / dot(spoke, spoke)
    given = np.einsum("pi,pij,pj->p", spoke, mesh.second_forms[vertex], spoke) / dot(spoke, spoke)
    assert np.abs(own - given).min() > 0.05 * np.abs(given).max()
