"""Gregory and Charrot's patch: tangent planes on every network, and the printed forms that fail."""

from functools import partial
from typing import Any

import numpy as np
import pytest

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron
from testbed.errors import SpecError
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import angle_between, cross, dot, norm, unit
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Scheme
from testbed.registry import catalogue
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.gregory_charrot import GregoryCharrot

ZOO = {case.name: case.mesh for case in cases(3)}
CURVES = [curve() for curve in catalogue(BoundaryCurve).values()]  # type: ignore[type-abstract]
T = np.array([1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3])
#: Samples away from the corners.
INTERIOR = lattice(3, 60)[corner_distance(3, lattice(3, 60)) > 0.0]


def jumps(surface: Surface) -> tuple[float, float]:
    """Largest angle between normals across edges in degrees, and largest gap."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
    angle = np.degrees(angle_between(left.normal, right.normal))
    return float(np.max(angle, initial=0.0)), float(np.max(norm(left.f - right.f), initial=0.0))


def de_casteljau(control: Any, t: Any) -> Any:
    """Point at t (...) of a Bezier curve (..., n + 1, 3)."""
    while control.shape[-2] > 1:
        control = (1.0 - t)[..., None, None] * control[..., :-1, :] + t[..., None, None] * control[..., 1:, :]
    return control[..., 0, :]


def on_paper(
    b0: Any, b1: Any, b2: Any, curves: Any, fields: Any, twists: Any, printed_weights: bool, other_reading: bool
) -> Any:
    """The scheme as Mann 1992 writes it, with the choice of its printed weights and of the other reading of f_{a,b}.

    ``curves`` and ``fields`` (..., 3, 2, 4, 3) of corner i: the curves to V_j and V_k, and f_k, f_j along them;
    ``twists`` (..., 3, 2, 3) their derivatives at V_i.
    """
    b, total = (b0, b1, b2), 0.0
    for i in range(3):
        bi, bj, bk = b[i], b[(i + 1) % 3], b[(i + 2) % 3]
        piece: Any = -1.0 * curves[..., i, 0, 0, :]
        for edge, (t, across) in enumerate(((bj, bk), (bk, bj))):
            field = fields[..., i, edge, :, :]
            piece = piece + de_casteljau(curves[..., i, edge, :, :], t)
            piece = piece + across[..., None] * (de_casteljau(field, t) - field[..., 0, :])
            share = t if other_reading else across
            piece = piece - (t * across * share / (bj + bk))[..., None] * twists[..., i, edge, :]
        if printed_weights:
            weight = bj * bk / (b0 * b1 + b1 * b2 + b2 * b0)
        else:
            weight = bi * bi * (3.0 - 2.0 * bi + 6.0 * bj * bk)
        total = total + weight[..., None] * piece
    return total


def paper_surface(mesh: HermiteMesh, *, printed_weights: bool = False, other_reading: bool = False) -> Surface:
    """The same over a mesh, with projected curves; f_k = k C + h X_k' from T_ik at V_i to T_jk + X_k'(1) at V_j."""
    side, normals = Projected().network(mesh).along_sides(), mesh.corner_normals()
    curves = np.stack([np.stack([side[:, i], side[:, (i + 2) % 3, ::-1]], axis=1) for i in range(3)], axis=1)
    hodographs = 3.0 * np.diff(curves, axis=3)
    fields = np.empty_like(curves)
    for i in range(3):
        for edge in range(2):
            far = (i + 1 + edge) % 3
            velocity = hodographs[:, i, edge]
            # at V_j the derivative to V_k is that of the curve onward, at V_k that to V_j of the curve back
            start, end = hodographs[:, i, 1 - edge, 0], hodographs[:, far, edge, 0] + velocity[:, 2]
            c0, c1 = unit(cross(normals[:, i], velocity[:, 0])), unit(cross(normals[:, far], velocity[:, 2]))
            k0, k1 = dot(start, c0)[:, None], dot(end, c1)[:, None]
            h0 = (dot(start, velocity[:, 0]) / dot(velocity[:, 0], velocity[:, 0]))[:, None]
            h1 = (dot(end, velocity[:, 2]) / dot(velocity[:, 2], velocity[:, 2]))[:, None]
            # cubic coefficients of k C, a product of lines raised once, and of h X', a line times a parabola
            middle = (k0 * c1 + k1 * c0) / 2.0
            product = [k0 * c0, (k0 * c0 + 2.0 * middle) / 3.0, (2.0 * middle + k1 * c1) / 3.0, k1 * c1]
            along = [
                h0 * velocity[:, 0],
                (2.0 * h0 * velocity[:, 1] + h1 * velocity[:, 0]) / 3.0,
                (h0 * velocity[:, 2] + 2.0 * h1 * velocity[:, 1]) / 3.0,
                h1 * velocity[:, 2],
            ]
            fields[:, i, edge] = np.stack(product, axis=1) + np.stack(along, axis=1)
    twists = 3.0 * (fields[:, :, :, 1] - fields[:, :, :, 0])
    formula = partial(on_paper, printed_weights=printed_weights, other_reading=other_reading)
    data = {"curves": curves, "fields": fields, "twists": twists}
    legs = hodographs[:, :, :, 0]
    return Surface.over_faces(mesh, BlendedTriangles(formula, data, mesh.corner_points(), legs))


@pytest.mark.parametrize("mesh", [octahedron(), perturbed_icosahedron(), ZOO["coarse torus"]])
def test_the_surface_is_the_one_on_paper(mesh: HermiteMesh) -> None:
    found, expected = (
        surface.batches[0].jets(INTERIOR).coefficients for surface in (GregoryCharrot().fit(mesh), paper_surface(mesh))
    )
    np.testing.assert_allclose(found, expected, atol=1e-11)


def test_the_printed_weights_tear_the_surface() -> None:
    """They are 1 on the edge that P_i does not interpolate."""
    angle, gap = jumps(paper_surface(octahedron()))
    assert angle < 1e-12
    assert gap < 1e-15
    angle, gap = jumps(paper_surface(octahedron(), printed_weights=True))
    assert angle == pytest.approx(45.898, abs=1e-3)
    assert gap == pytest.approx(0.4393, abs=1e-4)


def test_the_other_reading_of_the_mixed_partials_breaks_tangent_planes() -> None:
    """f_{a,b} as the derivative of f_a with respect to w_b."""
    angle, gap = jumps(paper_surface(octahedron(), other_reading=True))
    assert angle == pytest.approx(26.525, abs=1e-3)
    assert gap < 1e-15
    assert jumps(paper_surface(perturbed_icosahedron(), other_reading=True))[0] == pytest.approx(19.437, abs=1e-3)


@pytest.mark.parametrize("boundary", CURVES, ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_tangent_planes_agree_on_every_network(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for jensen_c in (1.0, 1.234):
        angle, gap = jumps(GregoryCharrot(boundary, jensen_c).fit(mesh))
        assert angle < 1e-9
        assert gap < 1e-14 * (1.0 + np.abs(mesh.points).max())


@pytest.mark.parametrize(
    ("scheme", "gauss_range"),
    [(GregoryCharrot(), (0.3587, 2.6800)), (GregoryCharrot(Hermite(), 1.234), (0.8670, 1.0359))],
    ids=str,
)
def test_octahedron(scheme: Scheme, gauss_range: tuple[float, float]) -> None:
    """To what we measure; no values are on record."""
    K = gauss(scheme.fit(octahedron()).batches[0].jets(INTERIOR))
    np.testing.assert_allclose((K.min(), K.max()), gauss_range, atol=1e-4)


def test_jensens_c_is_finite() -> None:
    with pytest.raises(SpecError, match="jensen_c"):
        GregoryCharrot(jensen_c=float("inf"))
