"""Bézier cells: points in VTK's order, and cells read from a file are the patches."""

from pathlib import Path

import numpy as np
import pytest
from test_export_files import read_vtu

from testbed import registry
from testbed.errors import TestbedError
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed_reports.export.bezier_cells import bezier_cells, quad_order, triangle_order
from testbed_reports.export.formats import export_surface

#: Exponents of b0, b1, b2 in the order of vtkHigherOrderTriangle::BarycentricIndex of VTK 9.7, for each degree.
TRIANGLES = {
    1: "100 010 001",
    2: "200 020 002 110 011 101",
    3: "300 030 003 210 120 021 012 102 201 111",
    4: "400 040 004 310 220 130 031 022 013 103 202 301 211 121 112",
    5: "500 050 005 410 320 230 140 041 032 023 014 104 203 302 401 311 131 113 221 122 212",
    6: "600 060 006 510 420 330 240 150 051 042 033 024 015 105 204 303 402 501 "
    "411 141 114 321 231 132 123 213 312 222",
}
#: Places along u and v in the order of vtkHigherOrderQuadrilateral::PointIndexFromIJK of VTK 9.7, for degrees.
QUADS = {
    (1, 1): "00 10 11 01",
    (2, 1): "00 20 21 01 10 11",
    (1, 3): "00 10 13 03 11 12 01 02",
    (2, 2): "00 20 22 02 10 21 12 01 11",
    (3, 2): "00 30 32 02 10 20 31 12 22 01 11 21",
    (3, 4): "00 30 34 04 10 20 31 32 33 14 24 01 02 03 11 21 12 22 13 23",
}


@pytest.mark.parametrize("degree", TRIANGLES)
def test_points_of_triangles_are_in_the_order_of_vtk(degree: int) -> None:
    assert " ".join("".join(map(str, indices)) for indices in triangle_order(degree)) == TRIANGLES[degree]


@pytest.mark.parametrize("degrees", QUADS)
def test_points_of_quads_are_in_the_order_of_vtk(degrees: tuple[int, int]) -> None:
    assert " ".join("".join(map(str, place)) for place in quad_order(*degrees)) == QUADS[degrees]


def in_order(net: dict[str, Float], degree: int, b: Float) -> Float:
    """De Casteljau's algorithm on points, or homogeneous points, by their exponents."""
    for left in range(degree - 1, -1, -1):
        step = {}
        for i in range(left + 1):
            for j in range(left + 1 - i):
                k = left - i - j
                above = (f"{i + 1}{j}{k}", f"{i}{j + 1}{k}", f"{i}{j}{k + 1}")
                step[f"{i}{j}{k}"] = sum(c * net[name] for c, name in zip(b, above, strict=True))
        net = step
    found: Float = net["000"]
    return found


def curve(points: Float, t: float) -> Float:
    """De Casteljau's algorithm along the first axis."""
    while len(points) > 1:
        points = (1.0 - t) * points[:-1] + t * points[1:]
    end: Float = points[0]
    return end


def evaluated(path: Path, at: Float) -> Float:
    """Points (C, S, 3) of the cells in a file at parameters (S, 2), by nothing but VTK's order and definitions."""
    grid = read_vtu(path)
    weights = np.ones(len(grid["Points"]))
    if "RationalWeights" in grid:
        assert grid["PointData"] == {"RationalWeights": "RationalWeights"}
        weights = grid["RationalWeights"]
    assert grid["CellData"] == {"HigherOrderDegrees": "HigherOrderDegrees"}
    homogeneous = np.concatenate([grid["Points"] * weights[:, None], weights[:, None]], axis=1)
    found, begin = [], 0
    for end, kind, (m, n, zero) in zip(grid["offsets"], grid["types"], grid["HigherOrderDegrees"], strict=True):
        own, begin = homogeneous[grid["connectivity"][begin:end]], int(end)
        assert zero == 0
        if kind == 76:
            assert m == n
            net = dict(zip(TRIANGLES[int(m)].split(), own, strict=True))
            points = np.array([in_order(net, int(m), np.array([1.0 - u - v, u, v])) for u, v in at])
        else:
            assert kind == 77
            square = np.empty((m + 1, n + 1, 4))
            for name, point in zip(QUADS[int(m), int(n)].split(), own, strict=True):
                square[int(name[0]), int(name[1])] = point
            points = np.array([curve(curve(square, u), v) for u, v in at])
        found.append(points[:, :3] / points[:, 3:])
    return np.array(found)


