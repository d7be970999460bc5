"""Every refusal is one sentence that names the place; what is valid is taken, at any size and place."""

import re
from typing import Any

import numpy as np
import pytest
from hostile_meshes import Data, bipyramid, fan, hostile_mesh_data, mesh_data, quad_grid
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from testbed.errors import MeshError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float

quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
seeds = st.integers(0, 2**32 - 1)


def refusal(**data: Any) -> str:
    with pytest.raises(MeshError) as caught:
        HermiteMesh(**data)
    message = str(caught.value)
    assert "\n" not in message
    assert ": " in message, "what to do stands behind the colon"
    return message


def taken_or_refused(data: Data) -> tuple[HermiteMesh | None, str]:
    try:
        return HermiteMesh(**data), ""
    except MeshError as error:
        return None, str(error)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(hostile_mesh_data())
def test_hostile_data_are_taken_or_refused_in_one_sentence(data: Data) -> None:
    mesh, message = taken_or_refused(data)
    if mesh is None:
        assert 20 < len(message) < 300
        assert "\n" not in message
    else:
        for values in (mesh.points, mesh.normals, mesh.second_forms):
            assert values is None or np.isfinite(values).all()


@quick
@given(mesh_data())
def test_valid_meshes_are_taken(data: Data) -> None:
    mesh = HermiteMesh(**data)
    assert np.array_equal(mesh.points, data["points"])
    assert np.array_equal(mesh.faces, data["faces"])


@quick
@given(mesh_data(), seeds, st.sampled_from(["points", "normals", "second_forms"]), st.sampled_from([np.nan, np.inf]))
def test_nan_and_infinite_values_name_the_vertex(data: Data, seed: int, name: str, value: float) -> None:
    random = np.random.default_rng(seed)
    vertex = int(random.integers(len(data["points"])))
    data[name][vertex].flat[random.integers(data[name][vertex].size)] = value
    message = refusal(**data)
    assert f"at vertex {vertex}:" in message
    assert name.replace("_", " ") in message


@quick
@given(mesh_data(), seeds)
def test_an_index_out_of_range_names_face_and_index(data: Data, seed: int) -> None:
    random = np.random.default_rng(seed)
    face, corner = random.integers(len(data["faces"])), random.integers(data["faces"].shape[1])
    for wrong in (-1, len(data["points"]), 2**62):
        data["faces"][face, corner] = wrong
        assert refusal(**data).startswith(f"face {face} has vertex {wrong},")


@quick
@given(mesh_data(), seeds)
def test_a_repeated_vertex_names_face_and_vertex(data: Data, seed: int) -> None:
    random = np.random.default_rng(seed)
    face = random.integers(len(data["faces"]))
    kept, lost = random.choice(data["faces"].shape[1], 2, replace=False)
    data["faces"][face, lost] = vertex = data["faces"][face, kept]
    message = refusal(**data)
    assert message.startswith(f"face {face} ")
    assert f"has vertex {vertex} more than once" in message


@quick
@given(mesh_data(), seeds)
def test_an_unreferenced_vertex_is_named(data: Data, seed: int) -> None:
    vertex = int(np.random.default_rng(seed).integers(len(data["points"]) + 1))
    data["points"] = np.insert(data["points"], vertex, 5.0, axis=0)
    data["faces"] = data["faces"] + (data["faces"] >= vertex)
    assert refusal(points=data["points"], faces=data["faces"]).startswith(f"vertex {vertex} is in no face")


@quick
@given(mesh_data(), seeds)
def test_a_reversed_face_is_told_from_a_third_face(data: Data, seed: int) -> None:
    assume(len(data["faces"]) > 1)
    face = int(np.random.default_rng(seed).integers(len(data["faces"])))
    data["faces"][face] = data["faces"][face][::-1].copy()
    message = refusal(**data)
    assert "orientations differ" in message
    assert str(face) in re.findall(r"\d+", message.partition("run along")[0])


