"""Patches of an A-patch surface and how they join: triangles of faces, quads of edges, flat triangles.

A convex face is one patch. A nonconvex one is a fan of three about its centre; where one of its edges is nonconvex too
and another face follows there, the third at that edge is cut in two at the *pinch*, the point of the edge at which F
changes its sign. An edge that is not zero convex, between two faces, is one quad with two sides collapsed to its ends,
or two that meet in the pinch. A flat face is itself.

Ids of corners: vertices of the mesh first, then centres by face, then pinches by edge. Strands: a quad joins the face
that runs along its edge forward along strand 1, the one that runs back along strand 2.
"""

from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bernstein import index_of
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.shooting_quads import ShootingQuads
from testbed.geometry.surface import Part
from testbed.geometry.vectors import Bool, Float, Int, dot
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_coefficients import LAYER_PLACES, FaceNets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull

#: Steps of the lattice on which rays backwards are looked at.
BACKWARD_STEPS = 8


@dataclass(frozen=True, slots=True)
class SideNets:
    """F on one side, in its frame: over faces, their free coefficients f0003, and over edges."""

    faces: FaceNets
    top: Float
    edges: EdgeNets


@dataclass(frozen=True, slots=True)
class Places:
    """Where faces of a hull's mesh lie in those of the mesh that the surface is over.

    Attributes
    ----------
    faces
        (F,) face of the surface's mesh.
    corners
        (F, 3, 2) parameters there of the face's corners.
    """

    faces: Int
    corners: Float

    @classmethod
    def same(cls, count: int) -> "Places":
        """Return the places of ``count`` faces in themselves."""
        return cls(np.arange(count), np.broadcast_to(CORNERS[3], (count, 3, 2)))

    def of(self, faces: Int, weights: Float) -> Float:
        """Parameters (P, n, 2) in the surface's mesh of barycentric coordinates (P, n, 3) in faces (P,)."""
        corners = self.corners[faces]
        spread = (weights[..., None] * corners[:, None]).sum(axis=2)
        whole = (corners == CORNERS[3]).all(axis=(1, 2))
        return np.where(whole[:, None, None], weights[..., 1:], spread)


def parts_of(found: Hull, sides: tuple[SideNets, SideNets], split: Bool, places: Places) -> tuple[Part, ...]:
    """Return the parts of the surface; those without patches are left out.

    Parameters
    ----------
    found
        The hull.
    sides
        F on both sides.
    split
        (F,) faces on which F is three cubics.
    places
        Where the hull's faces lie in the surface's mesh.

    Raises
    ------
    Refused
        See :func:`check_backward_rays`.
    """
    faces = _face_part(found, sides, split, places)
    check_backward_rays(faces)
    parts = [faces, _edge_part(found, sides, places), _flat_part(found, places)]
    return tuple(part for part in parts if len(part.batch))


def pinches(found: Hull) -> Float:
    """Weight (E,) of an edge's higher vertex in the point where F is zero between the ends, NaN where there is none."""
    start, end = found.mesh.edges.T
    p, q = found.mesh.points[start], found.mesh.points[end]
    at_start, at_end = dot(q - p, found.vectors[start]), dot(p - q, found.vectors[end])
    with np.errstate(divide="ignore", invalid="ignore"):  # flat edges have no pinch
        return np.where(found.edges == Convexity.NONCONVEX, at_start / (at_start - at_end), np.nan)


def with_patches(found: Hull) -> Bool:
    """Return the edges (E,) that have patches of their own."""
    result: Bool = (found.edges != Convexity.ZERO) & ~found.mesh.boundary_edges
    return result


