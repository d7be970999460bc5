"""Range-restricted interpolation (Si 2015): blends of three quartics that stay on the data's side of a plane.

Matches position and normal at the vertices, and is G1. Normals and tangents at the vertices give cubic boundary curves,
raised to quartics. Each face has three quartics over them, of which each meets one neighbour by linear coefficients in
the condition of tangent planes, and their blend is the patch. If the data lie on one side of the plane, the quartics'
control points are kept above a bound that suffices for the surface to stay on that side: tangents are shortened,
boundary curves become true quartics and inner control points are moved, edge by edge as needed.

A plane's normal is (a, b, c) and its upper side a x + b y + c z + d >= 0, by default z >= 0.

Formulas: corrected, see :mod:`testbed.geometry.inverse_area_normals` and
:mod:`testbed_schemes.mathematics.linear_g1`. The source's last chapters, on the bound, the constrained curves and the
inner points, are not available but in outline: :mod:`testbed_schemes.mathematics.quartic_lower_bound` and
:mod:`testbed_schemes.mathematics.range_restriction` are derived anew.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from testbed.errors import MeshError, Refused, SpecError
from testbed.geometry.inverse_area_normals import inverse_area_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, unit
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.edgewise_quartics import EdgewiseQuartics
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate
from testbed_schemes.mathematics.range_restriction import RestrictedEdges, restrict_range
from testbed_schemes.mathematics.range_restriction_network import LegNetwork
from testbed_schemes.mathematics.vertex_tangents import project, projections

#: A vertex lies on the plane if its height is this small against its coordinates: rounding.
ON_PLANE = 64 * float(np.finfo(np.float64).eps)
#: Sine of the angle with the plane's normal up to which a normal there is taken for it.
PARALLEL = 1e-10


@dataclass(frozen=True, eq=False)
class Side:
    """The side of the plane on which the surface is to stay.

    Parameters
    ----------
    direction
        (3,) unit normal of the plane, towards the side.
    heights
        (V,) distances of the vertices from the plane, not negative; zero for those that rounding alone keeps off it.
    """

    direction: Float
    heights: Float

    def foreign(self, normals: Float) -> Bool:
        """(V,) true for vertices on the plane whose normal is not the plane's: no surface stays on its side there."""
        sine = norm(cross(normals, self.direction))
        on_plane: Bool = (self.heights == 0.0) & ~(sine <= PARALLEL)
        return on_plane


