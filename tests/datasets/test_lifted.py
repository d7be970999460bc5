"""Bodies close above a plane: how close, which way up, and their surfaces."""

import math

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.plane_bounds import signed_distances
from testbed.geometry.vectors import norm, unit
from testbed.measures.plane_side import PlaneSide
from testbed.plugins.measure import Survey
from testbed_datasets.lifted import Lifted, turning
from testbed_datasets.torus import Torus

PLANES = ["(0 0 1 0)", "(1 2 2 0)", "(-3 0.5 1 7)", "(0 0 -2 1)"]


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("of", ["icosahedron", "torus[minor=0.4]", "ellipsoid", "ring", "mesh"])
def test_the_lowest_vertex_has_the_clearance(of: str, plane: str) -> None:
    dataset = registry.dataset(f"lifted[of={of},level=0,plane={plane},clearance=0.01]")
    assert isinstance(dataset, Lifted)
    mesh, before = dataset.mesh(0), registry.dataset(of).mesh(0)
    distances = signed_distances(dataset.plane, mesh.points)
    extent = np.ptp(before.points, axis=0).max()
    assert distances.min() == pytest.approx(0.01 * extent, abs=1e-14)
    # turned and moved, with the given direction up
    normal = np.array(dataset.plane[:3]) / math.hypot(*dataset.plane[:3])
    up = np.array(dataset.up) / math.hypot(*dataset.up)
    heights = before.points @ up
    assert np.abs(distances - distances.min() - (heights - heights.min())).max() < 1e-13 * extent
    for vertices in (np.arange(0, len(heights), 2), np.arange(1, len(heights), 3)):
        one, other = before.points[vertices], mesh.points[vertices]
        assert np.abs(norm(one - one[0]) - norm(other - other[0])).max() < 1e-13 * extent
    if mesh.normals is not None and before.normals is not None:
        assert np.abs(mesh.normals @ normal - before.normals @ up).max() < 1e-14


@pytest.mark.parametrize("of", ["icosahedron", "torus", "ellipsoid"])
def test_smooth_surfaces_reach_below_the_plane_their_vertices_are_above(of: str) -> None:
    dataset = registry.dataset(f"lifted[of={of},plane=(1 2 2 0),clearance=0.001]")
    surface = registry.scheme("shirman-sequin").fit(dataset.mesh(0))
    columns = PlaneSide((1.0, 2.0, 2.0, 0.0)).measure(Survey(surface))
    assert float(columns["plane_min"]) < 0.0


def test_finer_levels_are_of_the_same_surface() -> None:
    dataset = registry.dataset("lifted[of=torus,level=1]")
    assert dataset.surface is not None
    for level in (0, 1):
        mesh = dataset.mesh(level)
        assert len(mesh.faces) == len(Torus().mesh(level + 1).faces)
        assert norm(dataset.surface.closest(mesh.points) - mesh.points).max() < 1e-14
    assert registry.dataset("lifted[of=mesh,level=0]").surface is None


@pytest.mark.parametrize(
    "text", ["level=-1", "clearance=0", "plane=(0 0 0 1)", "up=(0 0 0)", "plane=(0 0 1e-50 1e300)"]
)
def test_parameters_that_place_nothing_are_refused(text: str) -> None:
    with pytest.raises(SpecError, match="of lifted cannot"):
        registry.dataset(f"lifted[{text}]")


def test_levels_that_the_body_does_not_have_are_refused() -> None:
    with pytest.raises(Refused, match="level 1 of lifted is level 1"):
        registry.dataset("lifted[of=mesh,level=0]").mesh(1)
    with pytest.raises(Refused, match="level -1"):
        registry.dataset("lifted").mesh(-1)


def test_turning_takes_one_direction_to_another_the_shortest_way() -> None:
    random = np.random.default_rng(0)
    starts, ends = unit(random.normal(size=(2, 200, 3)))
    ends[:50] = starts[:50]
    ends[50:100] = -starts[50:100]
    ends[100:150] = unit(-starts[100:150] + 1e-9 * random.normal(size=(50, 3)))
    for start, end in zip(starts, ends, strict=True):
        rotation = turning(start, end)
        assert np.abs(rotation @ rotation.T - np.eye(3)).max() < 1e-15 * 4
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        assert np.abs(rotation @ start - end).max() < 1e-15 * 4
        # the trace of a rotation by an angle is 1 + 2 cos
        assert np.trace(rotation) == pytest.approx(1.0 + 2.0 * start.dot(end), abs=1e-13)
