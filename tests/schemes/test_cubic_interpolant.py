"""The cubic interpolant: all corner data matched where the boundary curves match, degenerate centres counted."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry import curvature
from testbed.geometry.bernstein import elevate_triangle
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE
from testbed.geometry.vectors import Float, angle_between, dot, norm
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.cubic_interpolant import CubicInterpolant, centre_planes, centre_points
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre


def gauss(name: str, level: int, steps: int) -> Float:
    jet = CubicInterpolant().fit(registry.dataset(name).mesh(level)).batches[0].jets(lattice(3, steps))
    return curvature.gauss(jet)


@pytest.mark.parametrize(
    ("name", "level"),
    [("octahedron", 0), ("octahedron", 2), ("icosahedron", 1), ("sphere", 0), ("ellipsoid", 1), ("graph", 2)],
)
def test_position_normal_and_second_form_are_matched_at_the_corners(name: str, level: int) -> None:
    mesh = registry.dataset(name).mesh(level)
    surface = CubicInterpolant().fit(mesh)
    assert not surface.notes
    jet = surface.batches[0].jets(CORNERS[3])
    assert mesh.second_forms is not None
    W = curvature.second_form_matrix(jet)
    assert norm(jet.f - mesh.corner_points()).max() < 1e-14
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13
    assert np.abs(W - mesh.second_forms[mesh.faces]).max() < 1e-9


def test_the_published_curvature_of_the_octahedron_but_for_the_maximum() -> None:
    # Mann 1992, figure 3.6: 0.75 to 1.44; P111 = (1, 1, 1) is forced, and then K at the face centre is 27/16
    K = gauss("octahedron", 0, 60)
    assert K.min() == pytest.approx(0.75, abs=0.006)
    centre = CubicInterpolant().fit(registry.dataset("octahedron").mesh(0)).batches[0].jets(np.full((1, 2), 1.0 / 3.0))
    assert curvature.gauss(centre) == pytest.approx(27.0 / 16.0, rel=1e-13)
    assert K.max() == pytest.approx(27.0 / 16.0, rel=1e-13)


def test_the_published_curvature_of_the_refined_octahedron() -> None:
    K = gauss("octahedron", 1, 60)
    assert K.max() == pytest.approx(1.08, abs=0.005)
    assert K.min() == pytest.approx(0.98, abs=0.005)


def test_centres_within_reach_keep_patches_from_folding_near_parabolic_lines() -> None:
    # at one corner of this face the normal is almost in the plane of the two others'
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    normals = np.array([[0.3, 0.0, 1.0], [-0.3, 0.0, 1.0], [0.05, 1e-3, 1.0]])
    normals /= norm(normals)[:, None]
    forms = np.einsum("v,vij->vij", [0.5, 0.6, -0.4], np.eye(3) - normals[:, :, None] * normals[:, None, :])
    mesh = HermiteMesh(points, np.array([[0, 1, 2]]), normals, forms)
    at = lattice(3, 20)
    astray, limited = (scheme.fit(mesh) for scheme in (CubicInterpolant(), CubicInterpolant(reach=0.2)))
    upright = np.array([0.0, 0.0, 1.0])
    assert dot(astray.batches[0].jets(at).normal, upright).min() < -0.9
    assert dot(limited.batches[0].jets(at).normal, upright).min() > 0.8
    assert limited.notes["centres out of reach"] == 1
    net = limited.batches[0].control_points[0]  # type: ignore[attr-defined]
    moved = net[CENTRE] - quadratic_precision_centre(net[None])[0]
    assert norm(moved[:2]) == pytest.approx(0.2 * np.sqrt(0.5), rel=1e-9)
    # of all points as far along the plane, none is nearer to the three planes
    normal, height = (rows[0] for rows in centre_planes(mesh, net[None], slice(None), net[None, CENTRE] - moved))
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    around = norm(moved[:2]) * np.stack([np.cos(angle), np.sin(angle)])
    rest = height[:, None] - normal[:, :2] @ around
    heights = normal[:, 2] @ rest / (normal[:, 2] @ normal[:, 2])
    miss = norm((rest - normal[:, 2:] * heights).T)
    assert norm(normal @ moved - height) <= miss.min() * (1.0 + 1e-9)


def test_reach_changes_nothing_where_centres_are_within_it_and_is_positive() -> None:
    mesh = registry.dataset("ellipsoid").mesh(2)
    free, limited = (
        scheme.fit(mesh).batches[0].jets(lattice(3, 3)).f
        for scheme in (CubicInterpolant(), CubicInterpolant(reach=0.2))
    )
    assert np.array_equal(free, limited)
    with pytest.raises(SpecError, match="reach"):
        CubicInterpolant(reach=0.0)


def test_the_centre_lies_on_the_three_planes_of_the_mixed_partials() -> None:
    mesh = registry.dataset("ellipsoid").mesh(1)
    net = CubicInterpolant().fit(mesh).batches[0].control_points  # type: ignore[attr-defined]
    vertex = mesh.corner_points()
    # legs towards the next and the previous corner: 210, 201; 021, 120; 102, 012
    u = net[:, [1, 7, 5]] - vertex
    v = net[:, [2, 3, 8]] - vertex
    height = dot(net[:, None, CENTRE] - vertex, mesh.corner_normals())
    assert np.abs(height + 1.5 * mesh.second_form(u, v)).max() < 1e-14


def test_flat_data_give_linear_patches_and_count_their_centres() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.0, 0.0], [2.1, 1.4, 0.0]])
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    normals = np.broadcast_to(rotation[:, 2], (4, 3))
    mesh = HermiteMesh(points @ rotation.T + 3.0, [[0, 1, 2], [1, 3, 2]], normals, np.zeros((4, 3, 3)))
    surface = CubicInterpolant().fit(mesh)
    assert surface.notes == {"singular centres": 2}
    jet = surface.batches[0].jets(lattice(3, 4))
    assert max(norm(jet.fuu).max(), norm(jet.fuv).max(), norm(jet.fvv).max()) < 1e-12
    assert np.abs(dot(jet.f - mesh.points[0], rotation[:, 2])).max() < 1e-14


def test_a_cylinder_has_singular_centres_and_stays_near() -> None:
    angle, z = np.meshgrid([0.0, 0.2, 0.4], [0.0, 0.25, 0.5], indexing="ij")
    normals = np.stack([np.cos(angle), np.sin(angle), 0.0 * z], axis=-1).reshape(-1, 3)
    points = normals + np.stack([0.0 * z, 0.0 * z, z], axis=-1).reshape(-1, 3)
    along = np.cross([0.0, 0.0, 1.0], normals)
    i, j = (index.ravel() for index in np.meshgrid([0, 1], [0, 1], indexing="ij"))
    corner = 3 * i + j
    faces = np.concatenate(
        [np.stack([corner, corner + 3, corner + 4], -1), np.stack([corner, corner + 4, corner + 1], -1)]
    )
    mesh = HermiteMesh(points, faces, normals, along[:, :, None] * along[:, None])
    surface = CubicInterpolant().fit(mesh)
    assert surface.notes == {"singular centres": 8}
    f = surface.batches[0].jets(lattice(3, 6), 0).f
    assert np.abs(np.hypot(f[..., 0], f[..., 1]) - 1.0).max() < 1e-5


def test_fallbacks_of_the_boundary_are_reported_with_the_surface() -> None:
    surface = CubicInterpolant().fit(registry.dataset("torus[minor=0.5,phase=0]").mesh(0))
    assert surface.notes["curves without a root"] == 20


def test_a_planar_boundary_is_a_parameter() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    scheme = registry.scheme("cubic-interpolant[boundary=planar]")
    assert scheme == CubicInterpolant(boundary=Planar())
    net = scheme.fit(mesh).batches[0].control_points  # type: ignore[attr-defined]
    assert norm(net[:, 1] - net[:, 0]) == pytest.approx(np.sqrt(2.0) / 3.0)


def test_quadratic_nets_have_their_raised_centre() -> None:
    quadratic = np.random.default_rng(2).normal(size=(5, 6, 3))
    cubic = elevate_triangle(quadratic)
    assert norm(quadratic_precision_centre(cubic) - cubic[:, CENTRE]).max() < 1e-14


def test_singular_planes_take_the_point_next_to_quadratic_precision() -> None:
    mesh = registry.dataset("graph").mesh(0)
    net = np.array(CubicInterpolant().fit(mesh).batches[0].control_points)  # type: ignore[attr-defined]
    normals = np.broadcast_to([0.0, 0.0, 1.0], (len(mesh.points), 3))
    level = HermiteMesh(mesh.points, mesh.faces, normals, np.zeros((len(mesh.points), 3, 3)))
    centres, rank = centre_points(level, net)
    guess = quadratic_precision_centre(net)
    assert (rank == 1).all()
    assert np.abs((centres - guess)[:, :2]).max() < 1e-14
    assert centres[:, 2] == pytest.approx(mesh.corner_points()[..., 2].mean(axis=1), abs=1e-14)


def test_the_distance_to_a_sphere_falls_with_the_claimed_order_at_least() -> None:
    dataset = registry.dataset("octahedron")
    off = [
        np.abs(norm(CubicInterpolant().fit(dataset.mesh(level)).batches[0].jets(lattice(3, 6), 0).f) - 1.0).max()
        for level in (2, 3, 4)
    ]
    assert np.log2(np.divide(off[:-1], off[1:])).min() > 5.5