@quick
@given(mesh_data(), seeds)
def test_a_third_face_on_an_edge_is_not_manifold(data: Data, seed: int) -> None:
    faces, points = data["faces"], data["points"]
    mesh = HermiteMesh(points, faces)
    inner = np.flatnonzero(~mesh.boundary_edges)
    assume(len(inner))
    edge = np.random.default_rng(seed).choice(inner)
    i, j = mesh.edges[edge].tolist()
    new = np.arange(len(points), len(points) + faces.shape[1] - 2)
    points = np.concatenate([points, points[[i]] + np.random.default_rng(seed).normal(size=(len(new), 3))])
    message = refusal(points=points, faces=np.array([*faces, [i, j, *new]]))
    beside = [*sorted(mesh.edge_faces[edge].tolist()), len(faces)]
    assert message.startswith(f"the edge between vertices {i} and {j} is not manifold, it is a side of 3 faces")
    assert f"faces {beside[0]}, {beside[1]} and {beside[2]}" in message


@quick
@given(mesh_data(), seeds)
def test_a_face_given_twice_names_both(data: Data, seed: int) -> None:
    random = np.random.default_rng(seed)
    face = int(random.integers(len(data["faces"])))
    alone = HermiteMesh(data["points"], data["faces"]).submesh(np.array([face]))
    corners = alone.faces[0]
    twice = np.stack([corners, np.roll(corners, int(random.integers(3)))])
    assert refusal(points=alone.points, faces=twice).startswith("faces 0 and 1 have the same vertices")


@quick
@given(mesh_data(quads=False), mesh_data(quads=False), seeds)
def test_a_vertex_with_two_rings_or_fans_is_named(one: Data, other: Data, seed: int) -> None:
    random = np.random.default_rng(seed)
    vertex, joined = int(random.integers(len(one["points"]))), int(random.integers(len(other["points"])))
    points = np.concatenate([one["points"], other["points"] + 10])
    faces = np.concatenate([one["faces"], other["faces"] + len(one["points"])])
    HermiteMesh(points, faces)  # two components are fine
    rename = np.insert(len(one["points"]) + np.arange(len(other["points"]) - 1), joined, vertex)
    points = np.delete(points, len(one["points"]) + joined, axis=0)
    faces = np.array([*one["faces"], *rename[other["faces"]]])
    message = refusal(points=points, faces=faces)
    assert message.startswith(f"vertex {vertex} is not manifold, its faces make 2 separate")
    first = np.flatnonzero((one["faces"] == vertex).any(axis=1))[0]
    second = len(one["faces"]) + np.flatnonzero((other["faces"] == joined).any(axis=1))[0]
    assert f"at faces {first}, {second})" in message


@pytest.mark.parametrize("valence", [3, 4, 5, 7, 8, 9, 12, 100, 1025])
def test_rings_and_fans_of_any_valence_are_one(valence: int) -> None:
    assert HermiteMesh(*bipyramid(valence)).valence.max() == max(valence, 4)
    assert HermiteMesh(*fan(valence)).valence.max() == valence


@quick
@given(mesh_data(quads=False), seeds, st.floats(-30, 30), st.sampled_from(["coincide", "on a line", "nearly"]))
def test_a_face_without_area_is_named_at_any_scale(data: Data, seed: int, scale: float, how: str) -> None:
    random = np.random.default_rng(seed)
    face = int(random.integers(len(data["faces"])))
    a, b, c = random.permutation(data["faces"][face])
    points = 10.0**scale * data["points"]
    points[a] = points[b] if how == "coincide" else 0.3 * points[b] + 0.7 * points[c]
    if how == "nearly":
        points[a] *= 1 + 2e-16
    message = refusal(points=points, faces=data["faces"])
    assert "is degenerate, its area is zero" in message
    named = int(message.split()[1])
    assert a in data["faces"][named], "a face of the moved vertex, the first"
    assert named <= face


def test_a_face_of_one_point_is_degenerate() -> None:
    assert refusal(points=np.ones((3, 3)), faces=[[0, 1, 2]]).startswith("face 0 (vertices 0, 1, 2) is degenerate")


@pytest.mark.parametrize("height", [1e-12, 1e-9, 1e-3])
def test_needles_are_no_degenerate_faces(height: float) -> None:
    HermiteMesh([[0, 0, 0], [1, 0, 0], [0.5, height, 0]], [[0, 1, 2]])


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])


