"""Generalised bicubic B-splines: smooth networks of S-patches from control meshes in which four edges meet inside.

Each face whose vertices are all inside the mesh becomes a patch: a bicubic patch for a quadrilateral, an S-patch of
depth 6 for any other polygon. On a regular grid it is the uniform bicubic B-spline surface. Neighbouring patches share
cubic boundary curves and join with one tangent plane (G1); their second fundamental forms differ at the other polygons.

Sources: Loop and DeRose 1990 and Loop 1992, as restated by Salvi 2020 (*G1 hole filling with S-patches made easy*,
equation 2). As printed there: the tangent planes along the sides. Fills: the masks of polygons that are not
quadrilaterals (:meth:`SabinNet.of`), and the control points that no side touches (:func:`inner_net`).
"""

from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.polygon_coordinates import regular_polygon
from testbed.geometry.polygon_mesh import PolygonMesh
from testbed.geometry.s_patches import SPatches, tensor_net
from testbed.geometry.simplex_bernstein import elevate_simplex, simplex_multi_indices, simplex_places
from testbed.geometry.vectors import Float, Int

#: Degree of the boundary curves, and depth of the four-sided patches.
CUBIC = 3
#: Depth of the others: the cubic's, and three more for the factors that turn one tangent plane into the other.
DEPTH = CUBIC + 3
#: Polygons with more corners are refused: a patch has C(n + 5, 6) control points.
MOST_SIDES = 12


@dataclass(frozen=True, eq=False)
class SplineNetwork:
    """The patches of a control mesh.

    Parameters
    ----------
    mesh
        The control mesh.
    faces
        (P,) its faces that have a patch, in their order; patch p is that of face ``faces[p]``, its corners and sides
        those of the face.
    parts
        Batches of the patches, one for each number of sides.
    part, index
        (P,) part of each patch, and place in it.

    Notes
    -----
    Corner i of a patch is the image of corner i of its polygon and belongs to vertex i of its face.
    """

    mesh: PolygonMesh
    faces: Int
    parts: tuple[SPatches, ...]
    part: Int
    index: Int

    def __len__(self) -> int:
        return len(self.faces)

    @property
    def sides(self) -> Int:
        """(P,) number of sides of each patch."""
        return self.mesh.sizes[self.faces]

    def sides_of_patches(self) -> tuple[Int, Int]:
        """Corners (K,) of the control mesh that the sides of patches leave, and the patch of each, (K,)."""
        patch = np.full(len(self.mesh.faces), -1)
        patch[self.faces] = np.arange(len(self))
        (corners,) = np.nonzero(patch[self.mesh.face] >= 0)
        return corners, patch[self.mesh.face[corners]]


def spline_network(mesh: PolygonMesh) -> SplineNetwork:
    """Build the patches of a control mesh.

    Parameters
    ----------
    mesh
        Four edges meet at every vertex inside. Faces with a vertex on the boundary are there for control only.

    Raises
    ------
    MeshError
        A vertex inside with another number of edges, a polygon with too many corners, no face with all vertices inside.
    """
    irregular = mesh.inside & (mesh.valence != 4)
    if irregular.any():
        vertex = int(np.argmax(irregular))
        raise MeshError(
            f"{mesh.valence[vertex]} edges meet at vertex {vertex} of the control mesh: give it four, as every vertex "
            "inside needs"
        )
    at_boundary = np.zeros(len(mesh.faces), dtype=np.bool_)
    at_boundary[mesh.face[~mesh.inside[mesh.vertex]]] = True
    faces = np.flatnonzero(~at_boundary)
    if not len(faces):
        raise MeshError(
            "every face of the control mesh has a vertex on its boundary, and no patch is left: add a ring of faces "
            "along the boundary"
        )
    sizes = mesh.sizes[faces]
    if (sizes > MOST_SIDES).any():
        large = int(np.argmax(sizes > MOST_SIDES))
        raise MeshError(
            f"face {faces[large]} of the control mesh has {sizes[large]} corners: divide it, patches have at most "
            f"{MOST_SIDES} sides"
        )
    net = SabinNet.of(mesh)
    parts: list[SPatches] = []
    part, index = np.empty_like(faces), np.empty_like(faces)
    for sides in np.unique(sizes).tolist():
        chosen = sizes == sides
        part[chosen], index[chosen] = len(parts), np.arange(chosen.sum())
        corners = mesh.first_corner[faces[chosen]][:, None] + np.arange(sides)
        parts.append(quad_patches(net, corners) if sides == 4 else polygon_patches(net, corners))
    return SplineNetwork(mesh, faces, tuple(parts), part, index)


