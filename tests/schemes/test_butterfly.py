"""The butterfly and the modified butterfly: stencils, polynomials reproduced, smoothness of the limit, boundaries."""

from collections.abc import Callable

import numpy as np
import pytest
from spoked_meshes import lattice, turns_at_the_hub

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.surface import Surface
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, norm
from testbed.plugins.scheme import Scheme
from testbed_schemes import modified_butterfly
from testbed_schemes.butterfly import Butterfly
from testbed_schemes.mathematics.butterfly_stencil import edge_vertices
from testbed_schemes.modified_butterfly import ModifiedButterfly

BOTH = [Butterfly, ModifiedButterfly]


def vertices_of(surface: Surface) -> Float:
    return np.asarray(surface.batches[0].control_points.reshape(-1, 3))  # type: ignore[attr-defined]


@pytest.mark.parametrize(("scheme", "radius"), [(Butterfly(5), 0.8323), (ModifiedButterfly(5), 0.8310)])
def test_the_octahedron_after_five_steps(scheme: Scheme, radius: float) -> None:
    surface = scheme.fit(registry.dataset("octahedron").mesh(0))
    assert surface.patch_count == 8 * 4**5
    assert norm(vertices_of(surface)).min() == pytest.approx(radius, abs=5e-5)
    assert norm(vertices_of(surface)).max() == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("kind", BOTH)
def test_new_vertices_have_new_ids_and_old_ones_keep_place_and_id(kind: type[Butterfly | ModifiedButterfly]) -> None:
    mesh = registry.dataset("graph").mesh(0)
    surface = kind(2).fit(mesh)
    (part,) = surface.parts
    corners = part.batch.control_points  # type: ignore[attr-defined]
    old = part.corner_ids < len(mesh.points)
    assert np.array_equal(corners[old], mesh.points[part.corner_ids[old]])
    assert set(part.corner_ids[old].tolist()) == set(range(len(mesh.points)))
    assert (np.bincount(part.faces) == 16).all()


def test_the_stencil_is_the_published_one() -> None:
    places, triangles = lattice(4, 4)
    faces = Triangulation(triangles, len(places))
    # an edge in the middle, and the weights that each vertex has in its new vertex
    edge = int(np.nonzero((faces.edges == [12, 17]).all(axis=1))[0][0])
    for rule, w in (
        (lambda p: edge_vertices(faces, p, faces.half_edge, 0.03), 0.03),
        (modified_rule(faces), 1.0 / 16.0),
    ):
        weights = np.array([rule(unit_vector(vertex, len(places)))[edge, 0] for vertex in range(len(places))])
        far = norm3(places - places[[12, 17]].mean(axis=0))
        expected = np.select(
            [np.isclose(far, 0.5), np.isclose(far, np.sqrt(0.75)), np.isclose(far, np.sqrt(1.75))], [0.5, 2.0 * w, -w]
        )
        assert np.allclose(weights, expected, atol=1e-15)
        assert (expected < 0.0).sum() == 4


def modified_rule(faces: Triangulation) -> Callable[[Float], Float]:
    return lambda points: modified_butterfly.edge_vertices(faces, points)


def unit_vector(vertex: int, count: int) -> Float:
    points = np.zeros((count, 3))
    points[vertex] = 1.0
    return points


def norm3(vectors: Float) -> Float:
    return np.asarray(np.hypot(vectors[:, 0], vectors[:, 1]))


def cubic(x: Float, y: Float) -> Float:
    return np.asarray(0.3 * x**3 - 0.2 * x**2 * y + 0.1 * x * y**2 - 0.25 * y**3 + x * y - 2.0 * x + 1.0)


@pytest.mark.parametrize("modified", [False, True])
def test_cubics_are_reproduced_inside_regular_triangulations(modified: bool) -> None:
    places, triangles = lattice(8, 8)
    x, y = places.T
    faces = Triangulation(triangles, len(places))
    points = np.stack([x, y, cubic(x, y)], axis=-1)
    new = modified_rule(faces)(points) if modified else edge_vertices(faces, points, faces.half_edge, 1.0 / 16.0)
    # away from the boundary
    inner = (~faces.on_boundary[faces.edges]).all(axis=1)
    assert np.abs(cubic(new[inner, 0], new[inner, 1]) - new[inner, 2]).max() < 1e-12


@pytest.mark.parametrize("modified", [False, True])
@pytest.mark.parametrize("shape", [(4, 4), (5, 1), (2, 2)])
def test_regular_boundaries_keep_linear_functions(modified: bool, shape: tuple[int, int]) -> None:
    places, triangles = lattice(*shape)
    faces = Triangulation(triangles, len(places))
    points = np.concatenate([places, places @ np.array([[0.7], [-0.4]])], axis=1)
    new = modified_rule(faces)(points) if modified else edge_vertices(faces, points, faces.half_edge, 1.0 / 16.0)
    # the four-point rule turns the corners; vertices of the boundary with three faces, and those inside, are regular
    regular = (faces.face_count == np.where(faces.on_boundary, 3, 6))[faces.edges].all(axis=1)
    near_corner = np.zeros(len(regular), dtype=bool)
    bounding = faces.twin[faces.half_edge] < 0
    straight = faces.face_count == np.where(faces.on_boundary, 3, 6)
    half_edge = faces.half_edge[bounding]
    near_corner[bounding] = ~(straight[faces.start[half_edge]] & straight[faces.end[half_edge]])
    chosen = regular & ~near_corner
    assert chosen.any()
    assert norm(new[chosen] - points[faces.edges[chosen]].mean(axis=1)).max() < 1e-14


@pytest.mark.parametrize("valence", [3, 10, 12])
def test_the_limit_of_the_butterfly_is_not_smooth_at_low_and_high_valences(valence: int) -> None:
    turns = turns_at_the_hub(Butterfly, valence)
    assert turns[-1] > 0.8 * turns[0]


@pytest.mark.parametrize("kind", BOTH)
def test_facets_join_on_open_meshes_and_support_is_two_rings(kind: type[Butterfly | ModifiedButterfly]) -> None:
    surface = kind(3).fit(registry.dataset("monkey-saddle").mesh(0))
    inner = surface.edges[surface.edges.interior]
    one, other = surface.edge_jets(inner, np.array([0.0, 0.4, 1.0]), 0)
    assert norm(one.f - other.f).max() < 1e-15
    assert [kind(depth).support for depth in range(4)] == [0, 1, 2, 2]


@pytest.mark.parametrize("kind", BOTH)
def test_depths_and_sizes_are_bounded(kind: type[Butterfly | ModifiedButterfly]) -> None:
    with pytest.raises(SpecError, match="depth must be between 0 and 7"):
        kind(8)
    with pytest.raises(Refused, match="lower the depth"):
        kind(7).fit(registry.dataset("torus").mesh(1))
