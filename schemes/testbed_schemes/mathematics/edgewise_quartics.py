"""Three quartics a face, each right along one side, and their blend (Si 2015, section 5.4).

The three have the face's boundary curves in common; quartic s has the second row asked for along side s, from corner s
to corner s + 1. With barycentric coordinates b and indices modulo three, the patch is

    P = sum w_s P_s,   w_s = b_s b_{s+1} / (b_0 b_1 + b_1 b_2 + b_2 b_0).

On side s, w_s = 1 and the quartics agree, so that the patch has the tangent planes of P_s: first powers are enough. The
weights are not negative and sum to one: what is on one side of a plane for all three is so for the patch.

As only the three inner control points differ, the patch is one quartic with inner points that depend on the parameters.
The inner point of P_s at corner s + 2, away from its side, is free: here the mean of those of the two others, so that
there are two a corner (:mod:`testbed_schemes.mathematics.blended_quartics`).

Formulas: the weights as printed. The mean is a fill.
"""

from typing import Any

import numpy as np

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.nets import inner_indices, side_indices
from testbed.geometry.patches import PatchBatch
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.blended_quartics import CORNER_MARGIN, blended_basis, corner_table

#: Places of the inner points at corners 0, 1, 2 in a quartic net: 211, 121, 112.
INNER = inner_indices(4)


class EdgewiseQuartics(TabulatedTriangles):
    """Blends of three quartics.

    Control points are the 12 of the boundary, side by side from corner 0, and then by corner i the inner point of the
    quartic of the side that ends there, i + 2, and that of the quartic of side i, (P, 18, 3).
    """

    kind = "blend of three quartic triangles"

    @classmethod
    def of_rows(cls, boundary: Float, first: Float, second: Float) -> "EdgewiseQuartics":
        """Build patches from what is along the sides, in the direction of the face.

        Parameters
        ----------
        boundary
            (P, 3, 5, 3) quartic control points of side s.
        first, second
            (P, 3, 3) inner points of the second row along side s, next to corner s and next to corner s + 1.
        """
        points = np.empty((len(boundary), 18, 3))
        points[:, :12] = boundary[:, :, :4].reshape(-1, 12, 3)
        points[:, 12::2], points[:, 13::2] = np.roll(second, 1, axis=1), first
        points.flags.writeable = False
        return cls(edgewise_basis, points, corner_table(), CORNER_MARGIN)

    @property
    def convex_components(self) -> tuple[PatchBatch, ...]:
        """The three quartics, that of side s at place s."""
        return tuple(BezierTriangles(net) for net in np.moveaxis(self.nets(), 1, 0))

    def nets(self) -> Float:
        """Control points of the quartics, (P, 3, 15, 3): quartic s has the second row of side s."""
        net = np.empty((len(self), 3, 15, 3))
        sides = side_indices(4)[:, :4]
        net[:, :, sides.ravel()] = self.control_points[:, None, :12]
        arriving, leaving = self.control_points[:, 12::2], self.control_points[:, 13::2]
        s = np.arange(3)
        net[:, s, INNER[s]] = leaving
        net[:, s, INNER[(s + 1) % 3]] = np.roll(arriving, -1, axis=1)
        net[:, s, INNER[(s + 2) % 3]] = np.roll(0.5 * (arriving + leaving), -2, axis=1)
        return net


def edgewise_basis(b0: Any, b1: Any, b2: Any) -> list[Any]:
    """Return the functions of the 18 control points.

    At corner i the quartic of the side that ends there, on which b_j = 0, has the weight b_i b_k, that of the side that
    starts there b_i b_j, and the third one, with the mean, b_j b_k.
    """
    return blended_basis(b0, b1, b2, lambda bi, bj, bk: (bk * (bi + 0.5 * bj), bj * (bi + 0.5 * bk)))