@dataclass(frozen=True)
class RangeRestricted(Scheme):
    """Si's range-restricted G1 interpolation.

    Parameters
    ----------
    plane
        (a b c d), the plane a x + b y + c z + d = 0; its upper side is where that is positive.
    side
        The side to stay on: ``above`` or ``below`` the plane, or ``auto``, that of the data.
    constrain
        ``auto`` restricts the surface if all data lie on that side, those on the plane with its normal, and does not
        otherwise; ``branches`` of the surface says which. ``always`` refuses other data, ``never`` does not look at the
        plane.
    normals
        ``data``, the mesh's, or where it has none those of ``inverse-area``: means over the faces about a vertex by
        inverse areas. With these, vertices on the plane get its normal when the surface is restricted.
    tangents
        The direction along which chords are projected onto the tangent planes: ``normal``, orthogonally, or ``plane``,
        along the plane's normal wherever the faces at a vertex are all seen from there, which reproduces quadratic
        functions over the plane.

    Raises
    ------
    SpecError
        The plane's normal vanishes.
    """

    plane: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 0.0)
    side: Literal["auto", "above", "below"] = "auto"
    constrain: Literal["auto", "always", "never"] = "auto"
    normals: Literal["data", "inverse-area"] = "data"
    tangents: Literal["normal", "plane"] = "normal"

    name = "range-restricted"
    title = "Range-restricted"
    reference = "Si 2015"
    formula = (
        "sum w_s P_s, w_s = b_s b_{s+1} / (b_0 b_1 + b_1 b_2 + b_2 b_0), of three quartics with the same boundary; P_s "
        "meets its neighbour on side s by alpha D1 + beta D2 + gamma D3 = 0 with linear coefficients, and no control "
        "point lies more below the plane than a quartic with its corners' heights can bear."
    )
    status = (
        "Corrected: the normals n* of the boundary rule, gamma_0 in (3.2). Derived anew from an outline: the bound, "
        "the constrained curves and the inner points. Fills: the factor kappa, the free vector by least squares, and "
        "tangents where faces would fold."
    )
    failures = ""
    needs = Data.POINTS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    @property
    def matches(self) -> Data:  # type: ignore[override]  # normals of its own are not those of the data
        """Points, and the data's normals where it takes them."""
        return Data.POINTS if self.normals == "inverse-area" else Data.POINTS | Data.NORMALS

    @property
    def vertical(self) -> bool:  # type: ignore[override]  # a plane that is not looked at does not matter
        """Whether it looks at the plane, which stays where it is when the data move."""
        return self.constrain != "never" or self.tangents == "plane"

    @property
    def support(self) -> int | None:  # type: ignore[override]  # likewise
        """Without restriction, one ring; normals by inverse areas need another one."""
        if self.constrain != "never":
            return None
        return 2 if self.normals == "inverse-area" else 1

    def __post_init__(self) -> None:
        """Check the plane."""
        if not (np.isfinite(self.plane).all() and norm(np.array(self.plane[:3])) > 0.0):
            raise SpecError(
                f"{self.name}: plane must be four finite numbers, the first three not all zero, and here it is "
                f"{self.plane}"
            )

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build a blend of three quartics a face."""
        side = self.chosen_side(mesh)
        normals = self.vertex_normals(mesh, side)
        branches = {}
        if side is not None and (foreign := side.foreign(normals)).any():
            self.refuse_foreign(side, normals, foreign)
            side, branches["faces not restricted, a normal on the plane is not its own"] = None, len(mesh.faces)
        elif side is not None:
            branches["faces kept on one side of the plane"] = len(mesh.faces)
            normals = np.where((side.heights == 0.0)[:, None], along(normals, side.direction), normals)
        elif self.constrain == "auto":
            branches["faces not restricted, data on the other side of the plane"] = len(mesh.faces)
        legs, replaced = self.legs(mesh, normals)
        oriented = HermiteMesh(mesh.points, mesh.faces, normals)
        check_corners(self, oriented, legs[:, 0], legs[:, 1])
        check_sides(self, oriented, legs[:, 0], legs[:, 1])
        edges = restricted(mesh, normals, legs, side)
        if edges.infeasible.any():
            i, j = mesh.edges[edges.infeasible][0].tolist()
            raise Refused(
                f"{self} finds no control points on its side of the plane along {int(edges.infeasible.sum())} of "
                f"{len(mesh.edges)} edges, the first that from vertex {i} to vertex {j}: move the plane away from the "
                "data, turn the normals there, or set constrain=never"
            )
        branches |= edges.counts | {"vertices with turned projections": int(replaced.sum())}
        return Surface.over_faces(mesh, patches(mesh, edges), branches=branches)

    def chosen_side(self, mesh: HermiteMesh) -> Side | None:
        """Return the side to stay on; None if the surface is not restricted. Refused if it has to be and cannot."""
        if self.constrain == "never":
            return None
        length = norm(np.array(self.plane[:3]))
        normal, offset = np.array(self.plane[:3]) / length, self.plane[3] / length
        heights = dot(mesh.points, normal) + offset
        size = np.abs(mesh.points * normal).sum(axis=1) + abs(offset)
        heights[np.abs(heights) <= ON_PLANE * size] = 0.0
        above, below = int((heights > 0.0).sum()), int((heights < 0.0).sum())
        up = self.side == "above" or (self.side == "auto" and above >= below)
        wrong = heights < 0.0 if up else heights > 0.0
        if not wrong.any():
            return Side(normal if up else -normal, heights if up else -heights)
        if self.constrain == "always":
            vertex = int(np.argmax(wrong))
            here, there = ("above", "below") if up else ("below", "above")
            raise Refused(
                f"{self} stays {here} the plane, and vertex {vertex} is {abs(heights[vertex]):.3g} {there} it, the "
                f"first of {int(wrong.sum())}: move the plane or the vertex, or set constrain=never"
            )
        return None

    def vertex_normals(self, mesh: HermiteMesh, side: Side | None) -> Float:
        """Return the unit normals (V, 3) that the surface has at the vertices."""
        if self.normals == "data" and mesh.normals is not None:
            return mesh.normals
        try:
            normals = inverse_area_normals(mesh.points, mesh.faces)
        except MeshError as error:
            raise Refused(f"{self} has no normals: {error}") from error
        if side is None:
            return normals
        return np.where((side.heights == 0.0)[:, None], along(normals, side.direction), normals)

    def refuse_foreign(self, side: Side, normals: Float, foreign: Bool) -> None:
        """Refuse vertices on the plane with another normal if the surface has to be restricted."""
        if self.constrain == "always":
            vertex = int(np.argmax(foreign))
            tilt = np.degrees(np.arccos(min(abs(float(dot(normals[vertex], side.direction))), 1.0)))
            raise Refused(
                f"{self} cannot stay on one side of the plane at vertex {vertex}, which lies on it with a normal "
                f"{tilt:.3g} degrees off the plane's, the first of {int(foreign.sum())}: turn the normal, move the "
                "vertex or the plane, or set constrain=never"
            )

    def legs(self, mesh: HermiteMesh, normals: Float) -> tuple[Float, Bool]:
        """Return the first legs (E, 2, 3) of the quartic boundaries, both away from their vertex.

        And where the chords are not projected along the direction asked for (V,).
        """
        upright = unit(np.array(self.plane[:3])) if self.tangents == "plane" else None
        directions, replaced = projections(mesh.points, mesh.faces, normals, upright)
        ends = mesh.edges
        chord = mesh.points[ends[:, ::-1]] - mesh.points[ends]
        return project(chord, normals[ends], directions[ends]) / 4.0, replaced


def along(vectors: Float, direction: Float) -> Float:
    """Return a direction (3,) turned to the side to which vectors (V, 3) point, (V, 3)."""
    return np.where(dot(vectors, direction)[:, None] < 0.0, -direction, direction)


def restricted(mesh: HermiteMesh, normals: Float, legs: Float, side: Side | None) -> RestrictedEdges:
    """Return boundaries and second rows, kept on a side of the plane if one is given."""
    if side is None:  # bounds of infinity restrict nothing
        side, bounds = Side(np.array([0.0, 0.0, 1.0]), np.zeros(len(mesh.points))), np.full(len(mesh.faces), np.inf)
    else:
        bounds = lower_ordinate(*side.heights[mesh.faces].T)
    network = LegNetwork.of_mesh(mesh)
    return restrict_range(network, mesh.points, normals, legs, side.direction, side.heights, bounds)


def patches(mesh: HermiteMesh, edges: RestrictedEdges) -> EdgewiseQuartics:
    """Return the patches of the faces from what belongs to the edges."""
    edge, forward = mesh.face_edges, mesh.face_edge_forward[..., None, None]
    boundary = np.where(forward, edges.boundary[edge], edges.boundary[edge, ::-1])
    rows = np.where(forward, edges.left[edge], edges.right[edge, ::-1])
    return EdgewiseQuartics.of_rows(boundary, rows[:, :, 0], rows[:, :, 1])