def check_backward_rays(part: Part) -> None:
    """Refuse convex faces that F leaves on their other side and never meets again, (4.5).

    Rays from points of a convex face with F > 0, which an obtuse face may have, are followed backwards, where no bound
    ensures a root. Looked at on a lattice.

    Parameters
    ----------
    part
        A part of triangles met by rays.

    Raises
    ------
    Refused
        A ray finds no root; the message names the face.
    """
    batch = part.batch
    assert isinstance(batch, ShootingTriangles)  # noqa: S101 - see above
    convex = np.isnan(batch.apexes).any(axis=(1, 2))
    layer0 = np.where(np.isnan(batch.apexes[:, 1, 0])[:, None], batch.nets[:, 0], -batch.nets[:, 1])[:, LAYER_PLACES[0]]
    rational = np.where(np.isnan(batch.apexes[:, 1, 0])[:, None], batch.rational[:, 0], -batch.rational[:, 1])
    middle = index_of((1, 1, 1))
    highest = layer0[:, middle] + rational.max(axis=1)
    (rows,) = np.nonzero(convex & ((layer0 > 0.0).any(axis=1) | (highest > 0.0)))
    points = batch.take(rows).jets(lattice(3, BACKWARD_STEPS), 0).f
    missed = ~np.isfinite(points).all(axis=(1, 2))
    if missed.any():
        raise Refused(
            f"rays through face {part.faces[rows[missed][0]]}, beyond which the surface lies, meet none: give a finer "
            "mesh or other normals there"
        )


def _flat_part(found: Hull, places: Places) -> Part:
    faces = np.flatnonzero(found.faces == Convexity.ZERO)
    ids = found.mesh.faces[faces]
    whole = np.broadcast_to(np.eye(3), (len(faces), 3, 3))
    return Part(
        BezierTriangles(found.mesh.points[ids]),
        ids,
        places.faces[faces],
        places.of(faces, whole),
        np.zeros_like(ids),
    )


def _face_part(found: Hull, sides: tuple[SideNets, SideNets], split: Bool, places: Places) -> Part:
    mesh = found.mesh
    face, third, half = _face_rows(found)
    pinch = pinches(found)
    row = np.arange(len(face))
    fan, cut = third >= 0, half > 0
    ids = mesh.faces[face].copy()
    weights = np.broadcast_to(np.eye(3), (len(face), 3, 3)).copy()  # of the patch's corners, in the face
    ids[row[fan], third[fan]] = len(mesh.points) + face[fan]
    weights[row[fan], third[fan]] = 1.0 / 3.0
    # the half next to p_i, the corner after the centre, ends at the pinch in place of p_j, the other one begins there
    side = (third + 1) % 3
    edge = mesh.face_edges[face, side]
    moved = (third + np.where(half == 1, 2, 1)) % 3
    ids[row[cut], moved[cut]] = len(mesh.points) + len(mesh.faces) + edge[cut]
    at_end = np.where(mesh.face_edge_forward[face, side], pinch[edge], 1.0 - pinch[edge])
    ends = np.zeros((len(face), 3))
    ends[row, side], ends[row, (side + 1) % 3] = 1.0 - at_end, at_end
    weights[row[cut], moved[cut]] = ends[cut]

    # three cubics are written over thirds of the face, where the centre is a corner; others over the whole face
    over_third = fan & split[face]
    base = mesh.points[mesh.faces[face]]
    base[row[over_third], third[over_third]] = base[over_third].mean(axis=1)
    corners = weights.copy()
    corners[row[over_third], third[over_third]] = np.eye(3)[third[over_third]]

    apexes = np.moveaxis(found.apexes[:, face], 0, 1)
    nets, rational = np.full((len(face), 2, 20), np.nan), np.full((len(face), 2, 3), np.nan)
    for k, (sign, nets_here) in enumerate(zip(SIDES, sides, strict=True)):
        pieces = nets_here.faces.pieces()
        all_nets = sign * pieces.nets(nets_here.top[pieces.owner])
        owner = nets_here.faces.rows(len(mesh.faces))[face]
        here = owner >= 0
        piece = np.searchsorted(pieces.owner, owner[here]) + np.where(over_third, third, 0)[here]
        nets[here, k], rational[here, k] = all_nets[piece], sign * pieces.rational[piece]
    strands = np.zeros_like(ids)
    for s in range(3):
        outer = ~fan | (side == s)
        at = mesh.face_edges[face, s]
        strands[:, s] = np.where(outer & with_patches(found)[at], np.where(mesh.face_edge_forward[face, s], 1, 2), 0)
    batch = ShootingTriangles(base=base, apexes=apexes, nets=nets, rational=rational, corners=corners)
    return Part(batch, ids, places.faces[face], places.of(face, weights), strands)


