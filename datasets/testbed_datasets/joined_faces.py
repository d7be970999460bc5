"""Two triangles that join in an edge: the examples with which Xu, Huang and Bajaj (2001) show their A-patches."""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.dataset import Dataset

#: How the two faces are curved; see :class:`JoinedFaces`.
Case: TypeAlias = Literal["convex", "mixed", "nonconvex", "flat"]

#: Vertices 3 and 4, and the gradients at the four vertices; vertices 1 and 2 are (-2, 0, 0) and (2, 0, 0).
_CASES: Final = {
    "convex": (((0, 4, -1), (0, -4, -1)), ((-1, 0, 1), (1, 0, 1), (0, 1, 1), (0, -1, 1))),
    "mixed": (((0, 4, -1), (0, -4, -1)), ((-1, 0, 1), (1, 0, 1), (0, 1, 1.5), (0, 1, 1.5))),
    "nonconvex": (((0, 4, -1), (0, -4, -1)), ((1, 0, 1), (1, 0, 1), (0, -1, 1.5), (0, 1, 1.5))),
    "flat": (((0, 4, -1), (0, -4, 0)), ((0, 0, 1), (0, 0, 1), (0, -1, 1.5), (0, 0, 1))),
}


@dataclass(frozen=True)
class JoinedFaces(Dataset):
    """Two triangles with a common edge and gradients at their four vertices, no exact surface.

    The vertices are those of the paper's section 6 and the lengths of the gradients its data, too.

    Parameters
    ----------
    case
        ``convex``: both faces (figure 6 there); ``mixed``: a convex and a nonconvex one (figure 7); ``nonconvex``: both
        faces and their edge (figure 9); ``flat``: a nonconvex and a plane one (figure 10).
    """

    case: Case = "convex"

    name = "joined-faces"
    title = "Two faces that join"
    reference = "Xu, Huang and Bajaj 2001, section 6"
    closed = False
    finest = 0

    def mesh(self, level: int) -> HermiteMesh:
        """Return the two faces; Refused above level 0, as there is no surface to find new vertices on."""
        if level:
            raise Refused(f"{self} has no level {level}: two faces without a surface between them have level 0 only")
        apexes, gradients = _CASES[self.case]
        points = np.array([(-2, 0, 0), (2, 0, 0), *apexes], dtype=np.float64)
        faces = np.array([[0, 1, 2], [1, 0, 3]])
        return HermiteMesh(points, faces, gradients=np.array(gradients, dtype=np.float64))

    @property
    def surface(self) -> None:
        """None: there is no exact surface."""
        return None
