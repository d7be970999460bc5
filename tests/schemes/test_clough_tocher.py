"""Clough-Tocher on heights: scipy's function on Delaunay triangulations, C1 on all, and positive by two remedies."""

import numpy as np
import pytest
from scipy.interpolate import CloughTocher2DInterpolator
from scipy.spatial import Delaunay

from testbed.conformance.meshes import cases, grid, icosahedron
from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between, dot, norm
from testbed_schemes.clough_tocher import CloughTocher
from testbed_schemes.mathematics.clipped_triangles import ClippedTriangles
from testbed_schemes.mathematics.clough_tocher_nets import edge_ordinates, least_bending_gradients

T = np.linspace(0.0, 1.0, 17)
#: Seeds of data on which no edge has its two faces aslant of each other.
SEEDS = (0, 1, 3)
every_seed = pytest.mark.parametrize("seed", SEEDS)


def scattered(seed: int, count: int = 60) -> HermiteMesh:
    """Return a Delaunay triangulation of points in the unit square with heights in [0, 1), two of five zero."""
    random = np.random.default_rng(seed)
    points, heights = random.random((count, 2)), random.random(count) * (random.random(count) > 0.4)
    return HermiteMesh(np.column_stack([points, heights]), Delaunay(points).simplices)


def places(mesh: HermiteMesh) -> tuple[Int, Float]:
    random = np.random.default_rng(5)
    return random.integers(0, len(mesh.faces), 2000), random.dirichlet([1, 1, 1], 2000)


def triangles(surface: Surface) -> Float:
    (batch,) = surface.batches
    assert isinstance(batch, BezierTriangles)
    return batch.control_points


def jump(surface: Surface) -> float:
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, 1)
    return float(np.degrees(angle_between(left.normal, right.normal)).max())


@every_seed
def test_on_a_delaunay_triangulation_it_is_scipys_function(seed: int) -> None:
    mesh = scattered(seed)
    at = CloughTocher().fit(mesh).evaluate(*places(mesh), 0).f
    by_scipy = CloughTocher2DInterpolator(mesh.points[:, :2], mesh.points[:, 2], tol=1e-15, maxiter=100_000)
    error = np.abs(by_scipy(at[:, :2]) - at[:, 2])
    assert np.median(error) < 1e-15
    assert error.max() < 1e-12  # in the narrow faces on the hull
    # its default tolerance stops the iteration for gradients earlier
    early = CloughTocher2DInterpolator(mesh.points[:, :2], mesh.points[:, 2])
    assert 1e-10 < np.abs(early(at[:, :2]) - at[:, 2]).max() < 1e-5


def test_on_another_triangulation_it_is_not() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.3, 1.0], [2.0, 0.0, 0.5], [1.0, -0.3, 0.2]])
    mesh = HermiteMesh(points, [[0, 3, 2], [0, 2, 1]])  # the long diagonal, where Delaunay takes the short one
    at = CloughTocher().fit(mesh).evaluate(*places(mesh), 0).f
    by_scipy = CloughTocher2DInterpolator(points[:, :2], points[:, 2], tol=1e-15, maxiter=100_000)
    assert np.nanmax(np.abs(by_scipy(at[:, :2]) - at[:, 2])) > 0.1
    assert jump(CloughTocher().fit(mesh)) < 1e-10


def test_gradients_bend_the_edges_least() -> None:
    mesh = scattered(7, 30)
    points, heights = mesh.points[:, :2], mesh.points[:, 2]

    def energy(gradients: Float) -> float:
        start, end = mesh.edges.T
        along = points[end] - points[start]
        first, last = dot(gradients[start], along), dot(gradients[end], along)
        rise, length = heights[end] - heights[start], np.hypot(*along.T)
        return float(((first**2 + first * last + last**2 - 3 * rise * (first + last) + 3 * rise**2) / length**3).sum())

    found = least_bending_gradients(points, heights, mesh.edges)
    steps = 1e-4 * np.random.default_rng(1).normal(size=(20, *found.shape))
    assert all(energy(found + step) > energy(found) for step in steps)


