"""How far a surface is from the samples that its mesh carries at the centres of faces."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, angle_between, norm

#: A face misses its sample if the distance over the mesh's size, the angle, or the difference of the second forms times
#: the size is above this.
MISSED = 1e-8
#: Parameters of a face's centre, by the number of its sides; barycentric coordinates in triangles.
CENTRES = {3: np.full(3, 1.0 / 3.0), 4: np.full(2, 0.5)}


@dataclass(frozen=True)
class CentreErrors:
    """Differences of a surface from the samples at the centres of F faces, at the middles of the faces' parameters.

    Attributes
    ----------
    distance
        (F,) from the sample to the surface's point.
    angle
        (F,) between the normals, radians.
    form
        (F,) largest entry of the difference of the second fundamental forms.
    """

    distance: Float
    angle: Float
    form: Float

    def relative(self, size: float) -> Float:
        """The three differences (3, F) on a mesh of that size: without a unit."""
        return np.stack([self.distance / size, self.angle, self.form * size])

    def missed(self, size: float) -> Bool:
        """(F,) true where a sample is missed on a mesh of that size; NaN misses."""
        return np.asarray(~(self.relative(size) <= MISSED).all(axis=0))


def centre_errors(surface: Surface) -> CentreErrors | None:
    """Return the differences, or None if the mesh has no samples at face centres; ValueError if a face has no patch."""
    mesh = surface.mesh
    centres = mesh.face_data.centres
    if centres is None:
        return None
    faces = np.arange(len(mesh.faces))
    jet = surface.evaluate(faces, np.broadcast_to(CENTRES[mesh.sides], (len(faces), len(CENTRES[mesh.sides]))), 2)
    return CentreErrors(
        norm(jet.f - centres.points),
        angle_between(jet.normal, centres.normals),
        np.abs(second_form_matrix(jet) - centres.second_forms).max(axis=(1, 2)),
    )
