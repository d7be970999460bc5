"""Meshes about one irregular vertex, regular around it, lifted to a graph without symmetry."""

from collections.abc import Callable

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, angle_between
from testbed.plugins.scheme import Scheme


def lattice(columns: int, rows: int) -> tuple[Float, Int]:
    """Abscissae (V, 2) and faces of a parallelogram of equilateral triangles with sides of length one."""
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij"))
    places = np.stack([i + 0.5 * j, np.sqrt(0.75) * j], axis=-1)
    a, b = (axis.ravel() for axis in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    corner = a * (rows + 1) + b
    right, up = corner + rows + 1, corner + 1
    lower, upper = np.stack([corner, right, up], axis=-1), np.stack([right, right + 1, up], axis=-1)
    return places, np.concatenate([lower, upper])


def spokes(faces: int, *, closed: bool, rings: int = 3) -> HermiteMesh:
    """Vertex 0 with so many faces around it, on the boundary unless closed, and rings of regular faces."""
    ends = 0 if closed else 1
    ids, turns, radii = {(0, 0): 0}, [0.0], [0.0]
    for ring in range(1, rings + 1):
        for place in range(faces * ring + ends):
            ids[(ring, place)] = len(turns)
            turns.append((2.0 if closed else 1.0) * np.pi * place / (faces * ring))
            radii.append(ring)

    def vertex(ring: int, place: int) -> int:
        return ids[(ring, place % (faces * ring) if closed and ring else place)]

    triangles = []
    for ring in range(rings):
        for sector in range(faces):
            for step in range(ring + 1):
                outer, inner = sector * (ring + 1) + step, sector * ring + step
                triangles.append([vertex(ring, inner), vertex(ring + 1, outer), vertex(ring + 1, outer + 1)])
                if step:
                    triangles.append([vertex(ring, inner), vertex(ring, inner - 1), vertex(ring + 1, outer)])
    x, y = np.array(radii) * np.cos(turns), np.array(radii) * np.sin(turns)
    height = 0.11 * x * y + 0.07 * x**2 - 0.04 * y**2 + 0.02 * x**3 - 0.3 * np.cos(x + 0.3 * y)
    return HermiteMesh(np.stack([x, y, height], axis=-1), triangles)


def turns_at_the_hub(subdivided: Callable[[int], Scheme], valence: int) -> Float:
    """Largest angle in degrees between facets at a vertex of some valence, after 2 to 6 steps."""
    mesh, result = spokes(valence, closed=True), []
    for depth in range(2, 7):
        (part,) = subdivided(depth).fit(mesh).parts
        at_hub = (part.corner_ids == 0).any(axis=1)
        normals = part.batch.take(np.flatnonzero(at_hub)).jets(np.full((1, 2), 1.0 / 3.0), 1).normal[:, 0]
        result.append(np.degrees(angle_between(normals[:, None], normals[None])).max())
    return np.array(result)