@dataclass(frozen=True, eq=False)
class SabinNet:
    """Bezier points that the masks of the bicubic B-spline give the corners of a control mesh.

    Parameters
    ----------
    vertex
        (C, 3) the point of the corner's vertex; the same for all corners there.
    start, end
        (C, 3) inner points of the cubic along the side that leaves the corner, near its start and near its end.
    twist
        (C, 3) the inner point of the patch next to the corner.

    Notes
    -----
    Corners on the boundary and those beside it hold numbers of no meaning.
    """

    vertex: Float
    start: Float
    end: Float
    twist: Float

    @classmethod
    def of(cls, mesh: PolygonMesh) -> "SabinNet":
        """Apply the masks.

        Twist point: (3 v + v_- + v_+ + 4 c) / 9 for the neighbours v_-, v_+ in the face and its centroid c, which for a
        quadrilateral is the mask (4 v + 2 v_- + 2 v_+ + opposite) / 9 of the B-spline and for others a fill. Points on
        edges are means of the twist points of the two faces there, those at vertices of the four.
        """
        points, twin = mesh.points[mesh.vertex], np.where(mesh.twin < 0, np.arange(len(mesh.twin)), mesh.twin)
        centroid = sums(points, mesh.face) / mesh.sizes[:, None]
        neighbours = points[mesh.previous] + points[mesh.following]
        twist = (3.0 * points + neighbours + 4.0 * centroid[mesh.face]) / 9.0
        # the neighbouring face has this corner's vertex at the end of the twin side
        start = 0.5 * (twist + twist[mesh.following[twin]])
        at_vertex = sums(twist, mesh.vertex) / mesh.valence[:, None]
        return cls(at_vertex[mesh.vertex], start, start[twin], twist)

    def rows(self, corners: Int) -> tuple[Float, Float]:
        """First and second rows of control points along the sides of patches.

        ``corners`` (P, n) in the order of the faces; both (P, n, 4, 3), from the start of a side to its end. The second
        row: the last inner point of the side before, the two twist points, the first inner point of the next side.
        """
        before, after = np.roll(corners, 1, axis=1), np.roll(corners, -1, axis=1)
        first = (self.vertex[corners], self.start[corners], self.end[corners], self.vertex[after])
        second = (self.end[before], self.twist[corners], self.twist[after], self.start[after])
        return np.stack(first, axis=2), np.stack(second, axis=2)


def sums(values: Float, group: Int) -> Float:
    """Sums (G, 3) of vectors (C, 3) by group (C,), one after the other in their order."""
    return np.stack([np.bincount(group, weights=values[:, axis]) for axis in range(3)], axis=-1)


def quad_patches(net: SabinNet, corners: Int) -> SPatches:
    """Bicubic patches (P, 4 corners) as S-patches of depth 3; in b_ij, i runs along side 0 and j back along side 3."""
    first, second = net.rows(corners)
    bicubic = np.empty((len(corners), 4, 4, 3))
    bicubic[:, :, 0], bicubic[:, :, 3] = first[:, 0], first[:, 2, ::-1]
    bicubic[:, 1:3, 1], bicubic[:, 1:3, 2] = second[:, 0, 1:3], second[:, 2, 2:0:-1]
    bicubic[:, 3, 1:3], bicubic[:, 0, 1:3] = first[:, 1, 1:3], first[:, 3, 2:0:-1]
    return SPatches(tensor_net(bicubic), 4, CUBIC)


