"""Jensen: G1 across mesh edges and C1 inside, the second rows of Shirman and Sequin, the spread of curvature."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import cases, icosahedron, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.jensen import Jensen
from testbed_schemes.mathematics.split_domain import J, c1_ring
from testbed_schemes.shirman_sequin import ShirmanSequin

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, *np.linspace(0.05, 0.95, 13), 1 - 1e-3, 1.0])
#: Places in a quartic sub-patch: the edge, C_ij and C_ik, N_i.
EDGE, CROSS, INNER = [0, 1, 3, 6, 10], [4, 7], 8


def nets(surface: Surface) -> Float:
    """Control points of the quartics, (F, 3, 15, 3)."""
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    assert batch.degree == 4
    return batch.control_points.reshape(-1, 3, 15, 3)


def largest_jump(surface: Surface) -> float:
    """Largest angle between normals across edges, inner ones included, in degrees."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
    return float(np.degrees(angle_between(left.normal, right.normal)).max())


def extremes(scheme: Jensen, mesh: HermiteMesh) -> tuple[float, float]:
    """Least and largest Gaussian curvature over the first face."""
    curvature = gauss(scheme.fit(mesh).batches[0].take(np.arange(3)).jets(lattice(3, 30)))
    return float(curvature.min()), float(curvature.max())


@pytest.mark.parametrize("boundary", [Projected(), Planar(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_mesh_edges_and_inner_edges(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for jensen_c in (1.0, 1.3):
        assert largest_jump(Jensen(boundary, jensen_c).fit(mesh)) < 1e-8


@given(st.floats(0.5, 2.5))
@settings(max_examples=10)
def test_every_c_leaves_the_surface_tangent_continuous(jensen_c: float) -> None:
    assert largest_jump(Jensen(jensen_c=jensen_c).fit(perturbed_icosahedron())) < 1e-8


@pytest.mark.parametrize("jensen_c", [1.0, 0.7, 1.234])
@pytest.mark.parametrize("boundary", [Projected(), Hermite()], ids=str)
def test_across_the_edges_it_is_the_scheme_of_shirman_and_sequin(boundary: BoundaryCurve, jensen_c: float) -> None:
    """At alpha_i2 = 9/4 the first spoke points are the same, and with them all points but those further inside."""
    for mesh in (octahedron(), torus(8, 5, 3), perturbed_icosahedron()):
        ours, theirs = nets(Jensen(boundary, jensen_c).fit(mesh)), nets(ShirmanSequin(boundary, jensen_c).fit(mesh))
        outer = [*EDGE, 2, 11, *CROSS]
        assert ours[:, :, outer] == pytest.approx(theirs[:, :, outer], abs=1e-14)
        assert ours[:, :, [5, 12]] == pytest.approx(theirs[:, :, [5, 12]], abs=1e-13)
        assert np.abs(ours[:, :, INNER] - theirs[:, :, INNER]).max() > 1e-4


def test_the_spokes_are_c1_for_any_data_and_shirman_and_sequins_for_one_alpha() -> None:
    def misfit(surface: Surface) -> float:
        """Of D_left + D_right = 3 (derivative along the spoke), for the rows on both sides of spokes V_k S."""
        net = nets(surface)
        spoke, left, right = net[:, :, [10, 11, 12, 13, 14]], net[:, :, [6, 7, 8, 9]], net[:, J][:, :, [1, 4, 8, 13]]
        both = left + right - 2.0 * spoke[:, :, :-1]
        return float(np.abs(both - 3.0 * np.diff(spoke, axis=2)).max())

    mesh = perturbed_icosahedron()
    assert misfit(Jensen(Hermite(), 1.2).fit(mesh)) < 1e-14
    assert misfit(ShirmanSequin().fit(mesh)) < 1e-14
    assert misfit(ShirmanSequin(alpha2=1.75).fit(mesh)) > 1e-2


def test_every_spoke_point_is_the_centroid_of_its_neighbours() -> None:
    net = nets(Jensen(Hermite(), 1.2).fit(perturbed_icosahedron()))
    ring = c1_ring(net[:, :, EDGE], (net[:, :, CROSS[0]], net[:, :, CROSS[1]]), net[:, :, INNER])
    assert ring.nets() == pytest.approx(net, abs=1e-14)


def test_the_edges_are_the_curves_of_the_network() -> None:
    mesh = perturbed_icosahedron()
    curves = Hermite().network(mesh).opposite_vertices()
    assert np.array_equal(nets(Jensen(Hermite()).fit(mesh))[:, :, EDGE], elevate_curve(curves))


@pytest.mark.parametrize(
    ("mesh", "jensen_c", "expected"),
    [(octahedron(), 1.23, (0.942, 1.031)), (icosahedron(), 1.062, (0.986, 1.007))],
    ids=["octahedron", "icosahedron"],
)
def test_one_c_spreads_the_curvature_of_a_sphere_evenly(
    mesh: HermiteMesh, jensen_c: float, expected: tuple[float, float]
) -> None:
    """With geometric Hermite edges; which C depends on the data, and the factor 2 C - 1 tells it from Mann 1994's c_i.

    The extremes are ours.
    """
    assert extremes(Jensen(Hermite(), jensen_c), mesh) == pytest.approx(expected, abs=1e-3)
    original = extremes(Jensen(Hermite()), mesh)
    mistaken = extremes(Jensen(Hermite(), (jensen_c + 1.0) / 2.0), mesh)
    assert original[1] - original[0] > mistaken[1] - mistaken[0] > 2.0 * (expected[1] - expected[0])


def test_flat_data_give_the_plane_and_its_own_parameters() -> None:
    mesh = ZOO["flat mesh"]
    bary = barycentric(lattice(3, 7))
    face = np.repeat(np.arange(len(mesh.faces)), len(bary))
    jet = Jensen().fit(mesh).evaluate(face, np.tile(bary, (len(mesh.faces), 1)), order=2)
    expected = np.einsum("bi,fix->fbx", bary, mesh.corner_points()).reshape(-1, 3)
    assert jet.f == pytest.approx(expected, abs=2e-15)
    assert np.abs(jet.coefficients[3:]).max() < 1e-13


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="needs vertex normals"):
        Jensen().fit(HermiteMesh(mesh.points, mesh.faces))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        Jensen().fit(torus(8, 5, 4))
    with pytest.raises(Refused, match="folds over"):
        Jensen().fit(
            HermiteMesh(mesh.points, mesh.faces, mesh.points * np.where(np.arange(6) == 2, -1.0, 1.0)[:, None])
        )


@pytest.mark.parametrize("jensen_c", [float("nan"), float("inf")])
def test_a_jensen_c_that_is_not_finite_is_no_parameter(jensen_c: float) -> None:
    with pytest.raises(SpecError, match="jensen_c must be finite"):
        Jensen(jensen_c=jensen_c)


def test_the_notes_of_the_curves_are_passed_on() -> None:
    mesh = torus(10, 5, 3)
    assert Jensen(Hermite()).fit(mesh).notes == Hermite().network(mesh).notes
