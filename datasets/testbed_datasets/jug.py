"""A jug with a handle and a spout: a closed mesh of some thousand faces such as a user brings, made here.

Its surface is Loop's (1987) over a control mesh of our own: a wall turned about the z axis, outside and inside, with a
spout drawn out of the rim and a handle of square section. It bends like an egg on the belly, like a saddle at the neck
and under the handle, and is flat in the middle of the bottom; triangles are uneven, vertices have valences from 5 to 9.
Vertices of every level are limits of subdivision, so that levels are nested, and normals those of the limit surface.
There are no second fundamental forms, which this surface does not have at vertices of other valences than 6, and no
exact surface to measure against.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.loop_normals import loop_limit_normals
from testbed.geometry.loop_subdivision import limit_points, subdivided
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, Int
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import check_level

#: Vertices of a ring about the axis; odd, so that the handle stands on a face opposite the spout.
SECTORS = 9
#: Radius and height of the rings, from the bottom along the outside over the rim and down the inside.
PROFILE = (
    *((0.42, 0.00), (0.74, 0.00), (1.08, 0.44), (1.10, 1.04), (0.76, 1.66), (0.68, 2.04), (0.88, 2.40), (0.74, 2.60)),
    *((0.54, 2.40), (0.36, 2.00), (0.42, 1.62), (0.74, 1.04), (0.72, 0.56), (0.40, 0.24)),
)
#: Height of the inside of the bottom on the axis.
FLOOR = 0.24
#: By how much rings are drawn out at the spout, outwards and upwards.
SPOUT = {5: (0.06, 0.0), 6: (0.34, 0.06), 7: (0.34, 0.08), 8: (0.24, 0.04)}
#: The lower one of the two rings at each foot of the handle.
FEET = (2, 4)
#: Sections of the handle from below upwards: middle (x, z), direction outwards (x, z), half width that way and across.
HANDLE = (
    ((-1.58, 0.70), (-0.6, -0.8), 0.20, 0.26),
    ((-1.98, 1.38), (-1.0, 0.1), 0.18, 0.24),
    ((-1.46, 2.00), (-0.4, 0.9), 0.18, 0.24),
)


@dataclass(frozen=True)
class Jug(Dataset):
    """Jug with handle and spout: 140 vertices, 280 faces; level 2 has 2240 and 4480. Closed, of genus 1."""

    name = "jug"
    title = "Jug"
    reference = "A control mesh of our own; subdivision as in Loop 1987"
    closed = True
    finest = 0

    def mesh(self, level: int) -> HermiteMesh:
        """Return limit points and normals of the control mesh after ``level`` steps of subdivision.

        Raises
        ------
        Refused
            There is no such level.
        """
        points, faces = control_mesh()
        check_level(level, len(faces), self.name)
        triangles = Triangulation(faces, len(points))
        for _ in range(level):
            points, triangles = subdivided(triangles, points), triangles.refined()
        normals = loop_limit_normals(points, triangles.faces)
        return HermiteMesh(limit_points(triangles, points), triangles.faces, normals)

    @property
    def surface(self) -> None:
        """None: the limit surface is not offered as an exact one."""
        return


def control_mesh() -> tuple[Float, Int]:
    """Vertices (V, 3) and faces (F, 3) of the control mesh."""
    turn = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    radius, height = np.array(PROFILE).T[:, :, None]
    rings = np.stack(np.broadcast_arrays(radius * np.cos(turn), radius * np.sin(turn), height), axis=-1)
    towards = np.maximum(np.cos(turn), 0.0)[:, None] ** 4
    for ring, (outwards, upwards) in SPOUT.items():
        rings[ring] += towards * np.array([outwards, 0.0, upwards])
    middle, direction, half, across = (np.array(column) for column in zip(*HANDLE, strict=True))
    corners = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])  # outwards, and along y
    along = (half[:, None] * direction)[:, None] * corners[:, :1]
    x, z = np.moveaxis(middle[:, None] + along, -1, 0)
    handle = np.stack([x, across[:, None] * corners[:, 1], z], axis=-1)
    points = np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, 0.0], [0.0, 0.0, FLOOR]], handle.reshape(-1, 3)])
    return points, _control_faces()


def _control_faces() -> Int:
    ids = np.arange(len(PROFILE) * SECTORS).reshape(-1, SECTORS)
    after = np.roll(ids, -1, axis=1)
    bottom, floor = ids.size, ids.size + 1
    ends = [
        np.stack([np.full(SECTORS, bottom), after[0], ids[0]], axis=-1),
        np.stack([np.full(SECTORS, floor), ids[-1], after[-1]], axis=-1),
    ]
    wall = np.stack([ids[:-1], after[:-1], after[1:], ids[1:]], axis=-1)  # (rings - 1, sectors, 4)
    back = (SECTORS - 1) // 2
    low, high = wall[FEET, back]
    standing = np.ones(wall.shape[:2], dtype=np.bool_)
    standing[FEET, back] = False
    # the handle's sections, seen from its lower foot; at the upper one what was below is above
    sections = floor + 1 + np.arange(4 * len(HANDLE)).reshape(-1, 4)
    sections = np.concatenate([low[None], sections, high[None, ::-1]])
    near, far = sections[:-1], sections[1:]
    tube = np.stack([near, np.roll(near, -1, axis=1), np.roll(far, -1, axis=1), far], axis=-1)
    quadrilaterals = np.concatenate([wall[standing], tube.reshape(-1, 4)])
    return np.concatenate([*ends, quadrilaterals[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)])
