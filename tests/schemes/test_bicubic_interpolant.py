"""The bicubic interpolant: corners and centres matched where roots are found, branches counted, fallbacks as told."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.measures.centre_errors import centre_errors
from testbed.plugins.scheme import Data
from testbed_schemes.bicubic_interpolant import BicubicInterpolant
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.zero_twist_bicubic import ZeroTwistBicubic


def size(mesh: HermiteMesh) -> float:
    return float(norm(np.ptp(mesh.points, axis=0)))


@pytest.mark.parametrize("boundary", ["hermite", "planar", "optimized"])
@pytest.mark.parametrize("spec", ["quad-torus[twist=1]", "quad-sphere", "quad-graph", "quad-graph[height=3,bowl=0]"])
def test_centres_are_matched_wherever_no_fallback_is_noted(spec: str, boundary: str) -> None:
    mesh = registry.dataset(spec).mesh(1)
    surface = registry.scheme(f"bicubic-interpolant[boundary={boundary}]").fit(mesh)
    errors = centre_errors(surface)
    assert errors is not None
    missed = errors.missed(size(mesh))
    noted = sum(count for kind, count in surface.notes.items() if kind.startswith("centres"))
    assert missed.sum() == noted
    assert not missed.all()
    assert sum(surface.branches.values()) + noted == len(mesh.faces)
    assert errors.relative(size(mesh))[:, ~missed].max() < 1e-9


@pytest.mark.parametrize("spec", ["quad-torus", "quad-torus[twist=1]", "quad-graph[height=3,bowl=0]"])
def test_corners_are_matched_whatever_the_branch(spec: str) -> None:
    mesh = registry.dataset(spec).mesh(1)
    for without in ("zero-twist", "linear"):
        jet = registry.scheme(f"bicubic-interpolant[without_root={without}]").fit(mesh).batches[0].jets(CORNERS[4])
        assert norm(jet.f - mesh.corner_points()).max() < 1e-14
        assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13
        assert np.abs(second_form_matrix(jet) - mesh.corner_second_forms()).max() < 1e-8


def test_the_torus_has_roots_outside_and_none_inside_as_published() -> None:
    """Mann 1992, page 69, figure 4.4; each face is symmetric, and its roots are a pair of mirror images."""
    mesh = registry.dataset("quad-torus[phase=0]").mesh(0)
    surface = BicubicInterpolant().fit(mesh)
    assert surface.notes == {"centres with roots equally near": 20, "centres without a root": 30}
    assert not surface.branches
    errors = centre_errors(surface)
    assert errors is not None
    assert mesh.face_data.centres is not None
    outside = np.hypot(*mesh.face_data.centres.points[:, :2].T) > 1.0
    # the mean of two roots matches position and normal
    assert errors.distance[outside].max() < 1e-14
    assert errors.angle[outside].max() < 1e-13
    assert 1e-3 < errors.form[outside].max() < 0.5
    assert errors.distance[~outside].min() > 1e-4


def test_farther_roots_count_where_they_are_asked_for() -> None:
    mesh = registry.dataset("quad-torus[phase=0]").mesh(0)
    notes = BicubicInterpolant(reach=3.0).fit(mesh).notes
    assert notes == {"centres with roots equally near": 30, "centres without a root": 20}
    assert BicubicInterpolant(reach=1e-3).fit(mesh).notes == {"centres without a root": 50}


def test_the_mean_of_mirror_images_has_their_symmetry() -> None:
    mesh = registry.dataset("quad-torus").mesh(0)
    f = BicubicInterpolant().fit(mesh).batches[0].jets(lattice(4, 4), 0).f.reshape(len(mesh.faces), 5, 5, 3)
    around, height = np.hypot(f[..., 0], f[..., 1]), f[..., 2]
    assert np.abs(around - around[:, ::-1]).max() < 1e-9
    assert np.abs(height - height[:, ::-1]).max() < 1e-9


def test_without_a_root_the_zero_twist_points_are_taken_or_the_linear_equations_solved() -> None:
    mesh = registry.dataset("quad-torus[phase=0]").mesh(0)
    zero = ZeroTwistBicubic().fit(mesh).batches[0].control_points  # type: ignore[attr-defined]
    published = BicubicInterpolant().fit(mesh)
    same = np.abs(published.batches[0].control_points - zero).max(axis=(1, 2, 3)) == 0.0  # type: ignore[attr-defined]
    assert same.sum() == 30
    linear = BicubicInterpolant(without_root="linear").fit(mesh)
    assert linear.notes == published.notes
    errors = centre_errors(linear)
    assert errors is not None
    assert errors.distance.max() < 1e-14
    assert errors.angle.max() < 1e-12
    assert errors.form.min() > 1e-3


def test_flat_data_give_planes_and_count_their_centres() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [2.4, 1.4, 0.0], [0.3, 1.0, 0.0]])
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    up, flat = np.tile([0.0, 0.0, 1.0], (4, 1)), np.zeros((4, 3, 3))
    centres = Centres(points.mean(axis=0, keepdims=True), up[:1], flat[:1])
    mesh = HermiteMesh(points, [[0, 1, 2, 3]], up, flat, face_data=FaceData(centres))
    surface = BicubicInterpolant().fit(mesh.transformed(rotation, [3.0, -1.0, 2.0]))
    assert surface.notes == {"centres with singular equations": 1}
    offsets = surface.batches[0].jets(lattice(4, 4), 0).f - surface.mesh.points[0]
    assert np.abs(offsets @ rotation[:, 2]).max() < 1e-14


def error_by_level(spec: str, scheme: str, levels: tuple[int, ...]) -> Float:
    dataset = registry.dataset(spec)
    assert dataset.surface is not None
    result = []
    for level in levels:
        f = registry.scheme(scheme).fit(dataset.mesh(level)).batches[0].jets(lattice(4, 6), 0).f.reshape(-1, 3)
        result.append(norm(dataset.surface.closest(f) - f).max())
    return np.array(result)


def test_the_order_is_four_and_not_six_where_every_face_has_a_root() -> None:
    off = error_by_level("quad-graph", "bicubic-interpolant", (1, 2, 3, 4))
    local = np.log2(off[:-1] / off[1:])
    assert np.mean(local[1:]) == pytest.approx(4.0, abs=0.35)


def test_samples_at_the_centres_are_needed_and_claimed() -> None:
    mesh = registry.dataset("quad-graph").mesh(0)
    bare = HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms)
    with pytest.raises(Refused, match="needs samples at the centres of the faces and the mesh has none: give"):
        BicubicInterpolant().fit(bare)
    assert BicubicInterpolant().matches == Data.POINTS | Data.NORMALS | Data.SECOND_FORMS | Data.CENTRES
    assert BicubicInterpolant(Planar()).matches == Data.POINTS | Data.NORMALS | Data.CENTRES
    assert BicubicInterpolant().order == 6.0
    assert BicubicInterpolant(Planar()).order is None


@pytest.mark.parametrize("reach", [0.0, -1.0, float("nan")])
def test_the_reach_is_positive(reach: float) -> None:
    with pytest.raises(SpecError, match="bicubic-interpolant: reach must be positive"):
        BicubicInterpolant(reach=reach)


@pytest.mark.parametrize("factor", [1e-30, 1e8, 1e30])
def test_second_forms_of_any_size_at_the_centres_leave_a_finite_patch(factor: float) -> None:
    mesh = registry.dataset("quad-sphere").mesh(0)
    centres = mesh.face_data.centres
    assert centres is not None
    data = FaceData(Centres(centres.points, centres.normals, factor * centres.second_forms))
    surface = BicubicInterpolant().fit(
        HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms, face_data=data)
    )
    assert surface.patch_count == 12
