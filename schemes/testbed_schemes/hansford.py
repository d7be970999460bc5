"""Hansford's scheme as the survey sketches it, completed here: three rational quartic triangles a face over conics.

**Completed here, not the original.** Mann 1992, section 2.3.1, describes Hansford 1991 in six steps and gives no
formula: conics on the edges, a rational quadratic patch, its degree raised and the patch split in three, the patches as
polynomial ones in four dimensions, control points adjusted there for a G1 join, projection back. The steps are followed
here; conics, weights and the adjustment are fills, and Hansford's own could not be established.

Conics: :mod:`mathematics.edge_conics`, Q0, Q1, Q2 with weights 1, w, 1. All points below are vectors (w P, w). The
de Casteljau points of a conic, L0(t) and L1(t), span its point and tangent. The second rows of quartics on both sides,
sum_r B^3_r(t) F_r, join with a common tangent plane if they are linearly dependent on L0, L1 and one more vector:

    sum_r B^3_r F_r = a(t) L0(t) + b(t) L1(t) + k(t) ((1 - t) c0 + t c1),    c = (unit(n x tangent), 0),

with quadratic a, b, k. Their end values are those of F_0 and F_3, the middle coefficients bring F_1 and F_2 nearest to
the split patch. Inside, the four-dimensional patches join C1, about inner points N_i that are free: those of the split
patch, or, much rounder, such as would belong to the second rows if these were of split cubics.

Matches position and normal at the corners; boundaries are exact conics, circles on symmetric data. Edges without a
conic are refused.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bernstein import elevate_curve, elevate_triangle
from testbed.geometry.bezier import RationalBezierTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_checks import named
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, dot, norm
from testbed.plugins.corners import check_corners
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, conormal
from testbed_schemes.mathematics.edge_conics import EdgeConics, edge_conics
from testbed_schemes.mathematics.planar_frame import PlanarFrame, curve_from_legs, planar_frame
from testbed_schemes.mathematics.split_domain import J, K, c1_ring, cubic_reproducing_inner, subdivided_cubics

Inner: TypeAlias = Literal["fitted", "kept"]


@dataclass(frozen=True)
class Hansford(Scheme):
    """Rational quartics over conics: the survey's sketch of Hansford's scheme, completed.

    Parameters
    ----------
    inner
        The inner point of each patch: ``fitted`` to the second row that joins, or ``kept`` from the split patch.
    """

    inner: Inner = "fitted"

    name = "hansford"
    title = "Hansford (completed)"
    reference = "after Hansford 1991, as sketched in Mann 1992, section 2.3.1; completed here, not the original"
    formula = (
        "Conics with weight L / (A + B) on the edges, rational quadratic raised to a quartic and split; in homogeneous "
        "coordinates the second row is a L0 + b L1 + k ((1 - t) c0 + t c1), nearest to the split patch; inside C1."
    )
    status = "Fill: conics, weights and adjustment; the survey has the steps without formulas. Not the original."
    failures = (
        "Refused on edges with an inflection or bent at one end only: 8 of 120 of a coarse torus, some of every mesh "
        "of a monkey saddle. Conics whose tangents meet near an end have large curvatures (K to 200 on a coarse torus)."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build three rational quartics a face; refuses edges without a conic."""
        frame = planar_frame(mesh.edge_data)
        conics = edge_conics(frame)
        check_conics(self, mesh, frame, conics)
        control_points = homogeneous(mesh, frame, conics)
        normals = mesh.corner_normals()

        def nets(faces: slice) -> Float:
            forward = mesh.face_edge_forward[faces][..., None, None]
            sides = control_points[mesh.face_edges[faces]]
            opposite = np.roll(np.where(forward, sides, sides[:, :, ::-1]), -1, axis=1)
            return split_faces(opposite, normals[faces], self.inner)

        net = in_blocks(nets, len(mesh.faces))
        check_weights(self, mesh, net)
        net = net.reshape(-1, *net.shape[2:])
        weights = net[..., 3]
        return Surface.over_split_faces(mesh, RationalBezierTriangles(net[..., :3] / weights[..., None], weights))


def check_conics(scheme: Scheme, mesh: HermiteMesh, frame: PlanarFrame, conics: EdgeConics) -> None:
    """Refuse edges without a conic, and conics along which tangent planes have no field; the message names vertices."""
    missing = ~conics.exists
    if missing.any():
        i, j = mesh.edges[missing][0].tolist()
        raise Refused(
            f"{scheme} has no conic for {int(missing.sum())} of {len(mesh.edges)} edges, the first from vertex {i} to "
            f"vertex {j}: its tangents do not meet between the ends, refine the mesh there or use another scheme"
        )
    d0, d1 = conics.cubic_legs() * frame.length
    network = CurveNetwork(mesh, curve_from_legs(mesh.edge_data, (frame.t0, frame.t1), d0, d1))
    check_corners(scheme, mesh, *network.end_legs)
    check_fields(scheme, network)


def check_weights(scheme: Scheme, mesh: HermiteMesh, net: Float) -> None:
    """Refuse nets (F, 3, 15, 4) with weights that are not positive: the patch could have a pole."""
    unfit = ~(net[..., 3] > 0.0).all(axis=(1, 2))
    if unfit.any():
        face = int(np.argmax(unfit))
        raise Refused(
            f"{scheme} finds weights that are not positive on {named(mesh.faces, face)}, the first of "
            f"{int(unfit.sum())} such faces: its edges turn too far, refine the mesh there"
        )


