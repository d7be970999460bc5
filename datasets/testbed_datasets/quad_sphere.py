"""A sixth of the sphere in quadrilaterals, with samples at the centres of the faces."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, unit
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Shape
from testbed_datasets.graph import crooked_quads
from testbed_datasets.halving import straight
from testbed_datasets.parameters import positive, within
from testbed_datasets.quad_halving import halved_quads, quad_centres
from testbed_datasets.sphere import RoundSphere


@dataclass(frozen=True)
class QuadSphere(Dataset):
    """Sphere under the top of its cube, seen from the centre: 20 vertices, 12 quadrilaterals, open.

    The points (tan a, tan b, 1), scaled to the sphere, of angles |a|, |b| <= 45 degrees, halved bilinearly in these; no
    face has a pole, and on the crooked grid none has a symmetry.

    Parameters
    ----------
    radius
        Radius of the sphere.
    crooked
        How far the grid's vertices are moved; 0 leaves equal steps of the angles.
    """

    radius: float = 1.0
    crooked: float = 1.0

    name = "quad-sphere"
    title = "Sphere patch of quadrilaterals"
    reference = "Not in the thesis: the sphere of its figures, without poles"
    closed = False
    shape = Shape.SPHERES
    finest = (
        4  # on the next one rounding decides on roots of the bicubic centre, of which four are one on a sphere, nearly
    )

    def __post_init__(self) -> None:
        positive(self.name, radius=self.radius)
        within(self.name, crooked=(self.crooked, 0.0, 1.5))

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the two angles; Refused if there is none."""
        plane, faces = halved_quads(*crooked_quads(self.crooked), level, name=self.name, middle=straight)
        return self.surface.sample(self._at(plane), faces, self._at(quad_centres(plane, faces, straight)))

    def _at(self, plane: Float) -> Float:
        """Points (N, 3) of angles (N, 2) in units of 45 degrees."""
        slopes = np.tan(0.25 * np.pi * plane)
        return self.radius * unit(np.column_stack([slopes, np.ones(len(plane))]))

    @property
    def surface(self) -> RoundSphere:
        """The whole sphere."""
        return RoundSphere(self.radius)
