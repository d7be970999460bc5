"""Splitting at longest edges (Rivara 1984): angles stay good, however often and wherever edges are split.

If any side of a triangle is to be split, so is its longest one; this goes on to the neighbours until nothing changes. A
triangle is then halved at its longest side, and each half at the middle of a side that it shares with the triangle, if
that is split too. Where the surface is plane no angle gets below half of the smallest angle at the start (Rosenberg and
Stenger 1975 for halving, Rivara 1984 for the four triangles); on a curved surface the lengths are measured in space,
anew for every mesh, and the bound holds up to what projection onto the surface does to the triangles.
"""

from typing import Final

import numpy as np

from testbed.approximation.division import Division, Pattern, Splitting, divide_by, longest_sides, rotated, side_mask
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float

#: Side 0 is the longest; by the mask of the split sides.
_LONGEST_FIRST: Final[dict[int, Pattern]] = {
    0b001: ((0, 3, 2), (3, 1, 2)),
    0b011: ((0, 3, 2), (3, 1, 4), (3, 4, 2)),
    0b101: ((0, 3, 5), (5, 3, 2), (3, 1, 2)),
    0b111: ((0, 3, 5), (5, 3, 2), (3, 1, 4), (3, 4, 2)),
}
#: By the mask of the split sides and 8 times the longest side; mask 0 has one entry.
PATTERNS: Final = {
    0: ((0, 1, 2),),
    **{
        (((mask << side) | (mask >> (3 - side))) & 7) + 8 * side: rotated(pattern, side)
        for mask, pattern in _LONGEST_FIRST.items()
        for side in range(3)
    },
}


class LongestEdge(Splitting):
    """Rivara's refinement: every split triangle is split at its longest side first."""

    name = "longest-edge"

    def closed(self, mesh: HermiteMesh, marked: Bool) -> Bool:
        """Return the marked edges (E,) and the longest edges of all triangles that have a split one."""
        longest = np.take_along_axis(mesh.face_edges, longest_sides(mesh)[:, None], axis=1)[:, 0]
        split = marked.copy()
        while True:
            wanted = longest[split[mesh.face_edges].any(axis=1)]
            if split[wanted].all():
                return split
            split[wanted] = True

    def divide(self, mesh: HermiteMesh, split: Bool, middles: Float) -> Division:
        """Divide a mesh at the middles of its split edges (E,), wherever these are."""
        del middles
        mask = side_mask(mesh, split)
        return divide_by(mesh, split, np.where(mask > 0, mask + 8 * longest_sides(mesh), 0), PATTERNS)
