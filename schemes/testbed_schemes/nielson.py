"""Nielson's side-vertex method for points and normals (Nielson 1987; Mann 1992, section 2.3.2): a blended patch a face.

Matches position and normal at the vertices; neighbours share boundary curves and the normals along them, so the surface
is G1. The boundary curves are the scheme's own. At the vertices the curvature depends on the direction.

A curve operator g_v joins two points with normals by a cubic whose end tangents are perpendicular to the normals, and a
normal operator g_n gives normals along it. On each side of the face stands a curve; each of its points is joined to the
opposite vertex by another. Both are built by g_v, the second with the normals of g_n:

    G_i = g_v[V_i, N_i, g_v[V_j, N_j, V_k, N_k](s), g_n(s)](b_j + b_k),   s = b_k / (b_j + b_k).

The three patches G_i interpolate all sides, each the tangent planes of its own; they are blended with (2.12).

Formulas: the construction as printed. The operators, which the thesis only describes, are filled in: tangents of g_v
along the projected chord, and g_n perpendicular to the curve's tangent and to a cross-boundary vector that is linear
between N_j x X'(0) and N_k x X'(1). That g_n is perpendicular to X' is not said there; the second property needs it.
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm, tangential, unit
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.planar_frame import PARALLEL, edge_normals, projected_tangents
from testbed_schemes.side_vertex import CORNER_MARGIN, hermite_derivative, hermite_deviation, side_vertex_blend

Tangents: TypeAlias = Literal["chord", "circular"]


@dataclass(frozen=True)
class Nielson(Scheme):
    """Nielson's side-vertex method.

    Parameters
    ----------
    fullness
        Factor on the length of all tangents; planes keep their linear parametrisation at 1 only.
    tangents
        Length of the tangents before the factor: ``chord``, the chord's length L, or ``circular`` (not Nielson's), that
        of a circular arc, 2 L / (1 + c) with c the cosine of the angle between tangent and chord.

    Raises
    ------
    SpecError
        ``fullness`` is not positive and finite.
    """

    fullness: float = 1.0
    tangents: Tangents = "chord"

    name = "nielson"
    title = "Nielson"
    reference = "Nielson 1987; Mann 1992, section 2.3.2"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the parameter."""
        if not 0.0 < self.fullness < np.inf:
            raise SpecError(f"{self.name}: fullness must be positive and finite, and here it is {self.fullness}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one blended patch a face."""
        check_edges(mesh, self.fullness, self.tangents)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        formula = partial(nielson_patch, fullness=self.fullness, tangents=self.tangents)
        # tangents at corner i towards corners i + 1 and i + 2
        ends = np.stack([np.roll(points, -1, axis=1), np.roll(points, -2, axis=1)], axis=2)
        legs = tangent(ends - points[:, :, None], normals[:, :, None], self.fullness, self.tangents)
        data = {"points": points, "normals": normals, "legs": legs}
        return Surface.over_faces(mesh, BlendedTriangles(formula, data, points, legs, CORNER_MARGIN))


def nielson_patch(
    b0: Float, b1: Float, b2: Float, points: Float, normals: Float, legs: Float, fullness: float, tangents: Tangents
) -> Float:
    """Points (..., 3) of the patch from vertices and normals (..., 3, 3) and its corner tangents (..., 3, 2, 3)."""

    def deviation(i: int, r: Float, rest: Float, s: Float, rest_s: Float) -> Float:
        j, k = (i + 1) % 3, (i + 2) % 3
        side = points[..., k, :] - points[..., j, :]
        leaving, arriving = legs[..., j, 0, :], -legs[..., k, 1, :]
        # the side's point, seen from the flat side and from the vertex, and its normal
        off_side = hermite_deviation(side, leaving, arriving, s, rest_s)
        to_j, to_k = points[..., j, :] - points[..., i, :], points[..., k, :] - points[..., i, :]
        chord = rest_s[..., None] * to_j + s[..., None] * to_k + off_side
        normal = unit(side_normal(side, leaving, arriving, normals[..., j, :], normals[..., k, :], s, rest_s))
        # the curve to it
        start, end = (tangent(chord, n, fullness, tangents) for n in (normals[..., i, :], normal))
        return r[..., None] * off_side + hermite_deviation(chord, start, end, r, rest)

    return side_vertex_blend(deviation, points, b0, b1, b2)


def side_normal(
    side: Float, leaving: Float, arriving: Float, normal0: Float, normal1: Float, s: Float, rest_s: Float
) -> Float:
    """Normals (..., 3) of g_n, not of length one: X'(s) x ((1 - s) N_j x X'(0) + s N_k x X'(1))."""
    across = rest_s[..., None] * cross(normal0, leaving) + s[..., None] * cross(normal1, arriving)
    return cross(hermite_derivative(side, leaving, arriving, s, rest_s), across)


def tangent(chord: Float, normal: Float, fullness: float, tangents: Tangents) -> Float:
    """Tangents (..., 3) of g_v: the chord projected onto the tangent plane, made as long as ``tangents`` says."""
    projected = tangential(chord, normal)
    length, shadow = norm(chord), norm(projected)
    if tangents == "chord":
        factor = fullness * length / shadow
    else:
        # the unit tangent is projected / shadow, and c = shadow / length
        factor = 2.0 * fullness * length * length / (shadow * (length + shadow))
    return factor[..., None] * projected


def check_edges(mesh: HermiteMesh, fullness: float, tangents: Tangents) -> None:
    """Refuse a mesh with edges on which the operators are not defined; the message names the first one's vertices."""
    edges = mesh.edge_data
    chord, (n0, n1) = edges.p1 - edges.p0, edge_normals(edges)
    (t0, t1), length = projected_tangents(chord, n0, n1)
    undefined: Bool = np.asarray(~np.isfinite(t0 + t1).all(axis=1))
    refuse(mesh, undefined, "is parallel to the normal at one of its ends")
    leaving, arriving = tangent(chord, n0, fullness, tangents), tangent(chord, n1, fullness, tangents)
    half = np.full(len(chord), 0.5)
    middle = side_normal(chord, leaving, arriving, n0, n1, half, half)
    vanishes: Bool = np.asarray(~(norm(middle) > PARALLEL * length**2))
    refuse(mesh, vanishes, "has no normal half-way, where those of its ends cancel out")


def refuse(mesh: HermiteMesh, unfit: Bool, why: str) -> None:
    """Raise Refused if any edge (E,) is unfit."""
    if unfit.any():
        i, j = mesh.edges[unfit][0].tolist()
        raise Refused(
            f"{Nielson.name} takes no edge that {why}: the edge from vertex {i} to vertex {j}, the first of "
            f"{int(unfit.sum())}; check the normals"
        )