def polygon_patches(net: SabinNet, corners: Int) -> SPatches:
    """S-patches of depth 6 (P, n corners) whose tangent planes along their sides are those of the bicubic neighbours.

    The control points (5 - j) e_i + j e_{i+1} + e_k, k = 0 .. n - 1, are an affine image of the regular polygon for
    every side i and j = 0 .. 5: then the derivatives across the side are polynomials, combinations of one across and
    the one along.
    """
    count, sides = corners.shape
    first, second = net.rows(corners)
    control = elevate_simplex(inner_net(first, second), sides, CUBIC, DEPTH - CUBIC)
    boundary = elevate_curve(first, DEPTH - CUBIC)
    start, end = boundary[:, :, :-1], boundary[:, :, 1:]
    legs = cross_boundary_legs(first, second)
    # by side i, place j along it and corner k
    panels = affine_polygons(start, end, start + legs)
    i, j, k = np.ogrid[:sides, :DEPTH, :sides]
    unit = np.eye(sides, dtype=np.int64)
    labels = (DEPTH - 1 - j)[..., None] * unit[i] + j[..., None] * unit[(i + 1) % sides] + unit[k]
    control[:, simplex_places(labels).ravel()] = panels.reshape(count, -1, 3)
    return SPatches(control, sides, DEPTH)


def cross_boundary_legs(first: Float, second: Float) -> Float:
    """Control points (P, n, 6, 3) of the derivative in the direction p_{i-1} - p_i along side i, over the depth.

    D S(t) = f C'(t) + 3 g R(t) with the boundary cubic C, the difference R of the second row and the first, and

        f = 2 c t,   g = 1 + 2 c t (1 - t),   c = -cos(2 pi / n).

    The corners ask for f(0) = 0, f(1) = 2 c, g(0) = g(1) = 1, and the twist points that two sides share for
    f'(0) = g'(0) and f'(1) = -g'(1); these are the polynomials of the lowest degree.
    """
    c = -np.cos(2.0 * np.pi / first.shape[1])
    across = second - first
    along = first[:, :, 1:] - first[:, :, :-1]
    legs = np.zeros((*first.shape[:2], DEPTH, 3))
    for power, factor in enumerate((1.0, 2.0, 1.0)):  # t ((1 - t) + t)^2
        for k in range(CUBIC):
            legs[:, :, k + power + 1] += 2.0 * c * factor * comb(CUBIC - 1, k) * along[:, :, k]
    for power, factor in enumerate((1.0, 2.0 + 2.0 * c, 1.0)):
        for k in range(CUBIC + 1):
            legs[:, :, k + power] += factor * comb(CUBIC, k) * across[:, :, k]
    binomials = np.array([comb(DEPTH - 1, j) for j in range(DEPTH)], dtype=np.float64)
    legs *= (CUBIC / DEPTH) / binomials[:, None]
    return legs


def affine_polygons(start: Float, end: Float, before: Float) -> Float:
    """Affine images (P, n, ..., n corners, 3) of the regular polygon, by side i (axis 1).

    Corner i goes to ``start``, corner i + 1 to ``end`` and corner i - 1 to ``before``, (P, n, ..., 3) each.
    """
    sides = start.shape[1]
    # corner i + m of the polygon in the frame of the corners i, i + 1 and i - 1, whatever i
    frame = frame_weights(sides)
    m = (np.arange(sides) - np.arange(sides)[:, None]) % sides
    weights = frame[m].reshape(sides, *(1,) * (start.ndim - 3), sides, 3)
    parts = (start[..., None, :], end[..., None, :], before[..., None, :])
    image: Float = sum((weights[..., r, None] * part for r, part in enumerate(parts)), start=np.zeros(3))
    return image


