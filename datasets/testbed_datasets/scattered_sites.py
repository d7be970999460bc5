"""Random sites in the unit square, spread about evenly, and their Delaunay triangles without slivers along the hull."""

import numpy as np

from testbed.errors import Refused
from testbed.geometry.vectors import Bool, Float, Int, angle_between
from testbed_datasets.height_charts import boundary_sides

#: Random points for each site, and how often sites move to the middles of those nearest to them (Lloyd's method).
POINTS, ROUNDS = 64, 8
#: A triangle at the hull goes if its angle opposite the hull is wider than this.
WIDEST_DEG = 110.0


def even_sites(count: int, seed: int) -> Float:
    """Return sites (N, 2) in the unit square: random ones, a few rounds of Lloyd's method on.

    Uniformly random sites have pairs as near as one likes. A site moves to the mean of those of ``POINTS`` N random
    points that are nearest to it, so that no two remain much nearer than the others.
    """
    from scipy.spatial import cKDTree

    random = np.random.default_rng(seed)
    sites: Float = random.uniform(size=(count, 2))
    points = random.uniform(size=(POINTS * count, 2))
    for _ in range(ROUNDS):
        nearest = cKDTree(sites).query(points)[1]
        number = np.bincount(nearest, minlength=count)
        sums = np.stack([np.bincount(nearest, weights=points[:, axis], minlength=count) for axis in (0, 1)], axis=-1)
        sites = np.where(number[:, None] > 0, sums / np.maximum(number, 1)[:, None], sites)
    return sites


def triangulated(sites: Float) -> Int:
    """Delaunay triangles (F, 3) of sites (N, 2), counterclockwise, in lexicographic order, without hull slivers.

    Along the convex hull of even sites there are needles. Those with an angle wider than ``WIDEST_DEG`` opposite the
    boundary go, as long as the vertex there is inside; then the boundary runs through it.

    Raises
    ------
    Refused
        A site is in no triangle, because it coincides with another.
    """
    from scipy.spatial import Delaunay

    faces = Delaunay(sites).simplices.astype(np.int64)
    # the order must not depend on the triangulation's: the least vertex first, faces sorted
    first = faces.argmin(axis=1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    faces = faces[np.lexsort(faces.T[::-1])]
    while (slivers := _slivers(sites, faces)).any():
        faces = faces[~slivers]
    missing = np.setdiff1d(np.arange(len(sites)), faces)
    if len(missing):
        raise Refused(f"site {missing[0]} is in no triangle, for it coincides with another: take another seed")
    return faces


def _slivers(sites: Float, faces: Int) -> Bool:
    """(F,) true for triangles to take away, no two of them with the same vertex opposite the boundary."""
    corners = np.column_stack([sites, np.zeros(len(sites))])[faces]
    angle = angle_between(np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners)
    on_boundary = boundary_sides(faces)
    inside = np.ones(len(sites), dtype=np.bool_)
    inside[faces[on_boundary]] = inside[np.roll(faces, -1, axis=1)[on_boundary]] = False
    # corner s is opposite side s + 1
    wide = (np.degrees(angle) > WIDEST_DEG) & np.roll(on_boundary, -1, axis=1) & inside[faces]
    face, corner = np.nonzero(wide)
    order = np.lexsort((face, -angle[face, corner]))
    _, widest = np.unique(faces[face, corner][order], return_index=True)
    result = np.zeros(len(faces), dtype=np.bool_)
    result[face[order[widest]]] = True
    return result