def _face_rows(found: Hull) -> tuple[Int, Int, Int]:
    """Return the patches of faces: face, third (-1 for all of it) and half (0 for all of it), (P,) each, by face."""
    pinched = (found.edges == Convexity.NONCONVEX) & with_patches(found)
    # third s lies at the edge opposite corner s, which is side s + 1
    halves = np.where(pinched[np.roll(found.mesh.face_edges, -1, axis=1)], 2, 1)
    count = np.where((found.faces == Convexity.NONCONVEX)[:, None], halves, 0)
    whole = (found.faces == Convexity.POSITIVE) | (found.faces == Convexity.NEGATIVE)
    per_slot = np.concatenate([whole[:, None].astype(np.int64), count], axis=1)  # slot 0: the whole face
    slot = np.repeat(np.arange(per_slot.size), per_slot.ravel())
    starts = np.searchsorted(slot, slot)
    face, third = slot // 4, slot % 4 - 1
    half = np.where(per_slot.ravel()[slot] == 2, np.arange(len(slot)) - starts + 1, 0)
    return face, third, half


def _edge_part(found: Hull, sides: tuple[SideNets, SideNets], places: Places) -> Part:
    mesh = found.mesh
    own = np.flatnonzero(with_patches(found))
    pinch = pinches(found)
    parts = np.where(np.isfinite(pinch[own]), 2, 1)
    edge = np.repeat(own, parts)
    second = np.arange(len(edge)) - np.searchsorted(edge, edge) == 1
    pinched = np.isfinite(pinch[edge])
    middle = len(mesh.points) + len(mesh.faces) + edge
    start, end = mesh.edges[edge].T
    first_id, last_id = np.where(second, middle, start), np.where(pinched & ~second, middle, end)
    span = np.stack([np.where(second, pinch[edge], 0.0), np.where(pinched & ~second, pinch[edge], 1.0)], axis=-1)
    back, ahead = mesh.edge_faces[edge][:, 1], mesh.edge_faces[edge][:, 0]
    apexes = np.full((len(edge), 2, 2, 3), np.nan)
    nets, rational = np.full((len(edge), 2, 20), np.nan), np.full((len(edge), 2, 4), np.nan)
    for k, (sign, nets_here) in enumerate(zip(SIDES, sides, strict=True)):
        row = np.full(len(mesh.edges), -1)
        row[nets_here.edges.edges] = np.arange(len(nets_here.edges.edges))
        here = row[edge] >= 0
        chosen = row[edge[here]]
        apexes[here, k] = np.stack([found.apexes[k, back[here]], found.apexes[k, ahead[here]]], axis=1)
        nets[here, k] = sign * nets_here.edges.nets[chosen]
        rational[here, k] = sign * nets_here.edges.rational[chosen]
    ends = np.stack([mesh.points[start], mesh.points[end]], axis=1)
    side = np.argmax(mesh.face_edges[ahead] == edge[:, None], axis=1)
    weights = np.zeros((len(edge), 4, 3))
    for corner, x in enumerate((span[:, 0], span[:, 1], span[:, 1], span[:, 0])):
        weights[np.arange(len(edge)), corner, side] = 1.0 - x
        weights[np.arange(len(edge)), corner, (side + 1) % 3] = x
    return Part(
        ShootingQuads(ends=ends, apexes=apexes, nets=nets, rational=rational, span=span),
        np.stack([first_id, last_id, last_id, first_id], axis=-1),
        places.faces[ahead],
        places.of(ahead, weights),
        np.broadcast_to(np.array([2, 0, 1, 0]), (len(edge), 4)),
    )
