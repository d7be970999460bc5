"""The vertices of a file: one for each place with the mean of what the patches say there, or one for each patch."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float, Int, angle_between, norm, unit
from testbed_reports.export.tessellation import Tessellation


@dataclass(frozen=True, eq=False)
class Vertices:
    """Vertices with values, and the triangles between them.

    Parameters
    ----------
    points, normals
        (V, 3); normals are NaN where there are none.
    scalars
        Fields by name, (V,) each.
    triangles
        (T, 3) ids of vertices, in the order of the tessellation's.
    """

    points: Float
    normals: Float
    scalars: dict[str, Float]
    triangles: Int


def by_patch(tessellation: Tessellation) -> Vertices:
    """Return a vertex for each point of each patch, with the values of that patch: nothing is lost, nothing joined."""
    one = tessellation
    return Vertices(one.points, one.normals, one.scalars, one.triangles)


def by_place(tessellation: Tessellation) -> Vertices:
    """Return a vertex for each place: the triangles hang together as the surface does.

    Where several patches meet, its values are the means of theirs, and ``normal_deviation_deg``, ``gauss_deviation``
    and ``mean_deviation`` are the largest difference of a patch's from that mean: 0 where they agree. NaN at one patch
    is NaN at the vertex.
    """
    place = tessellation.place
    leader = np.unique(place, return_index=True)[1]
    patches = np.bincount(place)

    def mean(values: Float) -> Float:
        return np.bincount(place, values) / patches

    def largest(values: Float) -> Float:
        found = np.zeros(len(leader))
        with np.errstate(invalid="ignore"):  # NaN is propagated, and not told of
            np.maximum.at(found, place, values)
        return found

    # opposite normals have a mean of zero, and no direction
    with np.errstate(invalid="ignore", divide="ignore"):
        summed = np.stack([mean(tessellation.normals[:, axis]) for axis in range(3)], axis=-1)
        # one patch keeps its normal to the last bit
        normals = np.where((patches == 1)[:, None], tessellation.normals[leader], unit(summed))
        bent = np.degrees(angle_between(tessellation.normals, normals[place]))
    scalars: dict[str, Float] = {}
    for name, values in tessellation.scalars.items():
        if name == "distance":
            scalars[name] = values[leader]
            continue
        scalars[name] = mean(values)
        scalars[f"{name}_deviation"] = largest(np.abs(values - scalars[name][place]))
    scalars["normal_deviation_deg"] = largest(bent)
    return Vertices(tessellation.points[leader], normals, scalars, place[tessellation.triangles])


def shared_normals(tessellation: Tessellation, agreement: float) -> Float:
    """Normals (N, 3) for files that keep the patches' own: equal to the last bit at one place where they agree.

    Where a patch has no normal it gets that of the triangles around, and upwards where they have none either.

    Parameters
    ----------
    tessellation
        The triangles.
    agreement
        Up to which distance from that of a place's first point normals are equal.
    """
    found = tessellation.normals
    lacking = np.asarray(np.isnan(found).any(axis=1))
    if lacking.any():
        found = np.where(lacking[:, None], facet_normals(tessellation.points, tessellation.triangles), found)
        found = np.where(np.isnan(found).any(axis=1, keepdims=True), [0.0, 0.0, 1.0], found)
    leader = np.unique(tessellation.place, return_index=True)[1]
    of_place = found[leader][tessellation.place]
    return np.where((norm(found - of_place) <= agreement)[:, None], of_place, found)


def distinct(keys: Float) -> tuple[Int, Int]:
    """Rows that stand for all rows equal to them, in the order of the first ones, and which of them each row is."""
    first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)[1:]
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse.reshape(-1)]


def facet_normals(points: Float, triangles: Int) -> Float:
    """Unit normals (V, 3) of the triangles around each vertex, weighted by area; NaN where they have none."""
    first, second, third = (points[triangles[:, corner]] for corner in range(3))
    doubled = np.cross(second - first, third - first)
    total = np.zeros((len(points), 3))
    for corner in range(3):
        np.add.at(total, triangles[:, corner], doubled)
    with np.errstate(invalid="ignore", divide="ignore"):
        return unit(total)