@pytest.mark.parametrize("scheme", [CloughTocher(), CloughTocher(gradients="data"), CloughTocher(positive=True)])
def test_it_is_c1_over_the_plane(scheme: CloughTocher) -> None:
    mesh = scattered(0)
    random = np.random.default_rng(2)
    normals = np.column_stack([random.normal(size=(len(mesh.points), 2)), np.ones(len(mesh.points))])
    surface = scheme.fit(HermiteMesh(mesh.points, mesh.faces, normals))
    assert jump(surface) < 1e-10
    net = triangles(surface)
    # the parametrisation of the plane is linear on every face
    for i in range(3):
        at = surface.mesh.points[mesh.faces][:, [(i + 1) % 3, (i + 2) % 3], :2]
        middle = mesh.points[mesh.faces][..., :2].mean(axis=1)
        linear = (at[:, 0] + at[:, 1] + middle) / 3.0
        assert np.abs(net.reshape(-1, 3, 10, 3)[:, i, 4, :2] - linear).max() < 1e-15


def test_with_the_gradients_of_the_data_it_reproduces_quadratic_polynomials() -> None:
    coefficients = np.array([[0.1, -0.3, 0.7], [0.2, 0.4, 0.0], [-0.6, 0.0, 0.0]])
    mesh = grid(3, 4, coefficients)
    points = CloughTocher(gradients="data").fit(mesh).evaluate(*places(mesh), 0).f
    expected = np.polynomial.polynomial.polyval2d(points[:, 0], points[:, 1], coefficients)
    assert np.abs(points[:, 2] - expected).max() < 1e-14
    # the estimated ones do not
    points = CloughTocher().fit(mesh).evaluate(*places(mesh), 0).f
    assert (
        np.abs(points[:, 2] - np.polynomial.polynomial.polyval2d(points[:, 0], points[:, 1], coefficients)).max() > 1e-4
    )


@every_seed
def test_clipped_it_is_the_larger_of_height_and_zero_and_creased(seed: int) -> None:
    mesh = scattered(seed)
    plain, clipped = CloughTocher().fit(mesh), CloughTocher(clip=True).fit(mesh)
    before, after = plain.evaluate(*places(mesh), 2), clipped.evaluate(*places(mesh), 2)
    below = before.f[:, 2] < 0.0
    assert below.any()
    assert np.array_equal(after.f[:, 2], np.maximum(before.f[:, 2], 0.0))
    assert np.array_equal(after.coefficients[:, ~below], before.coefficients[:, ~below])
    assert not after.coefficients[:, below, 2].any()
    assert np.array_equal(after.coefficients[:, below, :2], before.coefficients[:, below, :2])
    assert 0 < clipped.branches["faces with ordinates below zero"] <= len(mesh.faces)


@every_seed
def test_a_clipped_patch_lies_between_its_convex_components(seed: int) -> None:
    (batch,) = CloughTocher(clip=True).fit(scattered(seed)).batches
    assert isinstance(batch, ClippedTriangles)
    at = lattice(3, 9)
    point = batch.jets(at, 0).f
    low, high = (one.jets(at, 0).f for one in batch.convex_components)
    assert norm(low[..., :2] - point[..., :2]).max() < 1e-14
    assert (low[..., 2] <= point[..., 2]).all()
    assert (point[..., 2] <= high[..., 2] + 1e-15).all()
    assert low[..., 2].min() == 0.0