@cache
def frame_weights(sides: int) -> Float:
    """Weights (n, 3) of the corners 0, 1 and n - 1 of the regular polygon whose affine combinations its corners are."""
    polygon = regular_polygon(sides)
    legs = np.stack([polygon[1] - polygon[0], polygon[-1] - polygon[0]], axis=-1)
    xy = np.linalg.solve(legs, (polygon - polygon[0]).T).T
    weights = np.column_stack([1.0 - xy.sum(axis=1), xy])
    weights[[0, 1, -1]] = np.eye(3)
    weights.flags.writeable = False
    return weights


def inner_net(first: Float, second: Float) -> Float:
    """Net (P, C(n + 2, 3), 3) of depth 3 with these rows along its sides; a fill, the sources' choice is not known.

    2 e_i + e_k: the affine polygon through the three points at corner i. e_{i-1} + e_i + e_{i+1}: the twist point.
    e_i + e_{i+1} + e_k: the mean of the two affine polygons on the middle of side i that hold a twist point each.
    Labels without neighbouring corners: the mean of the control points that one step of one corner leads to. The one
    inner point of a triangle: the mean of its twist points.
    """
    count, sides = first.shape[:2]
    net = np.zeros((count, len(simplex_multi_indices(sides, CUBIC)), 3))
    unit = np.eye(sides, dtype=np.int64)
    i, k = np.ogrid[:sides, :sides]
    following = (i + 1) % sides
    before = np.roll(first, 1, axis=1)[:, :, 2]
    twist, next_twist = second[:, :, 1], second[:, :, 2]
    # the polygon that holds the other twist point is the mirror image: corner i + 1 + m swaps with corner i - m
    middle = affine_polygons(first[:, :, 1], first[:, :, 2], twist)
    turned = affine_polygons(first[:, :, 2], first[:, :, 1], next_twist)
    mirrored = turned[:, i, (2 * i + 1 - k) % sides]
    net[:, simplex_places(unit[i] + unit[following] + unit[k])] = 0.5 * (middle + mirrored)
    net[:, simplex_places(2 * unit[i] + unit[k])] = affine_polygons(first[:, :, 0], first[:, :, 1], before)
    net[:, simplex_places(unit[i] + unit[following] + unit[(i - 1) % sides])[:, 0]] = twist
    if sides == 3:
        net[:, simplex_places(np.ones(3, dtype=np.int64))] = second[:, :, 1].mean(axis=1)
    # the two middle points of a side are in both its corners' polygons
    unknown, weights = harmonic_weights(sides)
    if len(unknown):
        net[:, unknown] = (weights[None, :, :, None] * net[:, None]).sum(axis=2)
    return net


@cache
def harmonic_weights(sides: int) -> tuple[Int, Float]:
    """Places (U,) of the labels of depth 3 without neighbouring corners, and the weights (U, N) of the others in them.

    Each is the mean of the six that one step of one corner leads to, which may be among them: a linear system.
    """
    labels = simplex_multi_indices(sides, CUBIC)
    apart = (labels <= 1).all(axis=1) & (labels * np.roll(labels, 1, axis=1) == 0).all(axis=1)
    unknown: Int = np.flatnonzero(apart)
    mean = np.zeros((len(unknown), len(labels)))
    unit = np.eye(sides, dtype=np.int64)
    for row, label in enumerate(labels[unknown]):
        steps = [label - unit[c] + unit[(c + step) % sides] for c in np.flatnonzero(label) for step in (-1, 1)]
        np.add.at(mean[row], simplex_places(np.array(steps)), 1.0 / 6.0)
    system = np.eye(len(unknown)) - mean[:, unknown]
    mean[:, unknown] = 0.0
    weights = np.asarray(np.linalg.solve(system, mean), dtype=np.float64)
    for array in (unknown, weights):
        array.flags.writeable = False
    return unknown, weights
