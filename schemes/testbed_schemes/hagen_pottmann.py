"""Hagen and Pottmann's G2 scheme (Hagen and Pottmann 1989; Mann 1992, section 2.3.2): a blended patch a face.

Matches position, normal and second fundamental form at the vertices; neighbours share boundary curves, the normals and
the second fundamental forms along them, so the surface is G2. The boundary curves are the scheme's own. Towards a
vertex the curvature goes to that of the data, from every direction.

It is Nielson's scheme with curvature. A curve operator g_v joins two points with normals and second forms by a quintic

    H_5[V_0, V_1, V_0', V_1', V_0'', V_1''],   V' = lambda T,   V'' = lambda^2 kappa N + mu V',

with unit tangents T along the projected chord and kappa = -II(T, T) in the sign of this package. On each side of the
face stands such a curve X(s) with a field of tangent planes and second forms
(:mod:`testbed_schemes.continuity_conditions.hagen_pottmann`); each of its points is joined to the opposite vertex by
another. The three patches G_i, of which each has the three boundary curves and the fields of its own side, are blended:

    beta_i = b_j^2 b_k^2 / (b_0^2 b_1^2 + b_1^2 b_2^2 + b_2^2 b_0^2).   (2.14)

As 1 - beta_i vanishes with the square of the distance from side i, and the G agree there, the blend has the second
derivatives of G_i on side i.

Formulas: the blend and the form of g_v as printed. lambda is free there; the chord's length and that of an arc are
fills, and so are the fields, which are described in words. V'' is printed with kappa = <N, C''> / |C'|^2, of the sign
opposite to II in the same source; here II(T, T) enters with a minus. mu is printed as the length of a part along the
unit tangent; here it is relative to lambda, so that the surface scales with the data, and counts away from the vertex.
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, dot, norm, quadratic_form, tangential
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.continuity_conditions.hagen_pottmann import (
    CurvatureField,
    EndField,
    curvature_field,
    end_field,
)
from testbed_schemes.planar_frame import PARALLEL, edge_normals, edge_second_forms
from testbed_schemes.side_vertex import CORNER_MARGIN, Deviation, J, K

#: Least cosine of the angle between a chord and its projection: computed from the sine, it has lost half of its digits
#: here, and all of them at the square.
SHADOW = 1e-4
#: Halvings of the angle between chord and tangent, to at most 5.6 degrees, before arcsin's series, and the ratios of
#: the coefficients of that: (2 m - 1)^2 / (2 m (2 m + 1)).
HALVINGS, SERIES = 4, (1 / 6, 9 / 20, 25 / 42, 49 / 72, 81 / 110, 121 / 156, 169 / 210)
#: Parameters at which the normals along an edge are looked at before patches are built.
LOOKS = np.arange(17) / 16.0

Tangents: TypeAlias = Literal["chord", "arc"]


@dataclass(frozen=True)
class HagenPottmann(Scheme):
    """Hagen and Pottmann's curvature continuous scheme.

    Parameters
    ----------
    tangents
        lambda, the length of all tangents: ``chord``, the chord's length L, or ``arc``, that of a circular arc,
        L phi / sin phi with phi the angle between tangent and chord.
    mu
        Acceleration along the curves at their ends, away from the end, in units of the tangent there; planes keep their
        linear parametrisation at 0 only.

    Raises
    ------
    SpecError
        ``mu`` is not finite.
    """

    tangents: Tangents = "chord"
    mu: float = 0.0

    name = "hagen-pottmann"
    title = "Hagen-Pottmann"
    reference = "Hagen and Pottmann 1989; Mann 1992, section 2.3.2"
    formula = (
        "sum beta_i G_i, G_i quintic curves from vertex i to the opposite side, which carries a quintic curve with a "
        "field of tangent planes and second forms; beta_i = b_j^2 b_k^2 / (b_0^2 b_1^2 + b_1^2 b_2^2 + b_2^2 b_0^2)"
    )
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    continuity = Continuity.G2
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the parameter."""
        if not np.isfinite(self.mu):
            raise SpecError(f"{self.name}: mu must be finite, and here it is {self.mu}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one blended patch a face."""
        leaving, arriving = self.edge_tangents(mesh)
        check_corners(self, mesh, leaving, -arriving)
        check_sides(self, mesh, leaving, -arriving)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        assert mesh.second_forms is not None  # noqa: S101 - needed, and checked before
        forms = mesh.second_forms[mesh.faces]
        # tangents at corner i towards corners i + 1 and i + 2
        to_j, to_k = points[:, J] - points, points[:, K] - points
        legs = np.stack([tangent(chord, normals, self.tangents) for chord in (to_j, to_k)], axis=2)
        data = {"points": points, "normals": normals, "forms": forms, "to_j": to_j, "to_k": to_k}
        data["side"], data["ends"], data["across"] = side_data(
            points[:, K] - points[:, J],
            (normals[:, J], normals[:, K]),
            (forms[:, J], forms[:, K]),
            (legs[:, J, 0], -legs[:, K, 1]),
            self.mu,
        )
        formula = partial(hagen_pottmann_patch, tangents=self.tangents, mu=self.mu)
        return Surface.over_faces(mesh, BlendedTriangles(formula, data, points, legs, CORNER_MARGIN))

    def edge_tangents(self, mesh: HermiteMesh) -> tuple[Float, Float]:
        """Return the tangents of g_v at both ends of the edges, (E, 3) each, as the edges run.

        Refused if there are edges on which the operator or the tangent planes are not defined; the message names the
        first one's vertices.
        """
        edges = mesh.edge_data
        chord, normals, forms = edges.p1 - edges.p0, edge_normals(edges), edge_second_forms(edges)
        shadow = np.minimum(*(norm(tangential(chord, normal)) for normal in normals))
        undefined: Bool = np.asarray(~(shadow > SHADOW * norm(chord)))
        self.refuse(mesh, undefined, "is parallel to the normal at one of its ends")
        tangents = tangent(chord, normals[0], self.tangents), tangent(chord, normals[1], self.tangents)

        def turns(some: slice) -> Float:
            (n0, n1), (W0, W1), (t0, t1) = ((a[some], b[some]) for a, b in (normals, forms, tangents))
            data = side_data(chord[some], (n0, n1), (W0, W1), (t0, t1), self.mu)
            side, ends, across = (values[:, None] for values in data)
            normal = side_field(side, ends, across, LOOKS, LOOKS[::-1]).normal
            least = norm(normal).min(axis=1) - PARALLEL * norm(chord[some])
            # between parameters so near each other, normals that differ by a right angle have vanished or turned over
            turning = dot(normal[:, 1:], normal[:, :-1]).min(axis=1)
            return np.asarray(np.minimum(least, turning))

        folds: Bool = np.asarray(~(in_blocks(turns, len(chord)) > 0.0))
        self.refuse(mesh, folds, "has no field of tangent planes, because its curve or the planes turn too far")
        return tangents

    def refuse(self, mesh: HermiteMesh, unfit: Bool, why: str) -> None:
        """Raise Refused if any edge (E,) is unfit."""
        if unfit.any():
            i, j = mesh.edges[unfit][0].tolist()
            raise Refused(
                f"{self} takes no edge that {why}: the edge from vertex {i} to vertex {j}, the first of "
                f"{int(unfit.sum())}; check the normals and second fundamental forms"
            )


def side_data(
    chord: Float, normals: tuple[Float, Float], forms: tuple[Float, Float], tangents: tuple[Float, Float], mu: float
) -> tuple[Float, Float, Float]:
    """Return what a side's curve and fields are made of, from the data at its two ends.

    Parameters
    ----------
    chord
        (..., 3) from the first end to the second.
    normals, forms, tangents
        (..., 3), (..., 3, 3) and (..., 3) at the first and at the second end; the tangents as the curve runs.
    mu
        The parameter of the scheme.

    Returns
    -------
    side
        (..., 5, 3): chord, X'(0), X'(1), X''(0), X''(1).
    ends
        (..., 4, 3): D(0), D(1), D'(0), D'(1).
    across
        (..., 2): II(D, D) at the ends.
    """
    bends = [
        # kappa = -II(T, T): the curve bends to where the normal points if the surface is curved negatively
        sign * mu * t - quadratic_form(t, W, t)[..., None] * n
        for sign, t, W, n in zip((1.0, -1.0), tangents, forms, normals, strict=True)
    ]
    ends = [end_field(n, t, W) for n, t, W in zip(normals, tangents, forms, strict=True)]
    side = np.stack([chord, *tangents, *bends], axis=-2)
    fields = np.stack([*(end.across for end in ends), *(end.turn for end in ends)], axis=-2)
    return side, fields, np.stack([end.curvature for end in ends], axis=-1)


def side_field(side: Float, ends: Float, across: Float, s: Float, rest: Float) -> CurvatureField:
    """Return the fields of :func:`side_data` at ``s`` = 1 - ``rest``."""
    first, last = (EndField(ends[..., i, :], ends[..., 2 + i, :], across[..., i]) for i in range(2))
    return curvature_field(*quintic_derivatives(side, s, rest), first, last, s, rest)


def hagen_pottmann_patch(
    b0: Float,
    b1: Float,
    b2: Float,
    points: Float,
    normals: Float,
    forms: Float,
    to_j: Float,
    to_k: Float,
    side: Float,
    ends: Float,
    across: Float,
    tangents: Tangents,
    mu: float,
) -> Float:
    """Points (..., 3) of the patch.

    Parameters
    ----------
    points, normals, forms
        (..., 3, 3) vertices and normals, (..., 3, 3, 3) second fundamental forms.
    to_j, to_k
        (..., 3, 3) chords from each vertex to the next two.
    side, ends, across
        :func:`side_data` of the side opposite to each vertex.
    """

    def deviation(r: Float, rest: Float, s: Float, rest_s: Float) -> Float:
        # the side's point, seen from the flat side and from the vertex, and the fields there
        off_side = quintic_deviation(side, s, rest_s)
        chord = rest_s[..., None] * to_j + s[..., None] * to_k + off_side
        field = side_field(side, ends, across, s, rest_s)
        # the curve to it has tangents k (chord - height n), and normal parts -k^2 II n of second derivatives
        square, height0, height1 = (np.vecdot(chord, a) for a in (chord, normals, field.normal))
        k0, k1 = (stretch(sine2, tangents) for sine2 in (height0**2 / square, height1**2 / (square * field.square)))
        form0 = np.vecdot(chord, np.einsum("...ij,...j->...i", forms, chord))
        along, first, last, bend0, bend1 = quintic_weights(r, rest, mu)
        first, last = k0 * first, k1 * last
        normal_part0 = first * height0 + bend0 * k0**2 * form0
        normal_part1 = last * height1 / field.square - bend1 * k1**2 * field.second_form(chord) / np.sqrt(field.square)
        result: Float = (
            r[..., None] * off_side
            + (along + first - last)[..., None] * chord
            - normal_part0[..., None] * normals
            + normal_part1[..., None] * field.normal
        )
        return result

    return curvature_blend(deviation, points, b0, b1, b2)


def curvature_blend(deviation: Deviation, points: Float, b0: Float, b1: Float, b2: Float) -> Float:
    """Blend three patches as :func:`testbed_schemes.side_vertex.side_vertex_blend` does, with the squares of (2.14)."""
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    products, r = (bj * bk) ** 2, bj + bk
    shares = products / products.sum(axis=-1, keepdims=True)
    blended = shares[..., None] * deviation(r, bi, bk / r, bj / r)
    result: Float = np.sum(bi[..., None] * points, axis=-2) + np.sum(blended, axis=-2)
    return result


def tangent(chord: Float, normal: Float, tangents: Tangents) -> Float:
    """Tangents (..., 3) of g_v: the chord projected onto the tangent plane, made as long as ``tangents`` says."""
    height, square = dot(chord, normal), dot(chord, chord)
    return stretch(height**2 / square, tangents)[..., None] * tangential(chord, normal)


def stretch(sine2: Float, tangents: Tangents) -> Float:
    """Factor (...) on the projected chord, from the square of the sine of its angle phi with the chord.

    1 / cos phi makes it as long as the chord. The arc's phi / (sin phi cos phi) needs care at phi = 0: by Viete,
    phi / sin phi is the product of 1 / cos(phi / 2^m) over some halvings, times theta / sin theta of the angle theta
    that is left; that is a power series of arcsin in sin^2 theta.
    """
    cosine = np.sqrt(1.0 - sine2)
    product = cosine
    if tangents == "chord":
        return 1.0 / product
    for _ in range(HALVINGS):
        sine2 = 0.5 * sine2 / (1.0 + cosine)
        cosine = np.sqrt(1.0 - sine2)
        product = product * cosine
    series: Float = 1.0 + sine2 * SERIES[-1]
    for ratio in SERIES[-2::-1]:
        series = 1.0 + series * sine2 * ratio
    return series / product


def quintic_weights(t: Float, rest: Float, mu: float) -> tuple[Float, Float, Float, Float, Float]:
    """Weights (...) in the quintic Hermite curve's deviation from its chord, at ``t`` = 1 - ``rest``.

    Of the chord, of the first tangent and, subtracted, of the last, each with ``mu`` times itself as the tangential
    part of its second derivative, and of the normal parts of both second derivatives.
    """
    product = t * rest
    square = product**2
    bend0, bend1 = 0.5 * square * rest, 0.5 * square * t
    along = product * (t - rest) * (1.0 + 3.0 * product)
    first, last = product * rest**2 * (rest + 4.0 * t), product * t**2 * (t + 4.0 * rest)
    return along, first + mu * bend0, last + mu * bend1, bend0, bend1


def quintic_deviation(side: Float, t: Float, rest: Float) -> Float:
    """How far the quintic Hermite curve of :func:`side_data` is from its chord at ``t`` = 1 - ``rest``, (..., 3)."""
    along, first, last, bend0, bend1 = quintic_weights(t, rest, 0.0)
    return combined(side, (along, first, -last, bend0, bend1))


def quintic_derivatives(side: Float, t: Float, rest: Float) -> tuple[Float, Float]:
    """First and second derivatives of the same curve, (..., 3) each."""
    product = t * rest
    first = (
        30.0 * product**2,
        rest**2 * (rest - 2.0 * t) * (rest + 6.0 * t),
        t**2 * (t - 2.0 * rest) * (t + 6.0 * rest),
        0.5 * product * rest * (2.0 * rest - 3.0 * t),
        0.5 * product * t * (3.0 * rest - 2.0 * t),
    )
    second = (
        60.0 * product * (rest - t),
        -12.0 * product * (3.0 * rest - 2.0 * t),
        12.0 * product * (3.0 * t - 2.0 * rest),
        rest * (rest**2 - 6.0 * product + 3.0 * t**2),
        t * (t**2 - 6.0 * product + 3.0 * rest**2),
    )
    return combined(side, first), combined(side, second)


def combined(side: Float, weights: tuple[Float, ...]) -> Float:
    """Sum of the rows of ``side`` (..., n, 3), weighted (...), one after the other."""
    total: Float = weights[0][..., None] * side[..., 0, :]
    for row, weight in enumerate(weights[1:], start=1):
        total = total + weight[..., None] * side[..., row, :]
    return total