@pytest.mark.parametrize("order", [[0, 2, 1, 3], [0, 1, 3, 2]])
def test_a_quadrilateral_that_crosses_itself_is_refused(order: list[int]) -> None:
    assert "face 0 (vertices " in refusal(points=SQUARE, faces=[order])
    assert "crosses itself" in refusal(points=SQUARE, faces=[order])


def test_a_quadrilateral_that_is_not_convex_is_refused_at_the_vertex() -> None:
    for vertex in range(4):
        points = SQUARE.copy()
        points[vertex] = 0.9 * SQUARE[(vertex + 2) % 4] + 0.1 * SQUARE[vertex]
        assert f"is not convex at vertex {vertex}" in refusal(points=points, faces=[[0, 1, 2, 3]])
        points[vertex] = 0.5 * (SQUARE[(vertex + 1) % 4] + SQUARE[vertex - 1])
        assert f"sides at vertex {vertex} lie on one line" in refusal(points=points, faces=[[0, 1, 2, 3]])


def test_a_twisted_quadrilateral_is_taken() -> None:
    HermiteMesh(SQUARE + np.array([[0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, -1]]), [[0, 1, 2, 3]])


@quick
@given(mesh_data(), seeds)
def test_zero_normals_are_named_and_others_normalised(data: Data, seed: int) -> None:
    random = np.random.default_rng(seed)
    kept = HermiteMesh(data["points"], data["faces"], data["normals"])
    lengths = 10.0 ** random.uniform(-300, 300, size=(len(data["points"]), 1))
    scaled = HermiteMesh(data["points"], data["faces"], data["normals"] * lengths)
    assert kept.normals is not None
    assert scaled.normals is not None
    assert np.array_equal(kept.normals, data["normals"]), "normals of length one are kept bit for bit"
    np.testing.assert_allclose(scaled.normals, data["normals"], atol=1e-15)
    again = HermiteMesh(data["points"], data["faces"], scaled.normals)
    assert again.normals is not None
    assert np.array_equal(again.normals, scaled.normals)
    vertex = int(random.integers(len(data["points"])))
    data["normals"][vertex] = 0.0
    assert refusal(**data).startswith(f"the normal at vertex {vertex} is zero")


@quick
@given(mesh_data(), seeds, st.floats(-20, 20))
def test_wrong_second_forms_are_named_at_any_scale(data: Data, seed: int, scale: float) -> None:
    random = np.random.default_rng(seed)
    vertex = int(random.integers(len(data["points"])))
    points, forms = data["points"] * 10.0**scale, data["second_forms"] / 10.0**scale
    size = float(np.abs(forms[vertex]).max())
    normal = data["normals"][vertex]
    HermiteMesh(points, data["faces"], data["normals"], forms)
    skew, normal_part = forms.copy(), forms.copy()
    i, j = random.choice(3, 2, replace=False)
    skew[vertex, i, j] += 1e-3 * size
    normal_part[vertex] += 1e-3 * size * np.outer(normal, normal)
    given_data = {"points": points, "faces": data["faces"], "normals": data["normals"]}
    assert refusal(**given_data, second_forms=skew).startswith(f"the second form at vertex {vertex} is not symmetric")
    message = refusal(**given_data, second_forms=normal_part)
    assert message.startswith(f"the second form at vertex {vertex} is not tangential")


@quick
@given(mesh_data())
def test_second_forms_of_single_precision_are_made_tangential_and_exact_ones_kept(data: Data) -> None:
    def taken(forms: Float) -> Float:
        kept = HermiteMesh(data["points"], data["faces"], data["normals"], forms).second_forms
        assert kept is not None
        return kept

    exact: Float = data["second_forms"]
    assert np.array_equal(taken(exact), exact)
    mended = taken(exact.astype(np.float32).astype(np.float64))
    np.testing.assert_allclose(mended, exact, atol=1e-6)
    normal_part: Float = mended @ data["normals"][:, :, None]
    assert np.abs(normal_part).max() < 1e-14
    assert np.array_equal(taken(mended), mended)


def test_rounding_in_the_second_forms_of_a_plane_is_no_error() -> None:
    points, faces = fan(6)
    points[:, 2] = 0
    noise = 1e-17 * np.random.default_rng(0).normal(size=(len(points), 3, 3))
    HermiteMesh(points, faces, np.broadcast_to([0, 0, 1.0], points.shape), noise)


