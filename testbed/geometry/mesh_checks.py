"""What a mesh with Hermite data must satisfy; each check raises MeshError with one sentence that says where.

All checks are vectorised and scale-free: a mesh and its scaled, moved or relabelled copy are taken or refused alike.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.edges import HalfEdges
from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm

#: Lengths and curvatures stay within these bounds, so that eighth powers of lengths, which curvature formulas reach,
#: neither overflow nor vanish.
SHORTEST, LONGEST = 1e-37, 1e37
#: A triangle lower than this times its longest edge, or than this times its coordinates, has no plane left after
#: rounding.
FLATNESS = 64 * float(np.finfo(np.float64).eps)
#: Normals this near to length one are kept bit for bit.
UNIT = 8 * float(np.finfo(np.float64).eps)
#: How far the direction of a gradient may be from the normal: single precision.
GRADIENT = 1e-6
#: A sum of unit normals, weighted with angles, shorter than this has no direction left.
CANCELLED = 1e-12
#: Relative size of what a second form may have outside the symmetric matrices of the tangent plane: single precision.
#: What it has is taken away, unless it is rounding in double precision.
SECOND_FORM = 1e-6
EXACT = 64 * float(np.finfo(np.float64).eps)
#: Second forms smaller than this over the longest edge count as rounding of zero.
FLAT = 1e-4


def array_of(values: Any, what: str, width: str) -> Any:
    """Return a new array of the values, which must be numbers; ``width`` says the shape wanted."""
    try:
        array = np.array(values)
    except (TypeError, ValueError) as error:
        raise MeshError(f"the {what} are not an array: give numbers of shape {width}") from error
    if array.dtype.kind not in "iuf":
        raise MeshError(f"the {what} hold {array.dtype}: give numbers of shape {width}")
    return array


def checked_vectors(values: Any, what: str, shape: tuple[int | None, ...]) -> Float:
    """Return finite float64 values of the shape, whose first number, None for any, counts the vertices."""
    width = f"({', '.join('V' if size is None else str(size) for size in shape)})"
    array = array_of(values, what, width)
    if array.ndim != len(shape) or any(
        size not in (None, given) for size, given in zip(shape, array.shape, strict=True)
    ):
        raise MeshError(f"the {what} have shape {array.shape}: give {width}, a row for each vertex")
    with np.errstate(over="ignore"):  # of wider types; refused as infinite
        floats: Float = np.ascontiguousarray(array, dtype=np.float64)
    finite = np.isfinite(floats).all(axis=tuple(range(1, floats.ndim)))
    if not finite.all():
        vertex = first(~finite)
        row = " ".join(str(floats[vertex]).split())
        raise MeshError(f"the {what} hold {row} at vertex {vertex}: replace NaN and infinite values, or leave it out")
    return floats


def checked_points(values: Any) -> Float:
    """Return the points, (V, 3) finite float64 within bounds."""
    points = checked_vectors(values, "points", (None, 3))
    if not len(points):
        raise MeshError("the mesh is empty, it has no points: give at least one face and its vertices")
    large = (np.abs(points) > LONGEST).any(axis=1)
    if large.any():
        vertex = first(large)
        raise MeshError(
            f"vertex {vertex} has a coordinate beyond {LONGEST:g}, whose powers overflow: scale the points down"
        )
    return points


def checked_faces(values: Any, vertices: int) -> Int:
    """Return the faces, (F, 3) or (F, 4) int64, each of different existing vertices, all vertices used."""
    array = array_of(values, "faces", "(F, 3) or (F, 4)")
    if array.size == 0:
        raise MeshError("the mesh is empty, it has no faces: give at least one face")
    if array.dtype.kind == "f":
        raise MeshError(f"the faces hold {array.dtype}: give vertex ids as integers")
    if array.ndim != 2 or array.shape[1] not in (3, 4):
        raise MeshError(
            f"the faces have shape {array.shape}: give (F, 3) vertex ids for triangles or (F, 4) for quadrilaterals"
        )
    check_range(array, vertices)
    faces: Int = np.ascontiguousarray(array, dtype=np.int64)
    repeated = faces[:, 0] == faces[:, -1]
    for step in range(1, faces.shape[1] - 1):
        repeated |= (faces[:, step:] == faces[:, :-step]).any(axis=1)
    if repeated.any():
        face = first(repeated)
        ids, counts = np.unique(faces[face], return_counts=True)
        raise MeshError(f"{named(faces, face)} has vertex {ids[counts > 1][0]} more than once: remove or mend the face")
    unused = np.bincount(faces.ravel(), minlength=vertices) == 0
    if unused.any():
        raise MeshError(
            f"vertex {first(unused)} is in no face ({int(unused.sum())} of {vertices} vertices are not): "
            "remove vertices without a face"
        )
    return faces


def check_range(faces: Int, vertices: int) -> None:
    """Check that faces hold ids of vertices."""
    outside = (faces < 0) | (faces >= vertices)
    if outside.any():
        face = first(outside.any(axis=1))
        index = int(faces[face][outside[face]][0])
        raise MeshError(f"face {face} has vertex {index}, but the vertices are 0 to {vertices - 1}: correct the index")


def checked_half_edges(faces: Int) -> HalfEdges:
    """Return the edges of faces that make an oriented manifold, with or without boundary."""
    halves = HalfEdges.between(faces.ravel(), np.roll(faces, -1, axis=1).ravel())
    if len(halves.repeated):
        edge = int(halves.edge[halves.repeated].min())
        beside = (np.flatnonzero(halves.edge == edge) // faces.shape[1]).tolist()
        i, j = halves.ids[edge].tolist()
        where = f"faces {', '.join(map(str, beside[:-1]))} and {beside[-1]}"
        if len(beside) > 2:
            raise MeshError(
                f"the edge between vertices {i} and {j} is not manifold, it is a side of {len(beside)} {where}: "
                "leave two faces at most on an edge"
            )
        if len(np.unique(faces[beside])) == faces.shape[1]:
            raise MeshError(f"{where} have the same vertices {faces[beside[0]].tolist()}: remove one of them")
        raise MeshError(
            f"{where} run along their edge between vertices {i} and {j} in the same direction, their orientations "
            "differ: reverse the vertices of one of them"
        )
    check_rings(faces, halves)
    return halves


def check_rings(faces: Int, halves: HalfEdges) -> None:
    """Check that the faces at each vertex make one ring or one fan.

    The corner next to a corner, counterclockwise about their vertex, lies across the edge that ends there; corners
    of one ring or fan are found by following it in steps that double.
    """
    corners = np.arange(faces.size)
    along = halves.forward[halves.edge] == corners
    opposite = np.where(along, halves.backward[halves.edge], halves.forward[halves.edge])
    following = np.roll(opposite.reshape(faces.shape), 1, axis=1).ravel()
    last = following < 0
    following = np.where(last, corners, following)
    lowest = corners
    most = int(np.bincount(faces.ravel()).max())
    for _ in range(max(1, (most - 1).bit_length())):
        lowest = np.minimum(lowest, lowest[following])
        following = following[following]
    # a fan is known by its last corner, a ring by its lowest
    ring = np.where(last[following], following, lowest).reshape(faces.shape)
    one = np.empty(int(faces.max()) + 1, dtype=np.int64)
    one[faces] = ring
    torn = one[faces] != ring
    if torn.any():
        vertex = int(faces[torn].min())
        around = ring[faces == vertex]
        pieces = [int(np.argmax(((ring == label) & (faces == vertex)).any(axis=1))) for label in np.unique(around)]
        raise MeshError(
            f"vertex {vertex} is not manifold, its faces make {len(pieces)} separate fans or rings (at faces "
            f"{', '.join(map(str, sorted(pieces)))}): give each its own copy of the vertex"
        )


def check_shapes(points: Float, faces: Int) -> None:
    """Check that no face is degenerate, folded or too small to compute with."""
    corners = points[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    longest = norm(sides).max(axis=1)
    tiny = longest < SHORTEST
    if tiny.any():
        face = first(tiny)
        if longest[face] == 0.0:
            raise MeshError(f"{named(faces, face)} is degenerate, its vertices coincide: remove the face")
        raise MeshError(f"{named(faces, face)} has no side longer than {SHORTEST:g}: scale the points up")
    # in units of the face's size, so that nothing overflows or vanishes
    sides = sides / longest[:, None, None]
    # a triangle's corners all have the same double area
    corner = slice(0, 1) if faces.shape[1] == 3 else slice(None)
    at_corner = cross(sides[:, corner], -np.roll(sides, 1, axis=1)[:, corner])
    size = np.maximum(1.0, np.abs(corners).max(axis=(1, 2)) / longest)
    flat = norm(at_corner) <= (FLATNESS * size)[:, None]
    degenerate = flat.any(axis=1)
    if degenerate.any():
        face = first(degenerate)
        if faces.shape[1] == 3:
            raise MeshError(f"{named(faces, face)} is degenerate, its area is zero: remove the face or move a vertex")
        vertex = faces[face][flat[face]][0]
        raise MeshError(
            f"{named(faces, face)} is degenerate, its sides at vertex {vertex} lie on one line: move a vertex, or make "
            "triangles of it"
        )
    if faces.shape[1] == 4:
        check_convex(faces, at_corner)


def check_convex(faces: Int, at_corner: Float) -> None:
    """Check that quadrilaterals, seen along their mean normal, turn the same way at all corners (F, 4, 3)."""
    turns_back = dot(at_corner, at_corner.sum(axis=1, keepdims=True)) <= 0.0
    folded = turns_back.any(axis=1)
    if folded.any():
        face = first(folded)
        if turns_back[face].sum() > 1:
            raise MeshError(f"{named(faces, face)} crosses itself: put its vertices in the order they have around it")
        vertex = faces[face][turns_back[face]][0]
        raise MeshError(
            f"{named(faces, face)} is not convex at vertex {vertex}, where a patch would fold: make triangles of it"
        )


def checked_normals(values: Any, vertices: int) -> Float:
    """Return the normals, (V, 3), scaled to length one."""
    normals = checked_vectors(values, "normals", (None, 3))
    check_rows(len(normals), vertices, "normals")
    largest = np.abs(normals).max(axis=1)
    if (largest == 0.0).any():
        raise MeshError(f"the normal at vertex {first(largest == 0.0)} is zero: give a direction, or no normals at all")
    scaled = normals / largest[:, None]
    length = norm(scaled)
    with np.errstate(over="ignore"):  # lengths beyond all numbers are not 1
        is_unit: Bool = np.abs(length * largest - 1.0) <= UNIT
    return np.where(is_unit[:, None], normals, scaled / length[:, None])


def checked_gradients(values: Any, vertices: int) -> Float:
    """Return the gradients, (V, 3), none of them zero."""
    gradients = checked_vectors(values, "gradients", (None, 3))
    check_rows(len(gradients), vertices, "gradients")
    zero = (gradients == 0.0).all(axis=1)
    if zero.any():
        raise MeshError(f"the gradient at vertex {first(zero)} is zero: the surface is singular there, leave it out")
    return gradients


def check_along(gradients: Float, normals: Float | None) -> Float:
    """Return gradients (V, 3) that have the directions of the normals, (V, 3) of length one."""
    assert normals is not None  # noqa: S101 - without normals the gradients give them
    aside = norm(checked_normals(gradients, len(normals)) - normals) > GRADIENT
    if aside.any():
        raise MeshError(
            f"the gradient at vertex {first(aside)} does not have the direction of the normal there: "
            "give gradients along the normals, or gradients alone"
        )
    return gradients


def check_not_cancelled(normals: Float) -> None:
    """Check that sums of weighted unit normals (V, 3) are more than what rounding leaves of zero."""
    cancelled = norm(normals) < CANCELLED
    if cancelled.any():
        raise MeshError(
            f"no normal can be estimated at vertex {first(cancelled)}, the normals of its faces cancel: give normals"
        )


def checked_second_forms(values: Any, normals: Float | None, vertices: int, h: float) -> Float:
    """Return the second forms, (V, 3, 3), made exactly tangential and symmetric, of a mesh with longest edge ``h``."""
    if normals is None:
        raise MeshError("the mesh has second forms and no normals: give normals too")
    forms = checked_vectors(values, "second forms", (None, 3, 3))
    check_rows(len(forms), vertices, "second forms")
    return tangential_forms(forms, normals, h, lambda row: f"at vertex {row}")


def tangential_forms(forms: Float, normals: Float, h: float, where: Callable[[int], str]) -> Float:
    """Return second forms (N, 3, 3), made exactly tangential to normals (N, 3) and symmetric.

    Parameters
    ----------
    forms
        Finite second forms; changed in place.
    normals
        Unit normals.
    h
        Longest edge of the mesh.
    where
        Names the place of a row in a message.
    """
    size = np.abs(forms).max(axis=(1, 2))
    if (size > LONGEST).any():
        raise MeshError(f"the second form {where(first(size > LONGEST))} is beyond {LONGEST:g}: scale the mesh up")
    size = np.maximum(size, FLAT / h)
    skew = np.abs(forms - forms.transpose(0, 2, 1)).max(axis=(1, 2)) / size
    if (skew > SECOND_FORM).any():
        raise MeshError(f"the second form {where(first(skew > SECOND_FORM))} is not symmetric: give W with W = W^T")
    outside = norm(np.einsum("vij,vj->vi", forms, normals)) / size
    if (outside > SECOND_FORM).any():
        raise MeshError(
            f"the second form {where(first(outside > SECOND_FORM))} is not tangential: give W with W n = 0 for the "
            "normal n there"
        )
    (rough,) = np.nonzero(np.maximum(skew, outside) > EXACT)
    n = normals[rough]
    tangent_plane = np.eye(3) - n[:, :, None] * n[:, None, :]
    inner = tangent_plane @ forms[rough] @ tangent_plane
    forms[rough] = (inner + inner.transpose(0, 2, 1)) / 2.0
    return forms


def check_rows(given: int, vertices: int, what: str) -> None:
    """Check that there is a row for each vertex."""
    if given != vertices:
        raise MeshError(f"there are {given} {what} for {vertices} vertices: give one for each vertex")


def first(wrong: Any) -> int:
    """Index of the first row that is wrong."""
    return int(np.argmax(wrong))


def named(faces: Int, face: int) -> str:
    """Name a face in a message, by its number and its vertices."""
    return f"face {face} (vertices {', '.join(map(str, faces[face].tolist()))})"
