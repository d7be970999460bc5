"""Data of faces: carried along by every operation on meshes, consistent between neighbours, refused where wrong."""

import numpy as np
import pytest

from testbed.errors import MeshError
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, cross, unit

POINTS = unit(np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.1, 0.0, 1.0], [1.0, 1.0, 1.3], [1.0, 1.2, -0.4]]))
FACES = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4]])


def sphere_forms(normals: Float, size: Float) -> Float:
    return size[..., None, None] * (np.eye(3) - normals[..., :, None] * normals[..., None, :])


def full_mesh() -> HermiteMesh:
    """All data there can be, no two rows alike; sides 0 of faces 0 and 3 are followed."""
    corners = POINTS[FACES]
    centres = unit(corners.mean(axis=1))
    forms = sphere_forms(corners, 1.0 + np.arange(12.0).reshape(4, 3))
    tangents = np.full((4, 3, 2, 3), np.nan)
    start, end = POINTS[0], POINTS[1]
    along = unit(np.stack([cross(cross(start, end), start), cross(cross(start, end), end)]))
    tangents[0, 0] = along
    tangents[3, 0] = -along[::-1]
    return HermiteMesh(
        POINTS,
        FACES,
        POINTS,
        sphere_forms(POINTS, np.ones(5)),
        face_data=FaceData(Centres(centres, centres, sphere_forms(centres, np.arange(1.0, 5.0))), forms, tangents),
    )


def same(one: HermiteMesh, other: HermiteMesh) -> bool:
    return all(
        np.allclose(array, other.face_data.arrays()[name], atol=1e-13, equal_nan=True)
        for name, array in one.face_data.arrays().items()
    )


def test_operations_that_undo_each_other_leave_the_data_alone() -> None:
    mesh = full_mesh()
    assert len(mesh.face_data.arrays()) == 5
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = mesh.transformed(quarter, (1.0, 2.0, 3.0), 2.0)
    back = moved.transformed(scale=0.5).transformed(translation=(-0.5, -1.0, -1.5)).transformed(quarter.T)
    assert same(mesh, back)
    assert not same(mesh, moved)
    assert same(mesh, mesh.flipped().flipped())
    assert not same(mesh, mesh.flipped())
    assert same(mesh, mesh.rotated_corners(np.array([1, 2, 0, 1])).rotated_corners(np.array([2, 1, 0, 2])))
    assert same(mesh, mesh.with_face_order(np.array([2, 0, 3, 1])).with_face_order(np.array([1, 3, 0, 2])))


def test_relabelling_and_rotation_do_not_change_what_an_edge_is_given() -> None:
    mesh = full_mesh()
    for changed in (
        mesh,
        mesh.relabelled(np.array([3, 1, 0, 4, 2])),
        mesh.rotated_corners(np.array([1, 2, 0, 2])),
        mesh.with_face_order(np.array([3, 2, 1, 0])),
        mesh.flipped(),
    ):
        data = changed.edge_data
        assert data.t0 is not None
        assert data.t1 is not None
        followed = np.flatnonzero(np.isfinite(data.t0).all(axis=1))
        assert len(followed) == 1
        p0, p1 = data.p0[followed[0]], data.p1[followed[0]]
        assert {tuple(p0), tuple(p1)} == {tuple(POINTS[0]), tuple(POINTS[1])}
        chord = p1 - p0
        assert data.t0[followed[0]] @ chord > 0.0
        assert data.t1[followed[0]] @ chord > 0.0
        assert abs(data.t0[followed[0]] @ p0) < 1e-12
        assert abs(data.t1[followed[0]] @ p1) < 1e-12


def test_edges_take_the_second_forms_of_an_adjacent_face() -> None:
    mesh = full_mesh()
    data, forms = mesh.edge_data, mesh.face_data.corner_second_forms
    assert forms is not None
    assert data.W0 is not None
    assert data.W1 is not None
    for edge, (low, high) in enumerate(mesh.edges.tolist()):
        choices = [
            (forms[face, corners.index(low)], forms[face, corners.index(high)])
            for face, corners in enumerate(mesh.faces.tolist())
            if low in corners and high in corners
        ]
        assert any(np.allclose(data.W0[edge], a) and np.allclose(data.W1[edge], b) for a, b in choices)
    u = np.broadcast_to(cross(POINTS, POINTS[::-1] + 0.1)[mesh.faces], (4, 3, 3))
    assert np.allclose(mesh.second_form(u, u), np.einsum("fci,fcij,fcj->fc", u, forms, u))


def test_parts_of_a_mesh_keep_their_rows_and_what_belongs_to_dropped_data_goes() -> None:
    mesh = full_mesh()
    part = mesh.submesh(np.array([3, 0]))
    for name, array in part.face_data.arrays().items():
        assert np.array_equal(array, mesh.face_data.arrays()[name][[3, 0]], equal_nan=True)
    assert set(mesh.without_second_forms().face_data.arrays()) == {"side_tangents"}
    assert not mesh.without_normals().face_data.arrays()
    with pytest.raises(ValueError, match="read-only"):
        mesh.face_data.arrays()["centre_points"][0] = 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: {"centres": Centres(d.centres.points[:3], d.centres.normals, d.centres.second_forms)}, "3 points"),
        (lambda d: {"centres": Centres(d.centres.points, 0 * d.centres.normals, d.centres.second_forms)}, "zero"),
        (lambda d: {"corner_second_forms": d.corner_second_forms + np.eye(3)}, "corner 0 of face 0 .*tangential"),
        (lambda d: {"corner_second_forms": d.corner_second_forms[:, :2]}, "shape"),
        (lambda d: {"side_tangents": -1.0 * np.where(np.arange(4)[:, None, None, None] == 3, -1, 1) * d.side_tangents},
         "other tangents"),
        (lambda d: {"side_tangents": np.where(np.arange(4)[:, None, None, None] == 3, np.nan, d.side_tangents)},
         "other tangents"),
        (lambda d: {"side_tangents": d.side_tangents + 0.1}, "side 0 of face 0 .*tangent plane"),
        (lambda d: {"side_tangents": np.where(np.arange(2)[:, None] == 1, np.nan, d.side_tangents)}, "half"),
        (lambda d: {"side_tangents": d.side_tangents[0]}, "shape"),
    ],
)  # fmt: skip
def test_wrong_data_are_refused_where_they_are_wrong(change: object, message: str) -> None:
    mesh = full_mesh()
    data = {**vars(mesh.face_data), **change(mesh.face_data)}  # type: ignore[operator]
    with pytest.raises(MeshError, match=message):
        HermiteMesh(POINTS, FACES, POINTS, mesh.second_forms, face_data=FaceData(**data))


def test_data_of_faces_need_normals() -> None:
    with pytest.raises(MeshError, match="no normals"):
        HermiteMesh(POINTS, FACES, face_data=full_mesh().face_data)