@every_seed
def test_positive_it_has_no_ordinate_below_zero_and_slopes_along_the_estimated_ones(seed: int) -> None:
    mesh = scattered(seed)
    plain, positive = CloughTocher().fit(mesh), CloughTocher(positive=True).fit(mesh)
    assert triangles(plain)[..., 2].min() < -0.01
    assert triangles(positive)[..., 2].min() == 0.0
    corners = (np.arange(len(mesh.faces)), np.tile([1.0, 0.0, 0.0], (len(mesh.faces), 1)))
    before, after = (surface.evaluate(*corners, 1) for surface in (plain, positive))
    assert np.abs(after.fu[:, 2] * before.fv[:, 2] - after.fv[:, 2] * before.fu[:, 2]).max() < 1e-12
    share = np.hypot(after.fu[:, 2], after.fv[:, 2]) / np.hypot(before.fu[:, 2], before.fv[:, 2])
    assert share.max() < 1.0 + 1e-9
    reduced = positive.branches["vertices with reduced slopes"]
    assert (mesh.points[:, 2] == 0.0).sum() <= reduced < len(mesh.points)


def test_positive_changes_nothing_where_no_ordinate_is_negative() -> None:
    mesh = scattered(0)
    lifted = HermiteMesh(mesh.points + np.array([0.0, 0.0, 10.0]), mesh.faces)
    assert np.array_equal(triangles(CloughTocher().fit(lifted)), triangles(CloughTocher(positive=True).fit(lifted)))


def test_heights_below_zero_are_refused_by_the_remedies_only() -> None:
    mesh = scattered(0)
    points = mesh.points.copy()
    points[17, 2] = -0.01
    below = HermiteMesh(points, mesh.faces)
    assert CloughTocher().fit(below).patch_count == 3 * len(mesh.faces)
    for scheme in (CloughTocher(clip=True), CloughTocher(positive=True)):
        with pytest.raises(Refused, match=r"vertex 17 has z = -0\.01 \(1 of 60"):
            scheme.fit(below)


def test_faces_aslant_of_each_other_are_refused_where_slopes_cannot_help() -> None:
    # both faces at the edge 0-1 lean beyond vertex 0: with level ends the second row goes below zero
    points = np.array([[0, 0, 0], [1, 0, 1], [-2, 1, 0], [-2, -1, 0]], dtype=np.float64)
    mesh = HermiteMesh(points, [[0, 1, 2], [1, 0, 3]])
    with pytest.raises(Refused, match="edge from vertex 0 to vertex 1, the first of 2 sides"):
        CloughTocher(positive=True).fit(mesh)


def test_meshes_that_turn_over_the_plane_are_refused() -> None:
    with pytest.raises(Refused, match=r"face \d+ \(vertices .* 20 do\): turn the mesh"):
        CloughTocher().fit(icosahedron())
    upright = HermiteMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 1]], [[0, 1, 2], [2, 1, 3]])
    with pytest.raises(Refused, match=r"face 1 \(vertices 2, 1, 3\) stands upright"):
        CloughTocher().fit(upright)
    flat = next(case.mesh for case in cases(3) if case.name == "flat mesh")
    assert flat.normals is not None
    normals = flat.normals.copy()
    normals[4] = [1.0, 0.0, 0.0]
    with pytest.raises(Refused, match="tangent plane at vertex 4 stands upright"):
        CloughTocher(gradients="data").fit(HermiteMesh(flat.points, flat.faces, normals))


def test_one_remedy_at_a_time() -> None:
    with pytest.raises(SpecError, match="clip and positive are two remedies"):
        CloughTocher(clip=True, positive=True)


def test_edge_ordinates_are_those_of_the_cubic_with_these_slopes() -> None:
    corners = np.array([[[0.0, 0.0], [3.0, 0.0], [0.0, 6.0]]])
    curves = edge_ordinates(corners, np.array([[1.0, 2.0, 4.0]]), np.array([[[1.0, 0.5], [0.0, 0.0], [0.0, -1.0]]]))
    assert curves[0].tolist() == [[2.0, 2.0, 6.0, 4.0], [4.0, 6.0, 2.0, 1.0], [1.0, 2.0, 2.0, 2.0]]
