"""Clough and Tocher's interpolant of heights, as in scipy: three cubic Bezier triangles a face, C1 over the plane.

What a user would reach for to interpolate scattered heights, and two remedies where the heights must not be negative.
It is the function of ``scipy.interpolate.CloughTocher2DInterpolator`` where the mesh is the Delaunay triangulation of
its vertices; over another one it is the same construction. scipy finds its gradients by an iteration that stops at
changes below 1e-6; here they are the solution that it approaches.

Formulas: the element as in Alfeld 1984 and Farin 1986, with directions from centroid to centroid; gradients as in
Nielson 1983, Renka and Cline 1984. **Fill**: the reduced gradients of ``positive``.
"""

import dataclasses
from dataclasses import dataclass
from typing import Literal

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_checks import named
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.clipped_triangles import ClippedTriangles
from testbed_schemes.mathematics.clough_tocher_nets import (
    centroid_ratios,
    edge_ordinates,
    least_bending_gradients,
    positive_shares,
    second_row,
)
from testbed_schemes.mathematics.split_domain import J, K, c1_cubics

#: A face is upright if its area in the plane is less than this part of the square of its longest side there.
UPRIGHT = 1e-12
#: A tangent plane is upright if its normal's third component is less.
STEEP = 1e-9


@dataclass(frozen=True)
class CloughTocher(Scheme):
    """Clough-Tocher cubics on heights z over the (x, y) plane.

    Parameters
    ----------
    gradients
        Where the slopes at the vertices come from: ``estimated`` from the heights, so that the curves over the edges
        bend least, or ``data``, the normals of the mesh.
    clip
        Replace z by max(z, 0), the usual remedy for negative values: the surface gets a crease where z vanishes, inside
        the patches. Heights of the data must not be negative.
    positive
        Reduce the slopes, vertex by vertex, until no Bezier ordinate is negative: z >= 0, and C1 as before. Heights of
        the data must not be negative.

    Raises
    ------
    SpecError
        Both remedies at once.
    """

    gradients: Literal["estimated", "data"] = "estimated"
    clip: bool = False
    positive: bool = False

    name = "clough-tocher"
    title = "Clough-Tocher"
    reference = "Alfeld 1984; Nielson 1983; as in scipy.interpolate.CloughTocher2DInterpolator"
    formula = (
        "Split cubics over the plane with C1 inner joins; the derivative across an edge, from centroid to centroid, is "
        "linear along it; gradients minimise the sum of the squared second derivatives over the edges."
    )
    status = (
        "As published, and as in scipy, with the gradients that scipy's iteration approaches; fill: the reduced "
        "gradients of positive."
    )
    failures = (
        "Undershoots: heights >= 0 give surfaces below zero beside steep rises. Clipped, it is creased there; "
        "positive, level at vertices of height zero, and refused at edges whose faces lie aslant of each other. Takes "
        "heights only: refuses closed meshes."
    )
    reproduces = (Shape.PLANES,)
    restricted = True
    vertical = True

    def __post_init__(self) -> None:
        """Check that there is one remedy at most."""
        if self.clip and self.positive:
            raise SpecError(f"{self.name}: clip and positive are two remedies for the same: give one of them")

    @property
    def needs(self) -> Data:  # type: ignore[override]  # what is read depends on the parameters
        """Normals, if the slopes are the data's."""
        return Data.POINTS if self.gradients == "estimated" else Data.POINTS | Data.NORMALS

    @property
    def matches(self) -> Data:  # type: ignore[override]  # likewise
        """Normals, if the slopes are the data's and stay as they are."""
        return Data.POINTS if self.clip or self.positive else self.needs

    @property
    def continuity(self) -> Continuity:  # type: ignore[override]  # likewise
        """C1 over the plane; with creases, which cross edges, only C0."""
        return Continuity.C0 if self.clip else Continuity.C1

    @property
    def order(self) -> float | None:  # type: ignore[override]  # likewise
        """Three with exact slopes, for the element contains all quadratic polynomials."""
        return 3 if self.gradients == "data" and not self.positive else None

    @property
    def support(self) -> int | None:  # type: ignore[override]  # likewise
        """The whole mesh, for estimated slopes; with the data's, the neighbours' centroids."""
        return None if self.gradients == "estimated" else 2 if self.positive else 1

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build three cubics a face."""
        check_graph(self, mesh)
        points, heights = mesh.points[:, :2] / mesh.h, mesh.points[:, 2] / mesh.h
        if self.clip or self.positive:
            check_heights(self, heights * mesh.h)
        if self.gradients == "data":
            gradients = slopes_of_normals(self, mesh)
        else:
            gradients = least_bending_gradients(points, heights, mesh.edges)
        ratios = centroid_ratios(points, mesh)
        branches: dict[str, int] = {}
        if self.positive:
            shares, rows = positive_shares(points, heights, gradients, ratios, mesh)
            check_rows(self, mesh, rows)
            gradients = shares[:, None] * gradients
            branches["vertices with reduced slopes"] = int(np.count_nonzero(shares < 1.0))
        curves = edge_ordinates(points[mesh.faces], heights[mesh.faces], gradients[mesh.faces])
        ordinates = c1_cubics(curves[..., None], second_row(curves, ratios)[..., None])
        if self.positive:
            ordinates = np.maximum(ordinates, 0.0)  # of those reduced to zero, rounding leaves some below
        net = np.concatenate([plane_nets(mesh.points[mesh.faces, :2]), mesh.h * ordinates], axis=-1)
        batch = BezierTriangles(net.reshape(-1, *net.shape[2:]))
        if self.clip:
            below = (ordinates[..., 0].reshape(len(mesh.faces), -1) < 0.0).any(axis=1)
            branches["faces with ordinates below zero"] = int(below.sum())
            surface = Surface.over_split_faces(mesh, ClippedTriangles(batch))
        else:
            surface = Surface.over_split_faces(mesh, batch)
        return dataclasses.replace(surface, branches=branches)


def plane_nets(corners: Float) -> Float:
    """Nets (F, 3, 10, 2) of the linear maps onto the three parts of faces with corners (F, 3, 2)."""
    start, end = corners[:, J, None], corners[:, K, None]
    share = np.arange(4)[:, None] / 3.0
    centre = corners.mean(axis=1)[:, None]
    return c1_cubics((1.0 - share) * start + share * end, (start[:, :, 0] + end[:, :, 0] + centre) / 3.0)


def check_graph(scheme: Scheme, mesh: HermiteMesh) -> None:
    """Refuse a mesh whose faces do not all lie over the (x, y) plane the same way round."""
    sides = (mesh.points[np.roll(mesh.faces, -1, axis=1)] - mesh.points[mesh.faces])[..., :2] / mesh.h
    area = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    upward = area.sum() > 0.0
    unfit = ~((area if upward else -area) > UPRIGHT * (sides**2).sum(axis=-1).max(axis=-1))
    if unfit.any():
        raise Refused(
            f"{scheme} takes heights over the (x, y) plane, and {named(mesh.faces, int(np.argmax(unfit)))} stands "
            f"upright or lies the other way round than most ({int(unfit.sum())} of {len(mesh.faces)} do): turn the "
            "mesh, or use a scheme for surfaces in space"
        )


def check_heights(scheme: Scheme, heights: Float) -> None:
    """Refuse heights (V,) below zero where the surface has to stay above."""
    below = heights < 0.0
    if below.any():
        vertex = int(np.argmax(below))
        raise Refused(
            f"{scheme} keeps z >= 0, and vertex {vertex} has z = {heights[vertex]:.6g} ({int(below.sum())} of "
            f"{len(heights)} vertices are below zero): move the data up, or leave out the remedy"
        )


def check_rows(scheme: Scheme, mesh: HermiteMesh, rows: Float) -> None:
    """Refuse faces whose ordinates Q_i (F, 3) of vanishing slopes are negative: they lie aslant of their neighbours."""
    if (rows < 0.0).any():
        face, edge = (int(index[0]) for index in np.nonzero(rows < 0.0))
        i, j = sorted(mesh.faces[face, [(edge + 1) % 3, (edge + 2) % 3]].tolist())
        raise Refused(
            f"{scheme} has no positive cubics at the edge from vertex {i} to vertex {j}, the first of "
            f"{int((rows < 0.0).sum())} sides, where the centroids of the two faces lie on a line beside the edge: "
            "flip the edge, or make the faces there less oblique"
        )


def slopes_of_normals(scheme: Scheme, mesh: HermiteMesh) -> Float:
    """Gradients (V, 2) of the tangent planes; Refused where one is upright."""
    assert mesh.normals is not None  # noqa: S101 - the mesh has what is needed
    steep = ~(np.abs(mesh.normals[:, 2]) > STEEP)
    if steep.any():
        raise Refused(
            f"{scheme} takes heights over the (x, y) plane, and the tangent plane at vertex {int(np.argmax(steep))} "
            "stands upright: turn the normal, or use gradients=estimated"
        )
    return -mesh.normals[:, :2] / mesh.normals[:, 2:]
