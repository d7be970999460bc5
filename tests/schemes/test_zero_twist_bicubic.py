"""The zero-twist bicubic: corner data matched, twists as defined, the orders of the two twists."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.bezier import BezierQuads
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.scheme import Data
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.zero_twist_bicubic import ZeroTwistBicubic


def nets(surface: Surface) -> Float:
    (batch,) = surface.batches
    assert isinstance(batch, BezierQuads)
    return batch.control_points


def distances(spec: str, twist: str, levels: tuple[int, ...]) -> Float:
    """Largest distance of each face to the exact surface, by level, its median and its maximum: (levels, 2)."""
    dataset, scheme = registry.dataset(spec), registry.scheme(f"zero-twist-bicubic[twist={twist}]")
    assert dataset.surface is not None
    result = []
    for level in levels:
        points = scheme.fit(dataset.mesh(level)).batches[0].jets(lattice(4, 4), 0).f
        off = norm(dataset.surface.closest(points.reshape(-1, 3)) - points.reshape(-1, 3)).reshape(len(points), -1)
        result.append([np.median(off.max(axis=1)), off.max()])
    return np.array(result)


@pytest.mark.parametrize("twist", ["zero", "adini"])
@pytest.mark.parametrize("spec", ["quad-torus", "quad-torus[twist=1]", "quad-sphere", "quad-graph"])
def test_position_normal_and_second_form_are_matched_at_the_corners(spec: str, twist: str) -> None:
    mesh = registry.dataset(spec).mesh(1)
    surface = registry.scheme(f"zero-twist-bicubic[twist={twist}]").fit(mesh)
    assert not surface.notes
    jet = surface.batches[0].jets(CORNERS[4])
    assert norm(jet.f - mesh.corner_points()).max() < 1e-14
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13
    assert np.abs(second_form_matrix(jet) - mesh.corner_second_forms()).max() < 1e-10


def test_without_curvature_the_mixed_derivatives_at_the_corners_are_zero_up_to_the_normal() -> None:
    mesh = registry.dataset("quad-sphere").mesh(0)
    jet = ZeroTwistBicubic().fit(mesh).batches[0].jets(CORNERS[4])
    assert norm(np.cross(jet.fuv, mesh.corner_normals())).max() < 1e-13
    assert norm(jet.fuv).max() > 1e-3


def test_flat_data_with_straight_sides_give_a_plane_and_with_adinis_twist_the_bilinear_patch() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [2.4, 1.4, 0.0], [0.3, 1.0, 0.0]])
    mesh = HermiteMesh(points, [[0, 1, 2, 3]], np.tile([0.0, 0.0, 1.0], (4, 1)), np.zeros((4, 3, 3)))
    at = lattice(4, 4)
    s, t = at[:, :1], at[:, 1:]
    a, b, c, d = points
    bilinear = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * d + s * c)
    adini = ZeroTwistBicubic(twist="adini").fit(mesh).batches[0].jets(at, 0).f[0]
    zero = ZeroTwistBicubic().fit(mesh).batches[0].jets(at, 0).f[0]
    assert norm(adini - bilinear).max() < 1e-14
    assert norm(zero - bilinear).max() > 1e-3
    assert np.abs(zero[:, 2]).max() == 0.0


def test_the_order_is_three_and_not_five() -> None:
    off = distances("quad-sphere", "zero", (3, 4, 5))
    local = np.log2(off[:-1] / off[1:])
    assert local[-1].max() < 3.6
    assert (np.diff(local, axis=0) < 0.05).all()  # and falling


def test_with_adinis_twist_the_order_is_six() -> None:
    off = distances("quad-torus", "adini", (2, 3, 4))
    assert np.log2(off[:-1] / off[1:])[:, 0] == pytest.approx(6.0, abs=0.3)


def test_only_curves_that_match_curvature_make_the_claims() -> None:
    assert ZeroTwistBicubic().order == 5.0
    assert Data.SECOND_FORMS in ZeroTwistBicubic().matches
    assert ZeroTwistBicubic(Planar()).order is None
    assert Data.SECOND_FORMS not in ZeroTwistBicubic(Planar()).matches


def test_second_forms_that_put_inner_control_points_far_away_are_refused() -> None:
    sphere, scheme = registry.dataset("quad-sphere").mesh(0), ZeroTwistBicubic(Planar())
    assert sphere.second_forms is not None
    for factor, far in ((1e6, False), (1e13, True)):
        data = HermiteMesh(sphere.points, sphere.faces, sphere.normals, factor * sphere.second_forms)
        if far:
            with pytest.raises(Refused, match=r"moves an inner control point of face \d+ \(vertices .*\) by \de\+\d\d"):
                scheme.fit(data)
        else:
            assert scheme.fit(data).patch_count == 12


def test_fallbacks_of_the_boundary_are_reported_with_the_surface() -> None:
    surface = ZeroTwistBicubic().fit(registry.dataset("quad-torus[phase=0]").mesh(2))
    assert surface.notes == {"curves without a root": 80}
    assert nets(surface).shape == (800, 4, 4, 3)
