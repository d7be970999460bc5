"""Numbers that papers print of single constructions: control points of an example, counts, orders of a curve.

Each is a function of no arguments that computes them with the schemes of the testbed; ``published.toml`` names it.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from testbed import registry
from testbed.geometry.bernstein import elevate_triangle, evaluate_curve, multi_indices
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.vectors import Float, dot, norm, unit
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.continuity_conditions.chiyokura_kimura import cross_boundary_points

#: Mann 1994, appendix B: the quadratic patch, 200 110 101 020 011 002; its side from (0, 0, 0) to (3, 0, 0) is
#: 200 110 020.
QUADRATIC: Final = (
    (0.0, 0.0, 0.0),
    (1.5, 0.0, 3.0),
    (0.75, 2.0, 0.0),
    (3.0, 0.0, 0.0),
    (2.25, 2.0, 0.0),
    (1.5, 4.0, 0.0),
)
#: C and alpha2 with which what must not depend on them is computed.
SETTINGS: Final = tuple((c, alpha2) for c in (0.8, 1.0, 1.3) for alpha2 in (1.6, 2.25, 3.0))


def linear_patches() -> tuple[Float, ...]:
    """Control points (3, 15, 3) of Shirman and Sequin's patches on (0, 0, 0), (1, 0, 0), (0, 1, 0), normals upwards.

    Patch by patch as the paper lists them, by their corners: vertices 2, 1 and the centre; 2, the centre and 3; the
    centre, 1 and 3, where vertex 1 is (0, 0, 0).
    """
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    mesh = HermiteMesh(points, [[0, 1, 2]], np.tile([0.0, 0.0, 1.0], (3, 1)))
    batch = registry.scheme("shirman-sequin").fit(mesh).batches[0]
    assert isinstance(batch, BezierTriangles)  # noqa: S101 - the scheme's own patches
    # patch i has the corners i + 1, i + 2 and the centre; the paper lists rows from its first corner to its second,
    # the first row between them, the last being its third corner
    listed = ((2, (1, 0, 2)), (0, (0, 2, 1)), (1, (2, 1, 0)))
    return tuple(_listed(batch.control_points[patch], corners) for patch, corners in listed)


def _listed(net: Float, corners: tuple[int, int, int]) -> Float:
    """Control points (15, 3) of a quartic row by row: from the first of these corners to the second, then inwards."""
    exponents = multi_indices(4)
    first, _, last = (exponents[:, corner] for corner in corners)
    rows: Float = net[np.lexsort((-first, last))]
    return rows


def second_rows() -> tuple[Float, Float, Float]:
    """Of the quadratic of appendix B, raised to degree four: the two inner points of the second row along its side.

    The quadratic's own, those of Chiyokura and Kimura's construction, and the unit vectors along which Jensen's
    parameter moves them, (2, 3) each.
    """
    net = np.array(QUADRATIC)
    quartic, cubic = elevate_triangle(net, 2), elevate_triangle(net, 1)
    curve, own = cubic[[0, 1, 3, 6]], quartic[[2, 4, 7, 11]]
    n0 = unit(np.cross(net[1] - net[0], net[2] - net[0]))
    n1 = unit(np.cross(net[4] - net[3], net[1] - net[3]))
    made = np.stack(cross_boundary_points(curve, own[0] - curve[0], own[3] - curve[3], n0, n1, 1.0))
    moved = np.stack(cross_boundary_points(curve, own[0] - curve[0], own[3] - curve[3], n0, n1, 2.0)) - made
    # of both signs of a direction the one towards the patch
    return own[1:3], made, unit(moved) * np.sign(dot(moved, own[1:3] - curve[1:3]))[:, None]


def inner_boundaries() -> tuple[float, float]:
    """How much C and alpha2 change the second-order data of inner boundaries at the vertices, relative to their size.

    Of the normal curvature, and of the mixed partial along an edge and an inner boundary, on a face of ``graph``.
    """
    curvature, twist = [], []
    mesh = registry.dataset("graph").mesh(0)
    for c, alpha2 in SETTINGS:
        batch = registry.scheme(f"shirman-sequin[boundary=hermite,jensen_c={c},alpha2={alpha2}]").fit(mesh).batches[0]
        jet = batch.take(slice(0, 3)).jets(np.array([[0.0, 0.0]]), 2)
        n, edge, inner = jet.normal[:, 0], jet.fu[:, 0], jet.fv[:, 0]
        curvature.append(dot(n, jet.fvv[:, 0]) / dot(inner, inner))
        twist.append(dot(n, jet.fuv[:, 0]) / np.sqrt(dot(edge, edge) * dot(inner, inner)))
    found = (np.ptp(values, axis=0).max() / np.abs(values).max() for values in (np.array(curvature), np.array(twist)))
    first, second = (float(change) for change in found)
    return first, second


def inner_control_points() -> int:
    """Control points of three quartics on a split triangle, shared ones counted once, without those of its sides."""
    mesh = registry.dataset("octahedron").mesh(0).submesh(np.array([0]))
    batch = registry.scheme("shirman-sequin").fit(mesh).batches[0]
    assert isinstance(batch, BezierTriangles)  # noqa: S101 - the scheme's own patches
    points = batch.control_points.reshape(-1, 3)
    apart = norm(points[:, None] - points[None]) < 1e-12
    distinct = int((np.argmax(apart, axis=1) == np.arange(len(points))).sum())
    return distinct - 3 * 4


def curves_of_sphere_data() -> int:
    """Most geometric Hermite curves that an edge of the sphere data has: roots found from both ends of the choice."""
    edges = registry.dataset("sphere").mesh(0).edge_data
    flipped = EdgeData(edges.p1, edges.p0, edges.n1, edges.n0, edges.W1, edges.W0)
    uniform, least = (Hermite(root=root).curves(edges)[0] for root in ("best", "worst"))
    mirrored = Hermite(root="worst").curves(flipped)[0][:, ::-1]
    known = np.stack([uniform, least, mirrored])
    apart = norm(known[:, None] - known[None]).max(axis=-1) > 1e-6
    several = 1 + apart[1, 0].astype(np.int64) + (apart[2, 0] & apart[2, 1])
    return int(several.max())


def order_of_geometric_hermite_curves() -> float:
    """Order at which the distance of geometric Hermite cubics from an ellipse falls, from two short arcs."""
    axes = np.array([2.0, 1.0])

    def error(size: float) -> float:
        angle = np.array([0.7 - size, 0.7 + size])
        p = np.column_stack([axes * np.stack([np.cos(angle), np.sin(angle)], axis=-1), np.zeros(2)])
        gradient = np.column_stack([p[:, :2] / axes**2, np.zeros(2)])
        n = unit(gradient)
        tangent = np.cross([0.0, 0.0, 1.0], n)
        curvature = 1.0 / (np.prod(axes) ** 2 * norm(gradient) ** 3)
        forms = curvature[:, None, None] * tangent[:, :, None] * tangent[:, None, :]
        edge = EdgeData(*(np.array([row]) for row in (p[0], p[1], n[0], n[1], forms[0], forms[1])))
        at = evaluate_curve(Hermite().curves(edge)[0], np.linspace(0.0, 1.0, 33))[0, 0, :, :2]
        value = ((at / axes) ** 2).sum(axis=-1) - 1.0
        return float(np.abs(value / norm(2.0 * at / axes**2)).max())

    return float(np.log2(error(0.2) / error(0.1)))


def patch_ratio() -> float:
    """Patches on the icosahedron if tetrahedra of edges are split in two, over those that there are."""
    surface = registry.scheme("a-patch").fit(registry.dataset("icosahedron").mesh(0))
    return (len(surface.mesh.faces) + 2 * len(surface.mesh.edges)) / surface.patch_count


def _numbers(values: Float) -> tuple[float, ...]:
    return tuple(float(number) for number in np.ravel(values))


#: The constructions by the names that the table of published figures gives them.
CONSTRUCTIONS: Final[Mapping[str, Callable[[], tuple[float, ...]]]] = MappingProxyType(
    {
        "first linear patch": lambda: _numbers(linear_patches()[0]),
        "second linear patch": lambda: _numbers(linear_patches()[1]),
        "third linear patch": lambda: _numbers(linear_patches()[2]),
        "own second row": lambda: _numbers(second_rows()[0]),
        "made second row": lambda: _numbers(second_rows()[1]),
        "directions of C": lambda: _numbers(second_rows()[2]),
        "change of curvature": lambda: (inner_boundaries()[0],),
        "change of mixed partials": lambda: (inner_boundaries()[1],),
        "inner control points": lambda: (float(inner_control_points()),),
        "their coordinates": lambda: (3.0 * inner_control_points(),),
        "most curves": lambda: (float(curves_of_sphere_data()),),
        "order of curves": lambda: (order_of_geometric_hermite_curves(),),
        "ratio of patches": lambda: (patch_ratio(),),
    }
)
