"""Control meshes with four edges at every vertex inside."""

import numpy as np

from testbed.geometry.polygon_mesh import PolygonMesh


def antiprism(sides: int) -> PolygonMesh:
    """Two polygons and a band of triangles between them; with three sides the octahedron."""
    angle = 2.0 * np.pi * (np.arange(sides) + np.array([[0.0], [0.5]])) / sides
    height = np.broadcast_to([[-0.6], [0.6]], angle.shape)
    points = np.stack([np.cos(angle), np.sin(angle), height], axis=-1).reshape(-1, 3)
    below, after = np.arange(sides), (np.arange(sides) + 1) % sides
    above, above_after = sides + below, sides + after
    bands = np.concatenate([np.stack([below, after, above], axis=1), np.stack([after, above_after, above], axis=1)])
    return PolygonMesh(points, [below[::-1].tolist(), above.tolist(), *bands.tolist()])


def cuboctahedron() -> PolygonMesh:
    """Eight triangles and six squares, slightly out of shape."""
    lattice = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    points = lattice[np.abs(lattice).sum(axis=1) == 2.0]
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    faces = []
    for normal in np.concatenate([signs, 2.0 * np.eye(3), -2.0 * np.eye(3)]):
        (ids,) = np.nonzero(points @ normal == 2.0)
        away = points[ids] - points[ids].mean(axis=0)
        angle = np.arctan2(np.cross(normal, away[0]) @ away.T / np.linalg.norm(normal), away @ away[0])
        faces.append(ids[np.argsort(angle)].tolist())
    return PolygonMesh(points + 0.05 * np.sin(np.arange(36.0)).reshape(12, 3), faces)


def grid(columns: int = 5, rows: int = 5) -> PolygonMesh:
    """Quadrilaterals over a regular grid, bumpy; the outer ring is for control only."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij"))
    points = np.stack([1.0 * i, 1.0 * j, np.sin(1.3 * i + 0.4) * np.cos(0.9 * j)], axis=-1)
    first = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    return PolygonMesh(points, np.stack([first, first + rows + 1, first + rows + 2, first + 1], axis=-1).tolist())
