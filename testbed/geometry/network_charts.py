"""Networks of S-patches as charts: each patch a map from its regular polygon, and the triangles to begin with."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bernstein import subdivide_curve
from testbed.geometry.charted import ChartedMesh, triangle_fan
from testbed.geometry.charted_surface import BoundedCharts, CurvedBoxes
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.network_bounds import ROUNDING, curved_boxes
from testbed.geometry.simplex_bernstein import side_places
from testbed.geometry.spline_network import SplineNetwork
from testbed.geometry.vectors import Float, Int

#: Halvings of the boundary curves for the boxes of the rim.
RIM_HALVINGS = 3


@dataclass(frozen=True, eq=False)
class NetworkCharts(BoundedCharts):
    """The patches of a network as charts; chart p is patch p.

    Parameters
    ----------
    network
        The patches, of several numbers of sides and depths.
    """

    network: SplineNetwork

    def __eq__(self, other: object) -> bool:
        """Whether the networks are of the same control mesh, which alone determines them."""
        if not isinstance(other, NetworkCharts):
            return NotImplemented
        mine, others = self.network.mesh, other.network.mesh
        return mine.faces == others.faces and np.array_equal(mine.points, others.points)

    def __hash__(self) -> int:
        return hash((self.network.mesh.faces, self.network.mesh.points.tobytes()))

    def __len__(self) -> int:
        return len(self.network)

    def polygon(self, chart: int) -> Float:
        """Corners (n, 2) of the patch's regular polygon."""
        return self.network.parts[int(self.network.part[chart])].corners

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        """Jets (rows, N, 3) at points (N, 2) of the polygons of patches (N,)."""
        result = np.empty((ROWS[order], len(at), 3))
        part = self.network.part[chart]
        for number, patches in enumerate(self.network.parts):
            (here,) = np.nonzero(part == number)
            result[:, here] = patches.jets_of(self.network.index[chart[here]], at[here], order).coefficients
        return Jet(result)

    def boxes(self) -> CurvedBoxes:
        """Boxes (B, 3) of pieces of all patches, with bounds of the curvature; seconds for many-sided patches."""
        boxes = [curved_boxes(patches) for patches in self.network.parts]
        low, high, bound = (np.concatenate([getattr(one, name) for one in boxes]) for name in ("low", "high", "bound"))
        return CurvedBoxes(low, high, bound)

    def rim(self) -> tuple[Float, Float]:
        """Boxes (R, 3) of pieces of the sides of patches that have no neighbour."""
        mesh, network = self.network.mesh, self.network
        corners, patch = network.sides_of_patches()
        beyond = mesh.twin[corners]
        ends = (beyond < 0) | ~np.isin(mesh.face[beyond], network.faces)
        side = corners - mesh.first_corner[mesh.face[corners]]
        low, high = [np.empty((0, 3))], [np.empty((0, 3))]
        for number, patches in enumerate(network.parts):
            here = ends & (network.part[patch] == number)
            places = side_places(patches.sides, patches.depth)[side[here]]
            curves = patches.control_points[network.index[patch[here]][:, None], places]
            for _ in range(RIM_HALVINGS):
                curves = np.concatenate(subdivide_curve(curves))
            loose = ROUNDING * np.abs(curves).max(initial=0.0)
            low.append(curves.min(axis=1) - loose)
            high.append(curves.max(axis=1) + loose)
        return np.concatenate(low), np.concatenate(high)


def charted_network(network: SplineNetwork) -> ChartedMesh:
    """Return the coarsest triangles of a network: from each patch's sides to its centre; triangles stay whole.

    The sides of the patches are followed. Vertices: those of the control mesh that are corners of patches, in their
    order, then the centres, in the order of the patches.
    """
    mesh, sides = network.mesh, network.sides
    first = mesh.first_corner[network.faces]
    used = np.unique(mesh.vertex[np.isin(mesh.face, network.faces)])
    split = sides > 3
    centre = len(used) + np.cumsum(split) - 1
    rows = []
    for number, patches in enumerate(network.parts):
        (chart,) = np.nonzero(network.part == number)
        corners = np.searchsorted(used, mesh.vertex[first[chart][:, None] + np.arange(patches.sides)])
        if patches.sides == 3:
            faces, at, follow = corners[:, None], patches.corners[None], np.ones((1, 3), dtype=np.bool_)
        else:
            middle = np.broadcast_to(centre[chart][:, None], corners.shape)
            faces = np.stack([corners, np.roll(corners, -1, axis=1), middle], axis=-1)
            at, _ = triangle_fan(patches.corners)
            follow = np.broadcast_to([True, False, False], (patches.sides, 3))
        count, tiles = len(chart), faces.shape[1]
        rows.append(
            (np.repeat(chart, tiles), faces.reshape(-1, 3), np.tile(at, (count, 1, 1)), np.tile(follow, (count, 1)))
        )
    chart, faces, at, follow = (np.concatenate(column) for column in zip(*rows, strict=True))
    order = np.argsort(chart, kind="stable")
    return ChartedMesh(NetworkCharts(network), faces[order], chart[order], at[order], follow[order])
