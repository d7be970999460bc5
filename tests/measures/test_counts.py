"""Counts: what is counted, and in which words."""

from testbed.conformance.meshes import octahedron
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.surface import Surface
from testbed.measures.counts import Fallbacks, Size
from testbed.plugins.measure import measure_all
from testbed.registry import scheme


def test_size_counts_the_mesh_and_the_patches() -> None:
    row = measure_all([Size()], scheme("shirman-sequin").fit(octahedron()), None)
    assert row == {"vertices": 6, "faces": 8, "patches": 24, "h": 2**0.5}


def test_fallbacks_are_counted_together_and_told_apart() -> None:
    mesh = octahedron()
    notes = {"curves without a root": 3, "singular centres": 0, "curves not converged": 2}
    row = measure_all([Fallbacks()], Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()), notes), None)
    assert row == {"fallbacks": 5, "notes": "2 curves not converged; 3 curves without a root"}


def test_ordinary_branches_are_no_fallbacks() -> None:
    mesh = octahedron()
    branches = {"centres with several roots": 3, "centres with one root": 5, "none": 0}
    surface = Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()), {}, branches)
    row = measure_all([Fallbacks()], surface, None)
    assert row == {"fallbacks": 0, "notes": "", "branches": "5 centres with one root; 3 centres with several roots"}
