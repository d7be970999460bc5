"""The two faces are those the paper describes: what its text says of their edges is true of the data."""

import numpy as np
import pytest

from testbed.errors import Refused, SpecError
from testbed.registry import dataset
from testbed_datasets.joined_faces import JoinedFaces


def signs(case: str) -> set[tuple[int, int, int]]:
    """Edge by edge its ends and its kind: 1 convex, -1 concave, 0 straight, 2 neither."""
    mesh = dataset(f"joined-faces[case={case}]").mesh(0)
    assert mesh.gradients is not None
    found = set()
    for i, j in mesh.edges:
        along = mesh.points[j] - mesh.points[i]
        a, b = along @ mesh.gradients[j], -along @ mesh.gradients[i]
        found.add((int(i), int(j), 2 if a * b < 0 else int(np.sign(a + b))))
    return found


def test_the_edges_are_as_the_paper_says() -> None:
    assert signs("convex") == {(0, 1, 1), (0, 2, 1), (1, 2, 1), (0, 3, 1), (1, 3, 1)}
    assert (0, 1, 1) in signs("mixed")
    assert {kind for i, j, kind in signs("mixed") if 2 in (i, j)} == {1}
    assert 2 in {kind for i, j, kind in signs("mixed") if 3 in (i, j)}
    assert signs("nonconvex") == {(0, 1, 2), (1, 2, 2), (0, 2, -1), (0, 3, -1), (1, 3, 2)}
    flat = signs("flat")
    assert {(0, 1, 0), (0, 3, 0), (1, 3, 0)} <= flat
    assert {kind for i, j, kind in flat if 2 in (i, j)} == {2}


def test_there_is_one_level_and_no_other_case() -> None:
    with pytest.raises(Refused, match="no level 1"):
        JoinedFaces().mesh(1)
    with pytest.raises(SpecError, match="case"):
        dataset("joined-faces[case=bent]")


def test_the_second_face_runs_back_along_the_edge() -> None:
    mesh = JoinedFaces("flat").mesh(0)
    upright = np.cross(
        mesh.corner_points()[:, 1] - mesh.corner_points()[:, 0], mesh.corner_points()[:, 2] - mesh.corner_points()[:, 0]
    )
    assert (upright[:, 2] > 0).all()
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals[3], [0, 0, 1])
