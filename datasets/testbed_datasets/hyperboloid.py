"""The hyperboloid of one sheet: negative curvature everywhere, with a boundary."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Shape
from testbed_datasets.halving import halved
from testbed_datasets.parameters import positive
from testbed_datasets.quadric import Quadric

#: Steps of level 0 around the axis.
COLUMNS = 6
#: Heights of level 0's rows, in the parameter t of z = c sinh t.
ROWS = np.array([-0.45, 0.05, 0.55])
#: How far a row is turned against the one below, in steps around the axis for each unit of t.
SHEAR = 0.3


@dataclass(frozen=True)
class Hyperboloid(Dataset):
    """Hyperboloid of one sheet x^2/a^2 + y^2/b^2 - z^2/c^2 = 1 with two boundary circles: 18 vertices, 24 faces.

    The surface is (a cosh t cos u, b cosh t sin u, c sinh t), -0.45 <= t <= 0.55, halved in u and t. Through every
    point run two straight lines of the surface, |du/dt| = 1/cosh t; rows are sheared so that no edge of any level comes
    near to them: along such a line the normal curvature is zero, and geometric Hermite curves are not to be had.

    Parameters
    ----------
    a, b, c
        Semi-axes; by default all differ, so that neither mesh nor surface has a symmetry that flatters a scheme.
    """

    a: float = 1.0
    b: float = 1.3
    c: float = 0.9

    name = "hyperboloid"
    title = "Hyperboloid of one sheet"
    reference = (
        "Not in the thesis: an algebraic surface, as those of its section 5.4.1 (page 80), with K < 0 everywhere"
    )
    closed = False
    shape = Shape.QUADRICS
    finest = 4

    def __post_init__(self) -> None:
        positive(self.name, a=self.a, b=self.b, c=self.c)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the parameters; Refused if there is none."""
        column, row = (index.ravel() for index in np.meshgrid(np.arange(COLUMNS), [0, 1], indexing="ij"))
        rows = len(ROWS)
        here, right = column * rows + row, (column + 1) % COLUMNS * rows + row
        corners = [[here, right, right + 1], [here, right + 1, here + 1]]
        faces = np.concatenate([np.stack(face, axis=-1) for face in corners])
        u = np.repeat(2.0 * np.pi / COLUMNS * np.arange(COLUMNS), rows)
        t = np.tile(ROWS, COLUMNS)
        u = u - SHEAR * t
        parameters, faces = halved(np.stack([u, t], axis=-1), faces, level, name=self.name, middle=around)
        u, t = parameters.T
        x, y = self.a * np.cosh(t) * np.cos(u), self.b * np.cosh(t) * np.sin(u)
        return self.surface.sample(np.stack([x, y, self.c * np.sinh(t)], axis=-1), faces)

    @property
    def surface(self) -> Quadric:
        """The hyperboloid, unbounded, normals away from the z axis."""
        return Quadric((self.a, self.b, self.c), (1, 1, -1))


def around(start: Float, end: Float) -> Float:
    """Middles of edges in (u, t), the short way round the axis, (E, 2)."""
    forward = end - start
    forward[:, 0] = np.mod(forward[:, 0] + np.pi, 2.0 * np.pi) - np.pi
    return start + 0.5 * forward
