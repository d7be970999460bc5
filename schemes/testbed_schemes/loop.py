"""Loop's subdivision surface (1987) through the points: the control vertices are solved for, the limit is exact.

One linear system for the whole mesh gives control vertices whose limits are the data. After one step of subdivision a
face has at most one irregular corner: its four pieces are quartic Bezier triangles where they have none, and otherwise
evaluated exactly (:mod:`mathematics.loop_corners`). The surface is C2 but for the irregular vertices, where it has
a tangent plane; its curvature is unbounded at those of valence 3 and from 7 on, and at vertices of the boundary with
four or five faces. Normals are not read and not matched.

Formulas: as printed. On the boundary the cubic B-spline rules of Hoppe et al. 1994, which leave no tangent plane where
a vertex has more than five faces: refused. **Fill**: a vertex of the boundary with one face is a corner.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.domain import CORNERS
from testbed.geometry.loop_subdivision import interpolating_vertices, subdivided
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, Int
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.box_spline import bezier_nets, patch_vertices, reflected
from testbed_schemes.mathematics.loop_corners import CornerKind, LoopCorners
from testbed_schemes.mathematics.triangle_subdivision import check_two_sided, refined_places, triangulation

#: Most faces at a vertex of the boundary. With k of them, the eigenvalue 3/8 + cos(2 pi / k) / 4 of a second mode
#: across the boundary reaches the 1/2 of the tangent along it at k = 6.
MOST_AT_BOUNDARY = 5
#: Most faces at a vertex inside: the time for its matrices grows with the cube, for these to some seconds.
MOST_INSIDE = 1000


@dataclass(frozen=True)
class Loop(Scheme):
    """Loop's subdivision surface with its limits at the data."""

    name = "loop"
    title = "Loop, interpolating"
    reference = "Loop 1987; Stam 1998"
    formula = (
        "Control vertices p with (1 - K chi) p + chi (sum of the ring) = v, chi = 1 / (3 / (8 beta) + K), for all "
        "vertices at once; their limit surface as quartic Bezier triangles, by Stam's evaluation at irregular vertices."
    )
    status = (
        "As printed, on the boundary with the cubic B-spline rules of Hoppe et al. 1994. Fill: vertices of the "
        "boundary with one face are corners."
    )
    failures = (
        "Ignores normals, and swings between points that are unevenly spaced and near vertices of other valences than "
        "6. The curvature is unbounded at vertices of valence 3 and from 7 on, and at those of the boundary with four "
        "or five faces, so that its extremes depend on how near to them one looks. Refuses vertices of the boundary "
        "with more than five faces."
    )
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    support = None

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the limit surface, four patches a face."""
        coarse = triangulation(mesh)
        check_two_sided(self, coarse)
        check_vertices(self, coarse)
        points = subdivided(coarse, interpolating_vertices(coarse, mesh.points))
        faces = coarse.refined()
        whole, extended = reflected(faces, points)
        places = refined_places(np.broadcast_to(CORNERS[3], (len(mesh.faces), 3, 2)))
        kinds, regular = corner_kinds(coarse, faces)
        control = patch_vertices(whole, regular)
        nets = in_blocks(lambda some: bezier_nets(extended[control[some]]), len(control))
        parts = [part(BezierTriangles(nets), faces, places, regular)]
        for kind, half_edge in kinds:
            parts.append(part(LoopCorners(kind, points[kind.vertices(faces, half_edge)]), faces, places, half_edge))
        return Surface(mesh, tuple(one for one in parts if len(one.batch)))


def check_vertices(scheme: Loop, faces: Triangulation) -> None:
    """Refuse vertices of the boundary at which the limit surface has no tangent plane, and vertices of huge valence."""
    most = np.where(faces.on_boundary, MOST_AT_BOUNDARY, MOST_INSIDE)
    crowded = faces.face_count > most
    if crowded.any():
        vertex = int(np.argmax(crowded))
        where = "of the boundary" if faces.on_boundary[vertex] else "inside"
        raise Refused(
            f"{scheme} takes at most {most[vertex]} faces at a vertex {where}, and {faces.face_count[vertex]} meet at "
            f"vertex {vertex}: flip some of its edges"
        )


def corner_kinds(coarse: Triangulation, faces: Triangulation) -> tuple[list[tuple[CornerKind, Int]], Int]:
    """Sort the patches, given by half edges of the triangulation after one step that leave their corners 0.

    Returns
    -------
    irregular
        Each kind of irregular corner with its patches.
    regular
        The others.
    """
    piece = 4 * np.arange(len(coarse.faces))[:, None] + np.arange(3)
    leaving = (3 * piece + np.arange(3)).ravel()
    vertex = faces.start[leaving]
    count, bounding = coarse.face_count[vertex], coarse.on_boundary[vertex]
    even = np.where(bounding, (count == 1) | (count == 3), count == 6)
    regular = np.sort(np.concatenate([leaving[even], 3 * (piece[:, 0] + 3)]))
    return list(irregular_kinds(faces, leaving[~even], count[~even], bounding[~even].astype(np.int64))), regular


def irregular_kinds(faces: Triangulation, leaving: Int, count: Int, bounding: Int) -> Iterator[tuple[CornerKind, Int]]:
    """Yield the kinds of irregular corners that half edges leave; given faces at them, and whether on the boundary."""
    place = faces.fan_place(leaving)
    for kind in np.unique(np.stack([bounding, count, place], axis=-1), axis=0).tolist():
        of_kind = (bounding == kind[0]) & (count == kind[1]) & (place == kind[2])
        yield CornerKind(kind[1], kind[2]), leaving[of_kind]


def part(batch: BezierTriangles | LoopCorners, faces: Triangulation, places: Float, half_edge: Int) -> Part:
    """Place patches whose sides from corner 0 to corner 1 are the half edges (N,)."""
    piece, corner = half_edge // 3, half_edge % 3
    ids = np.stack([faces.start[half_edge], faces.end[half_edge], faces.apex[half_edge]], axis=-1)
    order = (corner[:, None] + np.arange(3)) % 3
    return Part(batch, ids, piece // 4, places[piece[:, None], order])
