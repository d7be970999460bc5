"""Splitting by templates (Mann 1992, figure 5.1): a triangle with 1, 2, 3 split sides becomes 2, 3, 4 triangles.

Two split sides: the corner between them is cut off, and the remaining quadrilateral is halved by its shorter diagonal.
**Fill**: of diagonals that are equally long, the one at the triangle's smaller vertex id. Nothing keeps angles from
getting smaller and smaller where one side of the same triangles is split again and again.
"""

from typing import Final

import numpy as np

from testbed.approximation.division import TIE, Division, Pattern, Splitting, divide_by, rotated, side_mask
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, norm

_ONE: Final[Pattern] = ((0, 3, 2), (3, 1, 2))
#: Sides 0 and 2 are split: corner 0 is cut off; then the diagonal from corner 2, or the one from corner 1.
_TWO: Final[tuple[Pattern, Pattern]] = (((0, 3, 5), (3, 1, 2), (3, 2, 5)), ((0, 3, 5), (3, 1, 5), (1, 2, 5)))
#: By the mask of the split sides; 8 more where two are split and the diagonal starts at the corner before the cut.
PATTERNS: Final = {
    0: ((0, 1, 2),),
    **{1 << side: rotated(_ONE, side) for side in range(3)},
    **{
        ((1 << corner) | (1 << (corner + 2) % 3)) + 8 * other: rotated(_TWO[other], corner)
        for corner in range(3)
        for other in range(2)
    },
    7: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}


class Template(Splitting):
    """The thesis's templates: marked edges are split, and no others."""

    name = "template"

    def closed(self, mesh: HermiteMesh, marked: Bool) -> Bool:
        """Return the marked edges (E,) themselves."""
        del mesh
        return marked

    def divide(self, mesh: HermiteMesh, split: Bool, middles: Float) -> Division:
        """Divide a mesh at the middles (M, 3) of its split edges (E,)."""
        mask = side_mask(mesh, split)
        place = np.full((len(mesh.edges), 3), np.nan)
        place[split] = middles
        side_middles, corners = place[mesh.face_edges], mesh.corner_points()
        other = np.zeros(len(mask), dtype=np.bool_)
        for corner in range(3):  # the corner that is cut off
            after, before = (corner + 1) % 3, (corner + 2) % 3
            (own,) = np.nonzero(mask == (1 << corner) | (1 << before))
            from_before = norm(corners[own, before] - side_middles[own, corner])
            from_after = norm(corners[own, after] - side_middles[own, before])
            tie = np.abs(from_before - from_after) <= TIE * np.maximum(from_before, from_after)
            smaller = mesh.faces[own, after] < mesh.faces[own, before]
            other[own] = np.where(tie, smaller, from_after < from_before)
        return divide_by(mesh, split, mask + 8 * other, PATTERNS)
