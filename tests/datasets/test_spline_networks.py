"""Branch, ring and networks from files: the published counts, sampled vertices, curves to follow, bad files."""

from pathlib import Path

import numpy as np
import pytest

import testbed_datasets
from testbed import registry
from testbed.errors import MeshError, Refused
from testbed.geometry.costs import network_cost
from testbed.geometry.network_charts import NetworkCharts
from testbed.geometry.spline_network import SplineNetwork
from testbed.geometry.vectors import angle_between, norm

DATA = Path(next(iter(testbed_datasets.__path__)))


def network(spec: str) -> SplineNetwork:
    charted = registry.dataset(spec).charted()
    assert charted is not None
    assert isinstance(charted.charts, NetworkCharts)
    return charted.charts.network


def test_they_have_the_published_patches() -> None:
    branch, ring = network_cost(network("branch")), network_cost(network("ring"))
    assert [(kind.sides, kind.depth, kind.patches) for kind in branch.kinds] == [(4, 3, 20), (5, 6, 4)]
    assert [(kind.sides, kind.depth, kind.patches) for kind in ring.kinds] == [(3, 6, 4), (4, 3, 31), (6, 6, 2)]
    assert (branch.control_points, branch.distinct_points) == (1240, 1015)
    assert (ring.control_points, ring.distinct_points) == (1656, 1272)
    assert [len(registry.dataset(spec).mesh(0).faces) for spec in ("branch", "ring")] == [100, 140]


@pytest.mark.parametrize(("spec", "characteristic", "holes"), [("branch", -1, 3), ("ring", 0, 0)])
def test_their_topology_is_the_one_that_valence_four_asks_for(spec: str, characteristic: int, holes: int) -> None:
    mesh = registry.dataset(spec).mesh(0)
    assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == characteristic
    # the boundary is closed curves through vertices with two boundary edges each
    rim = mesh.edges[mesh.boundary_edges]
    label = np.arange(len(mesh.points))
    for _ in range(len(rim)):
        low = label[rim].min(axis=1)
        np.minimum.at(label, rim[:, 0], low)
        np.minimum.at(label, rim[:, 1], low)
    assert len(np.unique(label[rim])) == holes


@pytest.mark.parametrize("spec", ["branch", "ring"])
def test_vertices_have_the_normals_of_all_patches_and_their_second_forms(spec: str) -> None:
    charted = registry.dataset(spec).charted()
    assert charted is not None
    fine = charted.halved(1)
    mesh, jet = registry.dataset(spec).mesh(1), fine.jets()
    assert mesh.normals is not None
    assert norm(jet.f - mesh.points[mesh.faces]).max() < 1e-13
    assert np.degrees(angle_between(jet.normal, mesh.normals[mesh.faces]).max()) < 1e-10
    # at the corners of other polygons than quadrilaterals each patch has its own
    forms = mesh.face_data.corner_second_forms
    assert forms is not None
    assert mesh.second_forms is not None
    away = np.abs(forms - mesh.second_forms[mesh.faces]).max(axis=(2, 3))
    assert 0.01 < away.max() / np.abs(forms).max() < 0.2
    inner = np.setdiff1d(np.arange(len(mesh.points)), np.unique(mesh.faces[fine.followed.any(axis=1)]))
    assert away[np.isin(mesh.faces, inner)].max() == 0.0


@pytest.mark.parametrize("spec", ["branch", "ring"])
def test_feet_of_vertices_and_of_points_above_them(spec: str) -> None:
    dataset = registry.dataset(spec)
    mesh, surface = dataset.mesh(2), dataset.surface
    assert surface is not None
    assert mesh.normals is not None
    inside = ~mesh.boundary_vertices
    above = mesh.points[inside] + 0.05 * mesh.normals[inside]
    assert norm(surface.closest(above) - mesh.points[inside]).max() < 1e-13


def test_a_network_from_a_file_is_the_one_in_it() -> None:
    mesh = registry.dataset(f"network:{DATA / 'ring.obj'}").mesh(1)
    ring = registry.dataset("ring").mesh(1)
    assert np.array_equal(mesh.points, ring.points)
    assert np.array_equal(mesh.faces, ring.faces)
    cushion = registry.dataset("network").mesh(0)
    assert (len(cushion.points), len(cushion.faces)) == (18, 32)
    assert not cushion.boundary_edges.any()
    assert registry.dataset("branch").files() == (DATA / "branch.obj",)


def test_bad_files_are_refused_in_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    for spec, text in ((f"network:{path}", "no patch is left"), (f"network:{tmp_path / 'none.obj'}", "cannot be read")):
        with pytest.raises(MeshError, match=text) as caught:
            registry.dataset(spec).mesh(0)
        assert "\n" not in str(caught.value)
    with pytest.raises(Refused, match="network has no level -1"):
        registry.dataset("network").mesh(-1)
