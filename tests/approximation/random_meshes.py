"""Plane triangulations at random, and what their divisions must satisfy."""

import numpy as np
from scipy.spatial import Delaunay

from testbed.approximation.division import Division, Splitting
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int, cross


def plane_mesh(seed: int, count: int = 12, flat: float = 1.0) -> HermiteMesh:
    """A triangulation of random points of the unit square, squeezed to a height, in the plane z = 0."""
    rng = np.random.default_rng(seed)
    points = np.concatenate([np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), rng.random((count, 2))])
    points[:, 1] *= flat
    faces = Delaunay(points).simplices.astype(np.int64)
    upward = doubled_areas(points, faces) > 0.0
    faces = np.where(upward[:, None], faces, faces[:, ::-1])
    return HermiteMesh(np.column_stack([points, np.zeros(len(points))]), faces)


def doubled_areas(points: Float, faces: Int) -> Float:
    a, b, c = np.moveaxis(points[faces], 1, 0)
    area: Float = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return area


def divided(splitting: Splitting, mesh: HermiteMesh, marked: Bool) -> tuple[Division, HermiteMesh]:
    """Divide a plane mesh where marked."""
    split = splitting.closed(mesh, marked)
    ends = mesh.points[mesh.edges[split]]
    middles = 0.5 * (ends[:, 0] + ends[:, 1])
    division = splitting.divide(mesh, split, middles)
    return division, HermiteMesh(np.concatenate([mesh.points, middles]), division.faces)


def check_division(mesh: HermiteMesh, division: Division, finer: HermiteMesh, marked: Bool) -> None:
    """Check that a division covers its mesh once, conforms, keeps orientation, and splits what was to be split."""
    # conforming: where the old mesh had no boundary the new one, which is a manifold by construction, has none
    old_area = doubled_areas(mesh.points, mesh.faces)
    new_area = doubled_areas(finer.points, finer.faces)
    assert new_area.min() > 0.0
    assert np.abs(np.bincount(division.parent, weights=new_area) - old_area).max() < 1e-14
    assert euler(finer) == euler(mesh)
    assert set(np.flatnonzero(marked)) <= set(division.split.tolist())
    # an interior edge adds two triangles, one on the boundary adds one
    added = 2 * len(division.split) - int(mesh.boundary_edges[division.split].sum())
    assert len(finer.faces) == len(mesh.faces) + added
    # corners are where their barycentric coordinates say
    inside = np.einsum("nck,nkx->ncx", division.bary, mesh.corner_points()[division.parent])
    assert np.abs(inside - finer.corner_points()).max() < 1e-15
    assert (np.diff(division.parent) >= 0).all()
    in_parameters = cross(division.bary[:, 1] - division.bary[:, 0], division.bary[:, 2] - division.bary[:, 0])
    assert np.abs(np.bincount(division.parent, weights=in_parameters[:, 0]) - 1.0).max() < 1e-15


def euler(mesh: HermiteMesh) -> int:
    return len(mesh.points) - len(mesh.edges) + len(mesh.faces)
