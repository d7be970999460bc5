"""Walton and Meek's patch: equal to the Gregory patch where the end conormals are equal, and different elsewhere."""

import pytest

from testbed.conformance.meshes import icosahedron, octahedron, perturbed_icosahedron, tetrahedron, torus
from testbed.errors import Refused
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve
from testbed_schemes.triangular_gregory import TriangularGregory
from testbed_schemes.walton_meek import WaltonMeek

AT = lattice(3, 12)
CURVES = [WaltonMeekCurve(), Projected(), Circular(), Hermite(), Planar()]


def control_points(scheme: WaltonMeek | TriangularGregory, mesh: HermiteMesh) -> Float:
    """Control points of the scheme, (F, 18, 3)."""
    batch = scheme.fit(mesh).batches[0]
    assert isinstance(batch, TabulatedTriangles)
    return batch.control_points


@pytest.mark.parametrize("boundary", CURVES, ids=str)
@pytest.mark.parametrize("mesh", [octahedron(), icosahedron(), tetrahedron()])
def test_on_great_circles_it_is_the_gregory_patch(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    """There the conormals at both ends of an edge are the normal of its plane, C0 = C1."""
    one, other = WaltonMeek(boundary), TriangularGregory(boundary, blend="simple")
    assert control_points(one, mesh) == pytest.approx(control_points(other, mesh), abs=1e-12)
    found, expected = (scheme.fit(mesh).batches[0].jets(AT).coefficients for scheme in (one, other))
    assert found == pytest.approx(expected, abs=1e-12, nan_ok=True)


@pytest.mark.parametrize("mesh", [perturbed_icosahedron(), torus(8, 5, 3)])
def test_elsewhere_it_is_not(mesh: HermiteMesh) -> None:
    one, other = WaltonMeek(), TriangularGregory(WaltonMeekCurve(), blend="simple")
    apart = norm(one.fit(mesh).batches[0].jets(AT, 0).f - other.fit(mesh).batches[0].jets(AT, 0).f)
    assert apart.max() > 1e-4


def test_the_curves_are_walton_and_meeks_unless_others_are_given() -> None:
    mesh = perturbed_icosahedron()
    for scheme, boundary in ((WaltonMeek(), WaltonMeekCurve()), (WaltonMeek(Projected()), Projected())):
        curves = boundary.network(mesh).along_sides()
        assert control_points(scheme, mesh)[:, [0, 4, 8]] == pytest.approx(curves[:, :, 0], abs=0.0)
        assert control_points(scheme, mesh)[:, 1] == pytest.approx(
            (curves[:, 0, 0] + 3 * curves[:, 0, 1]) / 4, abs=1e-15
        )


EXTREMES = [
    (WaltonMeek(), octahedron(), (0.46061, 2.25351)),
    (WaltonMeek(), icosahedron(), (0.76567, 1.35346)),
    (WaltonMeek(Hermite()), octahedron(), (0.56907, 2.09652)),
]


@pytest.mark.parametrize(("scheme", "mesh", "extremes"), EXTREMES)
def test_the_curvatures_on_platonic_solids(
    scheme: WaltonMeek, mesh: HermiteMesh, extremes: tuple[float, float]
) -> None:
    at = lattice(3, 60)
    curvature = gauss(scheme.fit(mesh).batches[0].take(slice(0, 1)).jets(at[corner_distance(3, at) > 0.0]))
    assert (float(curvature.min()), float(curvature.max())) == pytest.approx(extremes, abs=1e-5)


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="walton-meek needs vertex normals"):
        WaltonMeek().fit(HermiteMesh(mesh.points, mesh.faces))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        WaltonMeek().fit(torus(8, 5, 4))