TRIANGLE = {"points": np.eye(3), "faces": [[0, 1, 2]]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points": []}, ["points have shape (0,)", "(V, 3)"]),
        ({"points": np.empty((0, 3))}, ["empty", "no points"]),
        ({"points": np.zeros((3, 2))}, ["points have shape (3, 2)"]),
        ({"points": [[0, 0], [1]]}, ["points are not an array"]),
        ({"points": "abc"}, ["points hold <U3"]),
        ({"points": np.eye(3) * 1j}, ["points hold complex128"]),
        ({"faces": []}, ["empty", "no faces"]),
        ({"faces": np.empty((0, 3), dtype=int)}, ["empty", "no faces"]),
        ({"faces": [0, 1, 2]}, ["faces have shape (3,)"]),
        ({"faces": [[0, 1]]}, ["faces have shape (1, 2)"]),
        ({"faces": [[0, 1, 2, 0, 1]]}, ["faces have shape (1, 5)"]),
        ({"faces": [[0.0, 1.0, 2.0]]}, ["faces hold float64", "integers"]),
        ({"faces": [[True, False, True]]}, ["faces hold bool"]),
        (
            {"faces": np.array([[0, 1, 2**64 - 1]], dtype=np.uint64)},
            ["face 0 has vertex 18446744073709551615", "0 to 2"],
        ),
        ({"normals": np.ones((2, 3))}, ["2 normals for 3 vertices"]),
        ({"normals": np.ones((3, 4))}, ["normals have shape (3, 4)"]),
        ({"second_forms": np.zeros((3, 3, 3))}, ["second forms and no normals"]),
        ({"normals": np.eye(3), "second_forms": np.zeros((3, 3))}, ["second forms have shape (3, 3)", "(V, 3, 3)"]),
        ({"normals": np.eye(3), "second_forms": np.zeros((2, 3, 3))}, ["2 second forms for 3 vertices"]),
        (
            {"normals": np.eye(3), "second_forms": 1e40 * np.ones((3, 3, 3))},
            ["second form at vertex 0 is beyond 1e+37"],
        ),
        ({"points": 1e150 * np.eye(3)}, ["vertex 0 has a coordinate beyond 1e+37"]),
        ({"points": 1e-150 * np.eye(3)}, ["face 0 (vertices 0, 1, 2) has no side longer than 1e-37"]),
    ],
)
def test_wrong_shapes_types_and_sizes_are_refused(change: dict[str, Any], words: list[str]) -> None:
    message = refusal(**{**TRIANGLE, **change})
    for word in words:
        assert word in message


@pytest.mark.parametrize("scale", [1e-36, 1e-12, 1e12, 1e36])
def test_tiny_and_huge_meshes_are_taken(scale: float) -> None:
    mesh = HermiteMesh(scale * np.eye(3), [[0, 1, 2]], np.ones((3, 3))).with_estimated_normals()
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, np.full((3, 3), 3**-0.5), rtol=1e-15)


@pytest.mark.parametrize("dtype", ["int8", "uint16", "int32", "uint64"])
def test_faces_of_any_integer_type_are_taken(dtype: str) -> None:
    points, faces = quad_grid(3, 3, closed=True)
    assert HermiteMesh(points.astype("float32"), faces.astype(dtype)).faces.dtype == np.int64


@quick
@given(hostile_mesh_data(), seeds)
def test_whether_a_mesh_is_refused_does_not_depend_on_its_labels(data: Data, seed: int) -> None:
    points, faces = np.asarray(data["points"]), np.asarray(data["faces"])
    assume(points.ndim == 2 and points.shape[1] == 3 and points.dtype == np.float64)
    assume(
        faces.ndim == 2 and faces.dtype == np.int64 and faces.size and faces.min() >= 0 and faces.max() < len(points)
    )

    order = np.random.default_rng(seed).permutation(len(points))
    mesh, _ = taken_or_refused({"points": points, "faces": faces})
    relabelled, _ = taken_or_refused({"points": points[order], "faces": np.argsort(order)[faces]})
    assert (mesh is None) == (relabelled is None)
