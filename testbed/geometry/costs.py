"""What patches cost: control points to store, and multiplications to evaluate, against a cubic triangle.

A patch of n sides and depth d has C(n - 1 + d, d) control points. One de Casteljau evaluation makes
C(n + d - 1, n) new points out of n each, M(n, d) = n C(n + d - 1, n) multiplications a coordinate; the coordinates of
the polygon are left out. A cubic triangle takes M(3, 3) = 30; a bicubic patch counts as the four-sided S-patch of depth
3 that it is. A tessellation has as many triangles for a patch as it has sides, one for a patch of three sides.

Source: Mann 1992, tables 5.2 and 5.3, whose columns these numbers give; the definition of the cost is a fill that
reproduces every printed one.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import comb

import numpy as np

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.simplex_bernstein import simplex_point_count
from testbed.geometry.spline_network import SplineNetwork
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float

#: Control points nearer than this, relative to the size of all, are one.
SAME = 1e-9


def casteljau_multiplications(sides: int, depth: int) -> int:
    """Multiplications a coordinate of one evaluation, n C(n + d - 1, n)."""
    return sides * comb(sides + depth - 1, sides)


def relative_cost(sides: int, depth: int) -> float:
    """Cost of one evaluation, in those of a cubic triangle."""
    return casteljau_multiplications(sides, depth) / casteljau_multiplications(3, 3)


@dataclass(frozen=True)
class PatchCost:
    """Patches of one kind in a surface.

    Attributes
    ----------
    sides, depth
        Number of sides and depth; of triangles 3 and the degree.
    patches
        How many there are.
    """

    sides: int
    depth: int
    patches: int

    @property
    def points_per_patch(self) -> int:
        """Control points of one patch."""
        return simplex_point_count(self.sides, self.depth)

    @property
    def control_points(self) -> int:
        """Control points of all these patches, none shared."""
        return self.patches * self.points_per_patch

    @property
    def triangles(self) -> int:
        """Triangles of the coarsest tessellation: from the sides of each patch to its centre, three sides one."""
        return self.patches * (1 if self.sides == 3 else self.sides)

    @property
    def relative_cost(self) -> float:
        """Cost of evaluating one point, in those of a cubic triangle."""
        return relative_cost(self.sides, self.depth)


@dataclass(frozen=True)
class SurfaceCost:
    """What a surface costs: a column of table 5.2 or 5.3 for each kind of patches.

    Attributes
    ----------
    kinds
        Its patches, by sides and depth.
    distinct_points
        Control points at different places, as if neighbouring patches shared theirs.
    """

    kinds: tuple[PatchCost, ...]
    distinct_points: int

    @property
    def patches(self) -> int:
        """Number of patches."""
        return sum(kind.patches for kind in self.kinds)

    @property
    def control_points(self) -> int:
        """Control points of all patches, none shared."""
        return sum(kind.control_points for kind in self.kinds)

    @property
    def triangles(self) -> int:
        """Triangles of the coarsest tessellation."""
        return sum(kind.triangles for kind in self.kinds)

    @property
    def evaluation(self) -> float:
        """Cost of the coarsest tessellation: triangles times the cost of a point, summed."""
        return sum(kind.triangles * kind.relative_cost for kind in self.kinds)


def network_cost(network: SplineNetwork) -> SurfaceCost:
    """Cost of a network of S-patches."""
    kinds = tuple(PatchCost(part.sides, part.depth, len(part)) for part in network.parts)
    return SurfaceCost(kinds, distinct(part.control_points for part in network.parts))


def shared_cubic_points(network: SplineNetwork, triangles: int) -> int:
    """Control points of so many cubic triangles on a network, those on common sides counted once: V + 2 E + T.

    With the network's boundary edges as they are; each that a refinement splits adds one and a half.
    """
    mesh, patches = network.mesh, np.zeros(len(network.mesh.faces), dtype=np.bool_)
    patches[network.faces] = True
    inside = patches[mesh.face]
    vertices = len(np.unique(mesh.vertex[inside]))
    boundary = int((inside & ((mesh.twin < 0) | ~patches[mesh.face[mesh.twin]])).sum())
    edges = (int(inside.sum()) + boundary) // 2
    characteristic = vertices - edges + len(network)
    # V = characteristic + E - T, 2 E = 3 T + boundary
    return characteristic + 3 * (3 * triangles + boundary) // 2


def surface_cost(surface: Surface) -> SurfaceCost:
    """Cost of a surface of Bezier triangles; TypeError for patches of another kind."""
    counts: dict[int, int] = {}
    nets = []
    for batch in surface.batches:
        if not isinstance(batch, BezierTriangles):
            raise TypeError(f"the cost of a {batch.kind} is not defined here: take a surface of Bézier triangles")
        counts[batch.degree] = counts.get(batch.degree, 0) + len(batch)
        nets.append(batch.control_points)
    kinds = tuple(PatchCost(3, degree, count) for degree, count in sorted(counts.items()))
    return SurfaceCost(kinds, distinct(nets))


def distinct(nets: Iterable[Float]) -> int:
    """Number of different places among control points (P, n, 3), near ones counted once."""
    from scipy.sparse import coo_array  # heavy, and needed nowhere else here
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    points = np.concatenate([net.reshape(-1, 3) for net in nets])
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    pairs = cKDTree(points).query_pairs(SAME * size, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, _ = connected_components(graph, directed=False)
    return int(count)
