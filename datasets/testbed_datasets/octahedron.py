"""The octahedron of the thesis: six vertices on the axes, seen as a sampling of the sphere."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float, Int
from testbed_datasets.sphere import SphereMesh


def axis_octahedron() -> tuple[Float, Int]:
    """Vertices +x, +y, +z, -x, -y, -z, (6, 3), and the eight faces, (8, 3), counterclockwise from outside."""
    points = np.concatenate([np.eye(3), -np.eye(3)])
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    return points, np.array(faces)


@dataclass(frozen=True)
class Octahedron(SphereMesh):
    """Octahedron on the axes: 6 vertices, 8 faces; level 1 (18 vertices, 32 faces) is the thesis's refined octahedron.

    The thesis says the refined mesh has twenty vertices; halving gives eighteen.

    Parameters
    ----------
    radius
        Radius of the sphere.
    """

    name = "octahedron"
    title = "Octahedron"
    reference = "Mann 1992, figures 2.11a (page 30), 2.20 (page 46) and 3.6 (page 62)"
    finest = 4

    def coarsest(self) -> tuple[Float, Int]:
        """The axis octahedron."""
        return axis_octahedron()