def homogeneous(mesh: HermiteMesh, frame: PlanarFrame, conics: EdgeConics) -> Float:
    """Control points (w P, w) of the conics, (E, 3, 4), from the lower vertex id to the higher."""
    edges = mesh.edge_data
    points = np.stack([edges.p0, conics.middle(edges, frame), edges.p1], axis=1)
    weights = np.ones((len(edges), 3, 1))
    weights[:, 1, 0] = conics.weight
    return np.concatenate([weights * points, weights], axis=-1)


def split_faces(conics: Float, normals: Float, inner: Inner) -> Float:
    """Return the nets of the three quartics of each face in homogeneous coordinates, (F, 3, 15, 4).

    Parameters
    ----------
    conics
        (F, 3, 3, 4) conic opposite corner i, from corner i + 1 to corner i + 2, in homogeneous coordinates.
    normals
        (F, 3, 3) unit normals by corner.
    inner
        Which inner points; see :class:`Hansford`.
    """
    cubics = elevate_curve(conics)
    # the inner control point of a quadratic raised to degree 3
    centre = conics[:, :, 1].sum(axis=1) / 3.0
    candidate = elevate_triangle(subdivided_cubics(cubics, centre))
    row = candidate[:, :, [2, 4, 7, 11]]
    cross_points = joined_points(conics, row, normals[:, J], normals[:, K])
    boundary = elevate_curve(cubics)
    if inner == "fitted":
        return c1_ring(boundary, cross_points, cubic_reproducing_inner(boundary, cubics, cross_points)).nets()
    return c1_ring(boundary, cross_points, candidate[:, :, 8]).nets()


def joined_points(conic: Float, row: Float, start_normal: Float, end_normal: Float) -> tuple[Float, Float]:
    """Return F_1 and F_2 of a G1 join along a conic, (..., 4) each, nearest to a given second row.

    A control point (w P, w) differs from the given one by w times the distance of P from it, in chords, and by w.

    Parameters
    ----------
    conic
        (..., 3, 4) control points.
    row
        (..., 4, 4) F_0 to F_3 of a quartic triangle; F_0 and F_3 in the tangent planes at the ends.
    start_normal, end_normal
        (..., 3) unit normals at the ends.
    """
    start, middle, end = conic[..., 0, :], conic[..., 1, :], conic[..., 2, :]
    apex = middle[..., :3] / middle[..., 3:]
    c0, c1 = _direction(start_normal, apex - start[..., :3]), _direction(end_normal, end[..., :3] - apex)
    # a(0), b(0), k(0), and by symmetry b(1), a(1), k(1)
    a0, b0, k0 = _end_values(row[..., 0, :], start, middle, c0)
    b2, a2, k2 = _end_values(row[..., 3, :], end, middle, c1)
    # coefficients of the products of a quadratic and a line: F_1 and F_2 without the middle coefficients a1, b1, k1
    first = (a0 * middle + b0 * end + k0 * c1) / 3.0
    second = (a2 * start + b2 * middle + k2 * c0) / 3.0
    # and what these add, with k1 in chords
    length = norm(end[..., :3] - start[..., :3])[..., None]
    at_first = 2.0 / 3.0 * np.stack([start, middle, length * c0], axis=-2)
    at_second = 2.0 / 3.0 * np.stack([middle, end, length * c1], axis=-2)
    near, far = row[..., 1, :], row[..., 2, :]
    equations = np.concatenate([_measured(at_first, near, length), _measured(at_second, far, length)], axis=-1)
    wanted = np.concatenate([_measured(near - first, near, length), _measured(far - second, far, length)], axis=-1)
    matrix = dot(equations[..., :, None, :], equations[..., None, :, :])
    right = dot(equations, wanted[..., None, :])
    solution = np.linalg.solve(matrix, right[..., None])
    return first + (solution * at_first).sum(axis=-2), second + (solution * at_second).sum(axis=-2)


def _direction(normal: Float, tangent: Float) -> Float:
    """(unit(n x tangent), 0), (..., 4)."""
    across = conormal(normal, tangent)
    return np.concatenate([across, np.zeros_like(across[..., :1])], axis=-1)


def _end_values(point: Float, corner: Float, middle: Float, c: Float) -> tuple[Float, Float, Float]:
    """Coefficients (..., 1) of a point of the tangent plane at a corner by the corner, the conic's middle and c."""
    weight = middle[..., 3]
    leg = middle[..., :3] - weight[..., None] * corner[..., :3]
    offset = point[..., :3] - point[..., 3:] * corner[..., :3]
    # not by the square of the leg, which may leave the range of floats
    length = norm(leg)
    along = dot(offset, leg / length[..., None]) / length
    return (point[..., 3] - along * weight)[..., None], along[..., None], dot(offset, c[..., :3])[..., None]


def _measured(a: Float, about: Float, length: Float) -> Float:
    """Homogeneous vectors (..., 4) or (..., 3, 4) as offsets from a point, in units of a length, and weights."""
    if a.ndim > about.ndim:
        about, length = about[..., None, :], length[..., None]
    place = about[..., :3] / about[..., 3:]
    return np.concatenate([(a[..., :3] - a[..., 3:] * place) / length, a[..., 3:]], axis=-1)
