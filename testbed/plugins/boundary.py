"""Boundary curves: the cubic curve on every mesh edge, an axis of its own, shared by all schemes on a network."""

from abc import abstractmethod
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from testbed.errors import Refused
from testbed.geometry.blocks import blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.vectors import Float
from testbed.plugins.base import Plugin
from testbed.plugins.corners import check_corners
from testbed.plugins.scheme import Data, check_needs


@dataclass(frozen=True)
class BoundaryCurve(Plugin):
    """A construction of cubic boundary curves; a frozen dataclass whose fields are its parameters.

    Attributes
    ----------
    needs
        Data it reads at the vertices.
    matches
        Data its curves match there: the tangent plane, and the normal curvature in the curve's direction (claim).
    """

    needs: ClassVar[Data]
    matches: ClassVar[Data]
    required: ClassVar[tuple[str, ...]] = (*Plugin.required, "needs", "matches")

    @abstractmethod
    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return control points (E, 4, 3) and notes on fallbacks; a row is NaN where the construction is undefined.

        Each edge's curve depends on that edge's data only; a network is built some thousand edges at a time.
        """

    @final
    def network(self, mesh: HermiteMesh) -> CurveNetwork:
        """Return the curves of all edges.

        Raises
        ------
        Refused
            The mesh lacks data, an edge has no curve, or two curves start along one line at a corner of a face; the
            message names the vertices.
        """
        check_needs(self, self.needs, mesh)
        control_points = np.empty((len(mesh.edges), 4, 3))
        notes: Counter[str] = Counter()
        for block in blocks(len(mesh.edges)):
            control_points[block], taken = self.curves(mesh.edge_data[block])
            notes.update(taken)
        undefined = ~np.isfinite(control_points).all(axis=(1, 2))
        if undefined.any():
            i, j = mesh.edges[undefined][0].tolist()
            raise Refused(
                f"{self} has no curve for {int(undefined.sum())} of {len(mesh.edges)} edges, the first from "
                f"vertex {i} to vertex {j}: check the normals there, one may be parallel to the edge"
            )
        network = CurveNetwork(mesh, control_points, dict(notes))
        check_corners(self, mesh, *network.end_legs)
        return network
