"""Crossing tetrahedra: against linear programming, touching ones, sweeping in chunks, hulls of A-patch meshes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import Delaunay

from testbed import registry
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, norm, unit
from testbed_schemes.mathematics import tetrahedron_crossings
from testbed_schemes.mathematics.a_patch_sides import hull
from testbed_schemes.mathematics.tetrahedron_crossings import cross_each_other, crossing_pairs, hull_tetrahedra


def depth(one: Float, other: Float) -> float:
    """The largest least weight of a point in both: positive where they have inner points in common."""
    equal = np.zeros((5, 9))
    equal[:3, :4], equal[:3, 4:8] = one.T, -other.T
    equal[3, :4] = equal[4, 4:8] = 1.0
    above = np.hstack([-np.eye(8), np.ones((8, 1))])
    found = linprog([0.0] * 8 + [-1.0], above, np.zeros(8), equal, [0.0, 0.0, 0.0, 1.0, 1.0], [(None, None)] * 9)
    assert found.x is not None
    return float(found.x[-1])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_they_cross_where_a_point_has_positive_weights_in_both(seed: int) -> None:
    random = np.random.default_rng(seed)
    pair = random.normal(size=(2, 4, 3)) * random.uniform(0.2, 2.0, (2, 1, 1))
    pair[1] += random.normal(size=3) * random.uniform(0.0, 2.0)
    shared = random.integers(4)  # corners in common, as neighbours have
    pair[1, :shared] = pair[0, :shared]
    found = depth(pair[0], pair[1])
    if abs(found) > 1e-7:
        assert cross_each_other(pair[:1], pair[1:])[0] == (found > 0.0)
        assert cross_each_other(pair[1:], pair[:1])[0] == (found > 0.0)


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
def test_tetrahedra_that_fill_space_touch_but_do_not_cross(scale: float) -> None:
    random = np.random.default_rng(4)
    points = scale * random.uniform(size=(60, 3))
    tetrahedra = points[Delaunay(points / scale).simplices]
    assert len(crossing_pairs(tetrahedra)) == 0
    inner = int(np.argmin(norm(tetrahedra.mean(axis=1) - 0.5 * scale)))
    tetrahedra[inner] += 0.05 * scale
    pairs = crossing_pairs(tetrahedra)
    assert len(pairs) >= 4
    assert (pairs == inner).any(axis=1).all()


def test_all_pairs_are_found_in_chunks_of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(5)
    tetrahedra = random.uniform(size=(80, 1, 3)) + 0.3 * random.normal(size=(80, 4, 3))
    one, other = np.triu_indices(80, 1)
    chosen = cross_each_other(tetrahedra[one], tetrahedra[other])
    expected = np.stack([one[chosen], other[chosen]], axis=-1)
    assert 100 < len(expected) < 2000
    for chunk in (1, 3, 8192):
        monkeypatch.setattr(tetrahedron_crossings, "CHUNK", chunk)
        assert np.array_equal(crossing_pairs(tetrahedra), expected)
    assert crossing_pairs(tetrahedra[:1]).shape == crossing_pairs(tetrahedra[:0]).shape == (0, 2)


@pytest.mark.parametrize(("name", "level"), [("icosahedron", 0), ("torus", 1), ("graph", 0), ("mesh", 0)])
def test_no_tetrahedra_of_usual_meshes_cross(name: str, level: int) -> None:
    mesh = registry.dataset(name).mesh(level)
    found = hull(HermiteMesh(mesh.points, mesh.faces, gradients=mesh.normals), 0.05, 1e-12)
    tetrahedra = hull_tetrahedra(found)
    count = sum(len(found.standing_faces(side)) + len(found.standing_edges(side)) for side in range(2))
    assert tetrahedra.shape == (count, 4, 3)
    assert np.isfinite(tetrahedra).all()
    assert len(crossing_pairs(tetrahedra)) == 0


def test_tetrahedra_of_sheets_that_lie_close_cross() -> None:
    # a cap over another one: neighbours are apart, the lower tetrahedra reach through the upper faces
    mesh = registry.dataset("icosahedron").mesh(0)
    count = len(mesh.points)
    points = np.concatenate([mesh.points, 1.1 * mesh.points])
    both = HermiteMesh(points, np.concatenate([mesh.faces, mesh.faces + count]), gradients=unit(points))
    pairs = crossing_pairs(hull_tetrahedra(hull(both, 0.05, 1e-12)))
    assert len(pairs) >= 20
    assert len(crossing_pairs(hull_tetrahedra(hull(both, 0.05, 1e-12))[:20])) == 0  # within one sheet
