"""Meshes of parametrised surfaces: each face lies in a chart, and new vertices are found there, not by projection."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.face_data import FaceData
from testbed.geometry.jets import Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int, norm, unit

#: Second forms at a vertex that differ by more than this, relatively, from face to face are kept apart.
JUMP = 1e-9
#: Points of neighbouring charts this near, relative to the size of the surface, are the same.
SAME = 1e-9
#: Barycentric coordinates of a corner below this are zero: the corner is on a side of the parent.
ON_SIDE = 1e-12
#: A triangle halved along all sides: its corner children and the middle one, each by its corners' barycentrics.
HALVED = np.array(
    [
        [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5]],
        [[0.0, 1.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.5, 0.0]],
        [[0.0, 0.0, 1.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
        [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]],
    ]
)


class Charts(ABC):
    """Parametrised pieces of a surface, which join at least with one tangent plane; stateless.

    A chart is a smooth map from a convex polygon in the plane. Neighbouring charts share whole sides of their polygons.
    """

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of charts."""

    @abstractmethod
    def polygon(self, chart: int) -> Float:
        """Corners (n, 2) of the parameter domain of a chart, counterclockwise."""

    @abstractmethod
    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        """Jets at parameters ``at`` (N, 2) of charts (N,): coefficients (rows, N, 3).

        f_u x f_v points along the outward normal. Results do not depend on how the points are divided over calls.
        """


