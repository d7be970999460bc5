"""A surface: batches of patches and the complex that joins them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Float, Int


@dataclass(frozen=True)
class Part:
    """A batch of patches and where each stands in the surface.

    Parameters
    ----------
    batch
        P patches.
    corner_ids
        (P, sides) ids of the corners, shared by neighbouring patches; a corner that is a mesh vertex has the vertex's id,
        inner points of split domains have ids from V on.
    faces
        (P,) the mesh face each patch came from.
    corners_in_face
        (P, sides, 2) the parameters, in the face's own domain, of the patch's corners.
    """

    batch: PatchBatch
    corner_ids: Int
    faces: Int
    corners_in_face: Float


@dataclass(frozen=True)
class Surface:
    """A piecewise surface through a mesh.

    Parameters
    ----------
    mesh
        The mesh it was built on.
    parts
        The batches with their places.
    notes
        Fallbacks taken while it was built, counted; ``{"curves without a root": 3}``.
    """

    mesh: HermiteMesh
    parts: tuple[Part, ...]
    notes: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def over_faces(cls, mesh: HermiteMesh, batch: PatchBatch, notes: Mapping[str, int] | None = None) -> "Surface":
        """One patch a face, corner for corner."""
        count = len(mesh.faces)
        corners = np.broadcast_to(CORNERS[mesh.sides], (count, mesh.sides, 2))
        return cls(mesh, (Part(batch, mesh.faces, np.arange(count), corners),), notes or {})

    @classmethod
    def over_split_faces(
        cls, mesh: HermiteMesh, batch: PatchBatch, notes: Mapping[str, int] | None = None
    ) -> "Surface":
        """Three patches a triangle, split at the centroid; patch 3 f + i has corners i + 1, i + 2 of face f and its centre."""
        count = len(mesh.faces)
        centre = len(mesh.points) + np.arange(count)
        ids = np.stack(
            [np.stack([mesh.faces[:, (i + 1) % 3], mesh.faces[:, (i + 2) % 3], centre], axis=-1) for i in range(3)],
            axis=1,
        )
        middle = np.full(2, 1.0 / 3.0)
        corners = np.stack([np.stack([CORNERS[3][(i + 1) % 3], CORNERS[3][(i + 2) % 3], middle]) for i in range(3)])
        part = Part(
            batch,
            ids.reshape(-1, 3),
            np.repeat(np.arange(count), 3),
            np.broadcast_to(corners, (count, 3, 3, 2)).reshape(-1, 3, 2),
        )
        return cls(mesh, (part,), notes or {})

    @property
    def batches(self) -> tuple[PatchBatch, ...]:
        """The patch batches; Bezier ones have ``degree`` and ``control_points``."""
        return tuple(part.batch for part in self.parts)

    @property
    def patch_count(self) -> int:
        """Patches in all batches together."""
        return sum(len(part.batch) for part in self.parts)
