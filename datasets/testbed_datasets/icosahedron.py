"""The icosahedron: the most even triangulation of the sphere."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float, Int, unit
from testbed_datasets.sphere import SphereMesh

#: 12 vertices as cyclic permutations of (0, +-1, +-golden ratio), counterclockwise from outside.
FACES = (
    *((0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11)),
    *((1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)),
    *((3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9)),
    *((4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)),
)


@dataclass(frozen=True)
class Icosahedron(SphereMesh):
    """Regular icosahedron: 12 vertices, 20 faces.

    Parameters
    ----------
    radius
        Radius of the sphere.
    """

    name = "icosahedron"
    title = "Icosahedron"
    reference = "Not in the thesis: the regular solid, the usual start for even triangulations of the sphere"
    finest = 4

    def coarsest(self) -> tuple[Float, Int]:
        """The regular icosahedron, edge over radius 1.05."""
        g = 0.5 * (1.0 + np.sqrt(5.0))
        corners = [
            *((-1.0, g, 0.0), (1.0, g, 0.0), (-1.0, -g, 0.0), (1.0, -g, 0.0)),
            *((0.0, -1.0, g), (0.0, 1.0, g), (0.0, -1.0, -g), (0.0, 1.0, -g)),
            *((g, 0.0, -1.0), (g, 0.0, 1.0), (-g, 0.0, -1.0), (-g, 0.0, 1.0)),
        ]
        return unit(np.array(corners)), np.array(FACES)
