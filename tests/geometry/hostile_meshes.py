"""Meshes to test with: valid ones of many topologies, and hostile ones that must be refused or survived.

``mesh_data()`` and ``hostile_mesh_data()`` are hypothesis strategies of constructor arguments of HermiteMesh.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from hypothesis import strategies as st

from testbed.geometry.vectors import Float, Int

#: Constructor arguments: points, faces, normals, second_forms.
Data: TypeAlias = dict[str, Any]
Random: TypeAlias = np.random.Generator


def bipyramid(sides: int) -> tuple[Float, Int]:
    """Two apexes over a ring: apexes of valence ``sides``, 4 along the ring."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    points = np.concatenate([ring, [[0, 0, 1.0], [0, 0, -1.0]]])
    a, b = np.arange(sides), (np.arange(sides) + 1) % sides
    top, bottom = np.full(sides, sides), np.full(sides, sides + 1)
    return points, np.concatenate([np.stack([a, b, top], axis=-1), np.stack([b, a, bottom], axis=-1)])


def fan(sides: int) -> tuple[Float, Int]:
    """An open cap: one inner vertex of valence ``sides``."""
    points, faces = bipyramid(sides)
    return points[:-1], faces[:sides]


def quad_grid(rows: int, columns: int, *, closed: bool) -> tuple[Float, Int]:
    """A bent sheet of quadrilaterals, or a torus, which needs three rows and columns."""
    i, j = np.meshgrid(np.arange(rows + (not closed)), np.arange(columns + (not closed)), indexing="ij")
    n, m = i.shape
    if closed:
        s, t = 2 * np.pi * i / n, 2 * np.pi * j / m
        radius = 2 + 0.7 * np.cos(t)
        points = np.stack([radius * np.cos(s), radius * np.sin(s), 0.7 * np.sin(t)], axis=-1)
    else:
        points = np.stack([i / rows, j / columns, 0.3 * np.sin(i / rows + 2 * j / columns)], axis=-1)
    f, g = (index.ravel() for index in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    corners = [((f + a) % n) * m + (g + b) % m for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return points.reshape(-1, 3), np.stack(corners, axis=-1)


def cut(faces: Int) -> Int:
    """Two triangles of each quadrilateral."""
    return faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def with_split_faces(points: Float, faces: Int, chosen: list[int]) -> tuple[Float, Int]:
    """Put a vertex of valence 3 into faces, one after the other; the valences of their corners grow."""
    for number in chosen:
        a, b, c = faces[number % len(faces)].tolist()
        centre = points[[a, b, c]].mean(axis=0) * 1.1
        v = len(points)
        points = np.concatenate([points, centre[None]])
        faces = np.concatenate([np.delete(faces, number % len(faces), axis=0), [[a, b, v], [b, c, v], [c, a, v]]])
    return points, faces


def vertex_normals(points: Float, faces: Int) -> Float:
    """Plain sums of the face normals, scaled to length one; where they vanish, some direction."""
    normals = np.zeros_like(points)
    for face in faces.tolist():
        corners = points[face]
        normal = np.cross(corners[1] - corners[0], corners[-1] - corners[0])
        normals[face] += normal / np.linalg.norm(normal)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 1e-6, normals, [0.0, 0.0, 1.0])
    unit: Float = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return unit


def tangential_forms(forms: Float, normals: Float) -> Float:
    """Symmetric matrices of the tangent planes nearest to the given ones."""
    projector = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    tangential = projector @ ((forms + forms.transpose(0, 2, 1)) / 2) @ projector
    symmetric: Float = (tangential + tangential.transpose(0, 2, 1)) / 2
    return symmetric


@st.composite
def mesh_data(draw: st.DrawFn, quads: bool | None = None, data: bool = True) -> Data:
    """Valid constructor arguments: closed and open, valences from 3; quadrilaterals, triangles or, for None, either."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    if draw(st.booleans()) if quads is None else quads:
        closed = draw(st.booleans())
        least = 3 if closed else 1
        points, faces = quad_grid(draw(st.integers(least, 5)), draw(st.integers(least, 5)), closed=closed)
    else:
        kind = draw(st.sampled_from(["bipyramid", "fan", "torus", "sheet", "triangle"]))
        if kind in ("bipyramid", "fan"):
            points, faces = (bipyramid if kind == "bipyramid" else fan)(draw(st.integers(3, 12)))
        elif kind == "triangle":
            points, faces = np.eye(3), np.array([[0, 1, 2]])
        else:
            sizes = (draw(st.integers(3, 5)), draw(st.integers(3, 5)))
            points, quadrilaterals = quad_grid(*sizes, closed=kind == "torus")
            faces = cut(quadrilaterals)
        points, faces = with_split_faces(points, faces, draw(st.lists(st.integers(0, 30), max_size=3)))
    points = points + 0.02 * random.normal(size=points.shape)
    order = random.permutation(len(points))
    points, faces = points[order], np.argsort(order)[faces][random.permutation(len(faces))]
    result: Data = {"points": points, "faces": faces, "normals": None, "second_forms": None}
    if data or draw(st.booleans()):
        result["normals"] = vertex_normals(points, faces)
        result["second_forms"] = tangential_forms(random.normal(size=(len(points), 3, 3)), result["normals"])
    return result


# Hostile but valid, or nearly: what a scheme has to take or refuse. Each changes the data in place.


def on_a_grid(data: Data, random: Random) -> None:
    """Points and normals of few digits: right angles, parallels and symmetries without rounding."""
    steps = random.choice([1.0, 2.0, 3.0])
    data["points"] = np.round(data["points"] * steps) / steps
    normals, forms = data["normals"] * random.choice([0.7, 1.0, 2.0]), data["second_forms"]
    normals = normals.round()
    normals[~normals.any(axis=1)] = [0.0, 0.0, 1.0]
    data["normals"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    data["second_forms"] = tangential_forms(forms.round(), data["normals"])


def scaled(data: Data, random: Random) -> None:
    """Tiny or huge coordinates."""
    scale = 10.0 ** random.uniform(-12, 12)
    data["points"] = data["points"] * scale
    data["second_forms"] = data["second_forms"] / scale


def far_away(data: Data, random: Random) -> None:
    """Far from the origin."""
    data["points"] = data["points"] + 10.0 ** random.uniform(0, 9) * random.normal(size=3)


def needle(data: Data, random: Random) -> None:
    """A vertex pulled close to its neighbour."""
    a, b = random.choice(data["faces"][random.integers(len(data["faces"]))], 2, replace=False)
    near = 10.0 ** random.uniform(-14, -1)
    data["points"][a] = (1 - near) * data["points"][b] + near * data["points"][a]


def flattened(data: Data, random: Random) -> None:
    """All points in a plane, faces of bent meshes over each other."""
    data["points"][:, random.integers(3)] *= random.choice([0.0, 1e-14, 1e-8])


def folded_normals(data: Data, random: Random) -> None:
    """Normals to the wrong side."""
    flipped = random.random(len(data["points"])) < random.uniform()
    data["normals"] = np.where(flipped[:, None], -data["normals"], data["normals"])


def nearly_parallel_normals(data: Data, random: Random) -> None:
    """One direction but for rounding or a little more."""
    spread = random.choice([0.0, 1e-16, 1e-12, 1e-6])
    normals = random.normal(size=3) + spread * random.normal(size=data["points"].shape)
    data["normals"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    data["second_forms"] = tangential_forms(data["second_forms"], data["normals"])


def random_normals(data: Data, random: Random) -> None:
    """Normals without relation to the faces."""
    normals = random.normal(size=data["points"].shape)
    data["normals"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    data["second_forms"] = tangential_forms(data["second_forms"], data["normals"])


def normals_along_edges(data: Data, random: Random) -> None:
    """Normals parallel to an edge of their vertex, at one vertex or at all."""
    chosen = random.permutation(len(data["faces"]))[: random.choice([1, len(data["faces"])])]
    for face in data["faces"][chosen]:
        edge = data["points"][face[1]] - data["points"][face[0]]
        if np.linalg.norm(edge) > 0:
            data["normals"][face[0]] = edge / np.linalg.norm(edge)
    data["second_forms"] = tangential_forms(data["second_forms"], data["normals"])


def normals_in_faces(data: Data, random: Random) -> None:
    """Normals in the plane of a face, at one vertex or at one of each face: its two edges there have one projection."""
    chosen = random.permutation(len(data["faces"]))[: random.choice([1, len(data["faces"])])]
    for face in data["faces"][chosen]:
        corners = data["points"][face]
        direction = random.normal(size=2) @ (corners[1:3] - corners[0])
        if np.linalg.norm(direction) > 0:
            data["normals"][face[0]] = direction / np.linalg.norm(direction)
    data["second_forms"] = tangential_forms(data["second_forms"], data["normals"])


def sized_second_forms(data: Data, random: Random) -> None:
    """Second forms of zero, tiny or huge size."""
    data["second_forms"] = data["second_forms"] * random.choice([0.0, 1e-300, 1e-20, 1e3, 1e8, 1e30])


def unnormalised(data: Data, random: Random) -> None:
    """Normals of any length."""
    data["normals"] = data["normals"] * 10.0 ** random.uniform(-300, 300, size=(len(data["points"]), 1))


def bare(data: Data, random: Random) -> None:
    """No second forms, perhaps no normals."""
    data["second_forms"] = None
    if random.random() < 0.5:
        data["normals"] = None


# Broken: to be refused.


def not_finite(data: Data, random: Random) -> None:
    """A NaN or infinite number somewhere."""
    name = random.choice([name for name in ("points", "normals", "second_forms") if data[name] is not None])
    data[name].flat[random.integers(data[name].size)] = random.choice([np.nan, np.inf, -np.inf])


def wrong_index(data: Data, random: Random) -> None:
    """An index that is no vertex."""
    wrong = [-1, len(data["points"]), np.iinfo(np.int64).max, np.iinfo(np.int64).min]
    data["faces"].flat[random.integers(data["faces"].size)] = wrong[random.integers(4)]


def wrong_vertex(data: Data, random: Random) -> None:
    """Another vertex in a face: repeated, not manifold or not oriented, now and then valid."""
    data["faces"].flat[random.integers(data["faces"].size)] = random.integers(len(data["points"]))


def wrong_orientation(data: Data, random: Random) -> None:
    """A face turned over; valid where it is alone."""
    face = random.integers(len(data["faces"]))
    data["faces"][face] = data["faces"][face][::-1].copy()


def face_twice(data: Data, random: Random) -> None:
    """A face given twice."""
    data["faces"] = np.concatenate([data["faces"], data["faces"][[random.integers(len(data["faces"]))]]])


def faces_missing(data: Data, random: Random) -> None:
    """Some faces left out: stray vertices, vertices with two fans, now and then valid, now and then no face at all."""
    data["faces"] = data["faces"][random.random(len(data["faces"])) < random.uniform()]


def coincident_points(data: Data, random: Random) -> None:
    """Two vertices of a face at one place."""
    face = random.choice(data["faces"][random.integers(len(data["faces"]))], 2, replace=False)
    data["points"][face[0]] = data["points"][face[1]]


def not_tangential(data: Data, random: Random) -> None:
    """A second form with a normal part, or not symmetric."""
    vertex = random.integers(len(data["points"]))
    data["second_forms"][vertex] += random.normal(size=(3, 3))


def wrong_shape(data: Data, random: Random) -> None:
    """A row or a column too few, or an axis too many."""
    name = random.choice([name for name in data if data[name] is not None])
    shapes: list[Callable[[Any], Any]] = [
        lambda a: a[:-1],
        lambda a: a[:, :-1],
        lambda a: a[None],
        lambda a: a.tolist(),
    ]
    data[name] = shapes[random.integers(len(shapes))](data[name])


def wrong_type(data: Data, random: Random) -> None:
    """Numbers of a type that does not fit."""
    name = random.choice([name for name in data if data[name] is not None])
    kind = random.choice(["float32", "float64", "complex128", "object", "str", "uint64", "bool"])
    with np.errstate(invalid="ignore", over="ignore"):  # nonsense is what is asked for
        data[name] = data[name].astype(kind)


HOSTILE = (
    on_a_grid,
    scaled,
    far_away,
    needle,
    flattened,
    folded_normals,
    nearly_parallel_normals,
    random_normals,
    normals_along_edges,
    normals_in_faces,
    sized_second_forms,
    unnormalised,
    bare,
)
BROKEN = (
    not_finite,
    wrong_index,
    wrong_vertex,
    wrong_orientation,
    face_twice,
    faces_missing,
    coincident_points,
    not_tangential,
    wrong_shape,
    wrong_type,
)


@st.composite
def hostile_mesh_data(draw: st.DrawFn, broken: bool = True, quads: bool | None = None) -> Data:
    """Constructor arguments that are valid, hostile or (with ``broken``) wrong: HermiteMesh takes or refuses them."""
    data = draw(mesh_data(quads))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    changes = draw(st.lists(st.sampled_from(HOSTILE), max_size=3, unique=True))
    for change in sorted(changes, key=HOSTILE.index):  # the data are left out last
        change(data, random)
    if broken and draw(st.booleans()):
        kinds = [kind for kind in BROKEN if kind is not not_tangential or data["second_forms"] is not None]
        draw(st.sampled_from(kinds))(data, random)
    return data
