"""What the explanations of published figures say is what is measured."""

import dataclasses
from collections.abc import Mapping

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.nets import CENTRE
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.measures.continuity import edge_jumps
from testbed_reports.published import (
    rounds_to,
)
from testbed_reports.published_table import (
    published_table,
)
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.optimized import Optimized
from testbed_schemes.cubic_interpolant import CubicInterpolant
from testbed_schemes.mathematics.planar_frame import planar_frame


def explanation(scheme: str, dataset: str, column: str, level: int | None = 0) -> str:
    [text] = [
        one.explanation
        for one in published_table().figures
        if (one.scheme, one.dataset, one.column, one.level) == (scheme, dataset, column, level)
    ]
    return text


def fitted(scheme: str, dataset: str, level: int = 0) -> Surface:
    return registry.scheme(scheme).fit(registry.dataset(dataset).mesh(level))


def seen(surface: Surface, steps: int) -> tuple[float, float]:
    """Largest and smallest Gaussian curvature on a lattice of so many intervals a side."""
    gauss = np.concatenate([analyse(one.jets(lattice(3, steps), 2)).gauss.ravel() for one in surface.batches])
    return float(gauss.max()), float(gauss.min())


def test_the_lumpy_sphere_shows_the_printed_curvatures_on_three_lattices() -> None:
    spec = "shirman-sequin[boundary=hermite[root=worst]]"
    text = explanation(spec, "sphere", "gauss_max")
    assert text == explanation(spec, "sphere", "gauss_min")
    surface = fitted(spec, "sphere")
    for steps in (5, 10, 15):
        largest, smallest = seen(surface, steps)
        assert f"shows {largest:.1f} and {smallest:.1f};" in text
        assert rounds_to(largest, "235")
        assert rounds_to(smallest, "-298")
    found = registry.measure(surface)
    assert f"are {found['gauss_max']:.1f} and {found['gauss_min']:.1f}." in text


def test_only_the_ring_edges_of_the_sphere_have_a_choice_of_curves() -> None:
    mesh = registry.dataset("sphere").mesh(0)
    best, _ = Hermite().curves(mesh.edge_data)
    worst, _ = Hermite(root="worst").curves(mesh.edge_data)
    several = norm(best - worst).max(axis=1) > 1e-6
    start, end = (mesh.points[mesh.edges[several, side]] for side in (0, 1))
    assert np.allclose(start[:, 2], end[:, 2])
    arcs = np.degrees(angle_between(start, end))
    assert np.ptp(arcs) < 1e-9
    text = explanation("shirman-sequin[boundary=hermite[root=worst]]", "sphere", "gauss_max")
    assert f"Only the {several.sum()} edges of the two rings, arcs of {arcs[0]:.1f} degrees" in text


@dataclasses.dataclass(frozen=True)
class HermiteOrOptimized(Hermite):
    """Geometric Hermite curves, and optimized ones where there is none."""

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        found, _ = super().curves(edges)
        _, solved = self.legs(edges, planar_frame(edges))
        return np.where(solved[:, None, None], found, Optimized().curves(edges)[0]), {}


def jumps(surface: Surface) -> tuple[str, str]:
    """Largest angle between normals, and the largest at ten evenly spaced parameters, ends included."""
    largest = registry.measure(surface)["epsilon_deg"]
    ten = np.degrees(edge_jumps(surface, surface.edges, np.arange(10) / 9.0)[0].max())
    return f"{largest:.2f}", f"{ten:.2f}"


def test_the_jump_on_the_torus_is_that_of_the_edges_without_a_curve() -> None:
    text = explanation("cubic-interpolant", "torus[phase=0]", "epsilon_deg")
    mesh = registry.dataset("torus[phase=0]").mesh(0)
    surface = CubicInterpolant().fit(mesh)
    assert f"{surface.notes['curves without a root']} of the {len(mesh.edges)} edges have no" in text
    largest, ten = jumps(CubicInterpolant(boundary=HermiteOrOptimized()).fit(mesh))
    assert f"the largest jump is {largest}, and {ten} at the ten" in text
    thinner = fitted("cubic-interpolant", "torus[phase=0,minor=0.375]")
    assert not thinner.notes
    assert f"the two numbers are {' and '.join(jumps(thinner))}." in text
    assert rounds_to(float(ten), "6.2")


