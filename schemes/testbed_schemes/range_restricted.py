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
from testbed.geometry.vectors import Bool, Float, cross, norm, unit
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.edgewise_quartics import EdgewiseQuartics
from testbed_schemes.mathematics.plane_sides import PlaneSide
from testbed_schemes.mathematics.range_restriction import RestrictedEdges, restrict_range
from testbed_schemes.mathematics.range_restriction_network import LegNetwork
from testbed_schemes.mathematics.vertex_tangents import project, projections

#: The least part of a tangent that is left of it: of shorter ones, rounding leaves no tangent plane.
SHORTEST = 1e-6


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
        inverse areas. When the surface is restricted, these are turned towards the plane's near the plane, and are the
        plane's on it.
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
        "the constrained curves and the inner points. Fills: the factor kappa and its limit, the free vector by least "
        "squares, shortened and turned tangents, estimated normals turned near the plane, tangents where faces would "
        "fold."
    )
    failures = (
        "Chords' shadows are short tangents where normals turn far, and the surface is flat between: off the sphere by "
        "0.19 on the octahedron, with K in [0.19, 14.6]. Shortened tangents crowd the parametrisation. Refused: "
        "tangents that would be shortened to a millionth, vertices on the plane with three neighbours, or with four "
        "of which opposite tangents would have to be collinear, and faces that fold about every direction of "
        "projection."
    )
    needs = Data.POINTS
    continuity = Continuity.G1
    reproduces = (Shape.PLANES,)

    @property
    def matches(self) -> Data:  # type: ignore[override]  # normals of its own are not those of the data
        """Points, and the data's normals where it takes them."""
        return Data.POINTS if self.normals == "inverse-area" else Data.POINTS | Data.NORMALS

    @property
    def order(self) -> float | None:  # type: ignore[override]  # likewise
        """Of graphs over data with exact normals, and with normals by inverse areas."""
        return 2.0 if self.normals == "inverse-area" else 3.0

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
        side, remark = self.chosen_side(mesh)
        normals, turned = self.vertex_normals(mesh, side)
        legs, replaced = self.legs(mesh, normals)
        oriented = HermiteMesh(mesh.points, mesh.faces, normals)
        check_corners(self, oriented, legs[:, 0], legs[:, 1])
        check_sides(self, oriented, legs[:, 0], legs[:, 1])
        edges = restricted(mesh, normals, legs, side)
        self.check_edges(mesh, edges)
        branches = {remark: len(mesh.faces)} if remark else {}
        branches |= edges.counts | {
            "vertices with turned normals": int(turned.sum()),
            "vertices with turned projections": int(replaced.sum()),
        }
        return Surface.over_faces(mesh, patches(mesh, edges), branches=branches)

    def chosen_side(self, mesh: HermiteMesh) -> tuple[PlaneSide | None, str]:
        """Return the side to stay on, None if the surface is not restricted, and what to say of it.

        Refused if the surface has to be restricted and cannot be.
        """
        if self.constrain == "never":
            return None, ""
        side = PlaneSide.of_plane(self.plane, mesh.points)
        above, below = int((side.heights > 0.0).sum()), int((side.heights < 0.0).sum())
        up = self.side == "above" or (self.side == "auto" and above >= below)
        side = side if up else side.other()
        wrong = side.heights < 0.0
        if wrong.any():
            here, there = ("above", "below") if up else ("below", "above")
            vertex = int(np.argmax(wrong))
            return None, self.unrestricted(
                "data on the other side of the plane",
                f"{self} stays {here} the plane, and vertex {vertex} is {-side.heights[vertex]:.3g} {there} it, the "
                f"first of {int(wrong.sum())}: move the plane or the vertex, or set constrain=never",
            )
        if self.takes_data(mesh) and mesh.normals is not None and (foreign := side.foreign(mesh.normals)).any():
            vertex = int(np.argmax(foreign))
            sine = min(float(norm(cross(mesh.normals[vertex], side.direction))), 1.0)
            return None, self.unrestricted(
                "a normal on the plane is not the plane's",
                f"{self} cannot stay on one side of the plane at vertex {vertex}, which lies on it with a normal "
                f"{np.degrees(np.arcsin(sine)):.3g} degrees off the plane's, the first of {int(foreign.sum())}: turn "
                "the normal, move the vertex or the plane, or set constrain=never",
            )
        return side, "faces kept on one side of the plane"

    def unrestricted(self, why: str, complaint: str) -> str:
        """Return what to say of a surface that is not restricted; Refused with a complaint if it has to be."""
        if self.constrain == "always":
            raise Refused(complaint)
        return f"faces not restricted: {why}"

    def takes_data(self, mesh: HermiteMesh) -> bool:
        """Whether the normals are those of the mesh."""
        return self.normals == "data" and mesh.normals is not None

    def vertex_normals(self, mesh: HermiteMesh, side: PlaneSide | None) -> tuple[Float, Bool]:
        """Return the unit normals (V, 3) that the surface has at the vertices, and where they were turned (V,)."""
        kept = np.zeros(len(mesh.points), dtype=np.bool_)
        if self.takes_data(mesh) and mesh.normals is not None:
            return mesh.normals if side is None else side.settled(mesh.normals), kept
        try:
            normals = inverse_area_normals(mesh.points, mesh.faces)
        except MeshError as error:
            raise Refused(f"{self} has no normals: {error}") from error
        return (normals, kept) if side is None else side.turned(normals, mesh)

    def check_edges(self, mesh: HermiteMesh, edges: RestrictedEdges) -> None:
        """Refuse edges without control points on the side of the plane, and tangents that hardly are left."""
        if edges.infeasible.any():
            i, j = mesh.edges[edges.infeasible][0].tolist()
            raise Refused(
                f"{self} finds no control points on its side of the plane along {int(edges.infeasible.sum())} of "
                f"{len(mesh.edges)} edges, the first that from vertex {i} to vertex {j}: move the plane away from the "
                "data, turn the normals there, or set constrain=never"
            )
        short = ~(edges.shortening >= SHORTEST)
        if short.any():
            edge, end = (int(index[0]) for index in np.nonzero(short))
            raise Refused(
                f"{self} would have to shorten tangents at vertex {mesh.edges[edge, end]} to "
                f"{edges.shortening[edge, end]:.1g} of their length to stay on its side of the plane: turn the normal "
                "there towards the plane's, move the plane away from the data, or set constrain=never"
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


def restricted(mesh: HermiteMesh, normals: Float, legs: Float, side: PlaneSide | None) -> RestrictedEdges:
    """Return boundaries and second rows, kept on a side of the plane if one is given."""
    if side is None:  # bounds of infinity restrict nothing
        side, bounds = (
            PlaneSide(np.array([0.0, 0.0, 1.0]), np.zeros(len(mesh.points))),
            np.full(len(mesh.faces), np.inf),
        )
    else:
        bounds = side.bounds(mesh)
    network = LegNetwork.of_mesh(mesh)
    return restrict_range(network, mesh.points, normals, legs, side.direction, side.heights, bounds)


def patches(mesh: HermiteMesh, edges: RestrictedEdges) -> EdgewiseQuartics:
    """Return the patches of the faces from what belongs to the edges."""
    edge, forward = mesh.face_edges, mesh.face_edge_forward[..., None, None]
    boundary = np.where(forward, edges.boundary[edge], edges.boundary[edge, ::-1])
    rows = np.where(forward, edges.left[edge], edges.right[edge, ::-1])
    return EdgewiseQuartics.of_rows(boundary, rows[:, :, 0], rows[:, :, 1])