TRIANGLE = HermiteMesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
SQUARE = HermiteMesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))


def check(surface: Surface, path: Path, seed: int = 0) -> None:
    """Compare cells read from a file with the surface at random parameters."""
    export_surface(surface, path)
    at = np.random.default_rng(seed).dirichlet([1.0, 1.0, 1.0], size=7)[:, 1:]
    expected = np.concatenate([batch.jets(at, 0).f for batch in surface.batches])
    np.testing.assert_allclose(evaluated(path, at), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("degree", TRIANGLES)
@pytest.mark.parametrize("is_rational", [False, True])
def test_triangles_of_any_degree_read_back_as_they_are(degree: int, is_rational: bool, tmp_path: Path) -> None:
    random = np.random.default_rng(degree)
    net = random.normal(size=(1, (degree + 1) * (degree + 2) // 2, 3))
    weights = random.uniform(0.5, 2.0, net.shape[:2])
    batch = RationalBezierTriangles(net, weights) if is_rational else BezierTriangles(net)
    check(Surface.over_faces(TRIANGLE, batch), tmp_path / "a.vtu")


@pytest.mark.parametrize("degrees", QUADS)
def test_quads_of_any_degrees_read_back_as_they_are(degrees: tuple[int, int], tmp_path: Path) -> None:
    net = np.random.default_rng(7).normal(size=(1, degrees[0] + 1, degrees[1] + 1, 3))
    check(Surface.over_faces(SQUARE, BezierQuads(net)), tmp_path / "a.vtu")


@pytest.mark.parametrize(
    ("scheme", "dataset"), [("peters", "octahedron"), ("hansford", "octahedron"), ("peters", "graph")]
)
def test_surfaces_read_back_as_they_are(scheme: str, dataset: str, tmp_path: Path) -> None:
    surface = registry.scheme(scheme).fit(registry.dataset(dataset).mesh(0))
    check(surface, tmp_path / "a.vtu")
    grid = read_vtu(tmp_path / "a.vtu")
    np.testing.assert_array_equal(grid["face"], np.concatenate([part.faces for part in surface.parts]))
    assert len(grid["part"]) == surface.patch_count
    assert ("RationalWeights" in grid) == (scheme == "hansford")


def test_weights_of_polynomial_patches_beside_rational_ones_are_one() -> None:
    rational, polynomial = (
        registry.scheme(name).fit(registry.dataset("octahedron").mesh(0)) for name in ("hansford", "shirman-sequin")
    )
    cells = bezier_cells(Surface(rational.mesh, (*rational.parts, *polynomial.parts)))
    assert cells.weights is not None
    assert (cells.weights[15 * 24 :] == 1.0).all()
    assert (cells.weights[: 15 * 24] != 1.0).any()
    assert bezier_cells(polynomial).weights is None


@pytest.mark.parametrize("suffix", [".vtu", ".npz"])
@pytest.mark.parametrize("scheme", ["nielson", "a-patch", "loop", "triangular-gregory"])
def test_patches_without_control_nets_are_refused_in_one_sentence(scheme: str, suffix: str, tmp_path: Path) -> None:
    surface = registry.scheme(scheme).fit(registry.dataset("octahedron").mesh(0))
    with pytest.raises(TestbedError, match="no control net: write triangles") as caught:
        export_surface(surface, tmp_path / f"a{suffix}")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())