def test_the_cubic_interpolant_of_the_octahedron_has_no_choice() -> None:
    most = explanation("cubic-interpolant", "octahedron", "gauss_max")
    least = explanation("cubic-interpolant", "octahedron", "gauss_min")
    surface = fitted("cubic-interpolant", "octahedron")
    [batch] = surface.batches
    assert isinstance(batch, BezierTriangles)
    assert np.allclose(np.abs(batch.control_points[:, CENTRE]), 1.0)
    assert np.allclose(analyse(batch.jets(np.full((1, 2), 1.0 / 3.0), 2)).gauss, 27.0 / 16.0)
    mesh = surface.mesh
    assert np.array_equal(Hermite().curves(mesh.edge_data)[0], Hermite(root="worst").curves(mesh.edge_data)[0])
    assert not any(rounds_to(seen(surface, steps)[0], "1.44") for steps in range(1, 33))
    beside = registry.measure(fitted("shirman-sequin[boundary=hermite]", "octahedron"))["gauss_max"]
    assert f"near the maximum, {beside:.3f}, of" in most
    assert f"The minimum {registry.measure(surface)['gauss_min']:.4f} lies at the middles" in least
    assert f"with 5 it shows {seen(surface, 5)[1]:.4f}, with 15 it shows {seen(surface, 15)[1]:.4f}." in least


def test_the_jump_on_the_ellipsoid_falls_as_told() -> None:
    text = explanation("cubic-interpolant", "ellipsoid", "epsilon_deg", 4)
    one, two = (registry.measure(fitted("cubic-interpolant", "ellipsoid", level))["epsilon_deg"] for level in (1, 2))
    assert f"{one:.2f} degrees after one halving and {two:.2f} after two" in text


@pytest.mark.parametrize(("scheme", "printed"), [("cubic-interpolant", 5), ("quadratic-interpolant", 3)])
def test_spheres_are_worth_one_order_without_a_symmetric_mesh(scheme: str, printed: int) -> None:
    text = explanation(scheme, "sphere", "distance_max", None)
    corners = np.array([[0.0, 0.0], [1.0, 0.13], [0.31, 0.77]])

    def order(dataset: str) -> float:
        """Local order of the distance on one triangle that shrinks towards a corner."""
        surface = registry.dataset(dataset).surface
        assert surface is not None
        errors = []
        for size in (0.05, 0.025):
            points = on_surface(dataset, size * corners + np.array([0.35, 0.21]))
            fit = registry.scheme(scheme).fit(surface.sample(points, np.array([[0, 1, 2]])))
            reached = fit.batches[0].jets(lattice(3, 20), 0).f.reshape(-1, 3)
            errors.append(norm(reached - surface.closest(reached)).max())
        return float(np.log2(errors[0] / errors[1]))

    assert f"shows {order('sphere'):.0f} too, and {order('graph'):.0f} on the generic surface" in text
    assert round(order("ellipsoid")) == printed + 1
    assert round(order("graph")) == printed


def on_surface(dataset: str, plane: Float) -> Float:
    """Points of the upper half of a surface over points of the plane, stretched with the ellipsoid's axes."""
    if dataset == "graph":
        surface = registry.dataset(dataset).surface
        straight: Float = surface.over(plane)  # type: ignore[union-attr]  # the graph's own
        return straight
    sphere = np.column_stack([plane, np.sqrt(1.0 - (plane**2).sum(axis=1))])
    stretched: Float = sphere * ([1.0, 2.0**0.5, 2.0] if dataset == "ellipsoid" else 1.0)
    return stretched


def test_the_refined_octahedron_has_the_vertices_that_euler_counts() -> None:
    mesh: HermiteMesh = registry.dataset("octahedron").mesh(1)
    assert (len(mesh.points), len(mesh.edges), len(mesh.faces)) == (18, 48, 32)
    text = explanation("cubic-interpolant", "octahedron", "vertices", 1)
    assert "32 faces" in text
    assert "48 edges" in text
    assert "18 vertices" in text


def test_the_default_of_a_patches_is_off_the_sphere_as_told() -> None:
    text = explanation("a-patch", "icosahedron", "distance_max")
    exact = registry.dataset("icosahedron").surface

    def off(free: str) -> float:
        return float(registry.measure(fitted(f"a-patch[free={free}]", "icosahedron"), exact)["distance_max"])

    for number, like in (("0.829", "default"), ("1.580", "quadric")):
        assert number in text
        assert off(number) == pytest.approx(off(like), abs=1e-4)
    assert off("quadric") < 1e-14


def test_a_quadric_is_lost_where_edges_are_split() -> None:
    text = explanation("a-patch[free=quadric]", "hyperboloid", "distance_max")
    assert f"cross at {fitted('a-patch[free=quadric]', 'hyperboloid').branches['hull modifications']} edges" in text
    assert fitted("a-patch[free=quadric]", "hyperboloid", 1).branches["hull modifications"] == 0