@dataclass(frozen=True, eq=False)
class ChartedMesh:
    """A triangle mesh on a parametrised surface.

    Parameters
    ----------
    charts
        The surface.
    faces
        (F, 3) vertex ids 0 to V - 1, each of them in use, counterclockwise in the charts.
    chart
        (F,) the chart each face lies in.
    at
        (F, 3, 2) parameters of the faces' corners there.
    followed
        (F, 3) true for sides on the boundary of the surface or between charts: the images of straight lines in the
        parameters, which patches have to follow. Side s runs from corner s to corner s + 1.
    """

    charts: Charts
    faces: Int
    chart: Int
    at: Float
    followed: Bool

    @property
    def vertices(self) -> int:
        """Number of vertices."""
        return int(self.faces.max()) + 1

    def jets(self, order: int = 2) -> Jet:
        """Jets at the corners of all faces, each in its own chart: (rows, F, 3 corners, 3)."""
        count = len(self.faces)
        flat = self.charts.jets(np.repeat(self.chart, 3), self.at.reshape(-1, 2), order)
        return Jet(flat.coefficients.reshape(-1, count, 3, 3))

    def sampled(self) -> HermiteMesh:
        """Return the mesh with positions, normals and second forms of the surface.

        A vertex has the position and normal of the first corner at it. Where the charts' second forms differ at a
        vertex its own is their mean, and each face has its chart's (``FaceData.corner_second_forms``). Followed sides
        have the tangents of the curve along them.

        Raises
        ------
        ValueError
            The charts disagree on the position of a vertex.
        """
        jet = self.jets()
        ids = self.faces.ravel()
        # the first corner at each vertex, in the order of the ids
        first = np.full(self.vertices, len(ids), dtype=np.int64)
        np.minimum.at(first, ids, np.arange(len(ids)))
        at_corners = jet.f.reshape(-1, 3)
        points, normals = at_corners[first], jet.normal.reshape(-1, 3)[first]
        apart = norm(at_corners - points[ids])
        allowed = SAME * float(np.ptp(points, axis=0).max(initial=0.0))
        if not (apart <= allowed).all():
            corner = int(np.argmax(~(apart <= allowed)))
            raise ValueError(
                f"chart {self.chart[corner // 3]} has vertex {ids[corner]} {apart[corner]:.1e} away from where another "
                "chart has it: neighbouring charts have to share their sides"
            )
        n = normals[ids]
        own = tangential_part(second_form_matrix(jet).reshape(-1, 3, 3), n)
        forms = mean_by_vertex(own, ids, first)
        size = np.abs(own).max(initial=0.0)
        disagree = np.abs(own - forms[ids]).max(axis=(1, 2)) > JUMP * size
        by_corner = own.reshape(-1, 3, 3, 3) if disagree.any() else None
        tangents = self._tangents(jet, normals)
        of_faces = FaceData(None, by_corner, tangents if self.followed.any() else None)
        return HermiteMesh(points, self.faces, normals, forms, face_data=of_faces)

    def _tangents(self, jet: Jet, normals: Float) -> Float:
        """Unit tangents (F, 3, 2, 3) along followed sides at their ends, NaN on the others."""
        step = np.roll(self.at, -1, axis=1) - self.at
        ends = []
        for shift in (0, -1):
            fu, fv = np.roll(jet.fu, shift, axis=1), np.roll(jet.fv, shift, axis=1)
            along = step[..., :1] * fu + step[..., 1:] * fv
            n = normals[np.roll(self.faces, shift, axis=1)]
            # normals of two charts agree to rounding only
            ends.append(unit(along - (along * n).sum(axis=-1, keepdims=True) * n))
        both = np.stack(ends, axis=2)
        both[~self.followed] = np.nan
        return both

    def split(self, faces: Int, parent: Int, bary: Float) -> "ChartedMesh":
        """Return the mesh of children of these faces.

        Parameters
        ----------
        faces
            (N, 3) vertex ids of the children.
        parent
            (N,) the face each lies in.
        bary
            (N, 3, 3) barycentric coordinates, in the parent, of the child's corners.
        """
        at = np.einsum("nck,nkx->ncx", bary, self.at[parent])
        # a child's side from c to c + 1 lies on the parent's side s where the coordinate opposite vanishes at both ends
        opposite = np.abs(bary[:, :, [2, 0, 1]]) <= ON_SIDE
        on_side = opposite & np.roll(opposite, -1, axis=1)
        followed: Bool = np.asarray((on_side & self.followed[parent][:, None]).any(axis=2))
        return replace(self, faces=faces, chart=self.chart[parent], at=at, followed=followed)

    def halved(self, levels: int = 1) -> "ChartedMesh":
        """Return the mesh with every edge split at the middle of its parameters, every face in four, some times over.

        Vertices keep their ids; children 4 f to 4 f + 3 are those of face f.
        """
        mesh = self
        for _ in range(levels):
            count, faces = mesh.vertices, mesh.faces
            start, end = faces, np.roll(faces, -1, axis=1)
            _, side = np.unique(np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True)
            side = count + side.reshape(faces.shape)
            after, before = side, np.roll(side, 1, axis=1)
            corners = np.stack([faces, after, before], axis=-1)
            children = np.concatenate([corners, side[:, None]], axis=1).reshape(-1, 3)
            parent = np.repeat(np.arange(len(faces)), 4)
            mesh = mesh.split(children, parent, np.tile(HALVED, (len(faces), 1, 1)))
        return mesh


def tangential_part(forms: Float, normals: Float) -> Float:
    """Second forms (N, 3, 3) of charts as symmetric forms of the tangent planes with unit normals (N, 3)."""
    plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    projected = plane @ forms @ plane
    symmetric: Float = 0.5 * (projected + projected.swapaxes(-1, -2))
    return symmetric


def mean_by_vertex(forms: Float, ids: Int, first: Int) -> Float:
    """Means (V, 3, 3) of forms (C, 3, 3) at corners with vertex ids (C,); exactly the first where all are equal."""
    count = np.bincount(ids).astype(np.float64)
    away = (forms - forms[first[ids]]).reshape(-1, 9)
    summed = np.stack([np.bincount(ids, weights=away[:, column]) for column in range(9)], axis=-1)
    mean: Float = forms[first] + (summed / count[:, None]).reshape(-1, 3, 3)
    return mean


def triangle_fan(polygon: Float) -> tuple[Float, Float]:
    """Parameters of a polygon's triangles from its centre: (n, 3, 2) corners c, c + 1, centre, and the centre (2,)."""
    centre = polygon.mean(axis=0)
    corners = np.stack([polygon, np.roll(polygon, -1, axis=0), np.broadcast_to(centre, polygon.shape)], axis=1)
    return corners, centre
