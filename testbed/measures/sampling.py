"""Samples of a surface that several measures share: points, normals, curvatures, area elements, evaluated once.

The sample points of a patch are a regular lattice, its boundary included, for the extremes, and the points of a
quadrature rule for the means. The lattice is finer where there are fewer patches; the rule is the same at every level,
so that means at different levels compare. Extremes of the samples are where :mod:`testbed.measures.extremum` starts.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from testbed.geometry.curvature import analyse
from testbed.geometry.domain import CORNERS, corner_distance, lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm
from testbed.plugins.measure import Survey

#: Samples evaluated at once; a bound on memory, without influence on the results.
CHUNK = 16384
#: Coarsest and finest sample lattice, in steps a side.
STEPS = (3, 12)
#: Symmetric rule of degree 6 on the triangle (Dunavant 1985): weight of a point and its first two coordinates, each
#: with the permutations of its barycentric coordinates; the weights of all 12 points add up to 1.
TRIANGLE_RULE = (
    (0.1167862757263793660252896, 0.2492867451709104212916385, 0.2492867451709104212916385),
    (0.0508449063702068169209368, 0.0630890144915022283403316, 0.0630890144915022283403316),
    (0.0828510756183735751935534, 0.0531450498448169473532497, 0.3103524510337844054166077),
)


@dataclass(frozen=True)
class SamplePoints:
    """Where the patches over one domain are sampled.

    Parameters
    ----------
    at
        (S, 2) domain points.
    weights
        (S,) quadrature weights, adding up to 1; zero at points that are not of the rule.
    curved
        (S,) true at the points where second derivatives are looked at.
    """

    at: Float
    weights: Float
    curved: Bool


@dataclass(frozen=True)
class PatchSamples:
    """Samples of the patches of one part of a surface.

    Parameters
    ----------
    points_at
        Where the patches are sampled.
    points
        (P, S, 3) points.
    normals
        (P, S, 3) unit normals; NaN where the parametrisation is singular.
    area
        (P, Q) area elements |f_u x f_v| at the Q points of the quadrature rule, which come first.
    gauss, mean
        (P, C) curvatures at the C points of ``points_at`` that are ``curved``.
    """

    points_at: SamplePoints
    points: Float
    normals: Float
    area: Float
    gauss: Float
    mean: Float


def quadrature(sides: int) -> tuple[Float, Float]:
    """Points (Q, 2) and weights (Q,), adding up to 1, of the rule on a domain: degree 6 on triangles, 7 on squares."""
    if sides == 4:
        nodes, weights = np.polynomial.legendre.leggauss(4)
        u, v = np.meshgrid(0.5 + 0.5 * nodes, 0.5 + 0.5 * nodes, indexing="ij")
        return np.stack([u.ravel(), v.ravel()], axis=-1), 0.25 * np.outer(weights, weights).ravel()
    points, weight = [], []
    for value, a, b in TRIANGLE_RULE:
        c = 1.0 - a - b
        orbit = dict.fromkeys([(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)])
        if a == b:
            orbit = dict.fromkeys([(a, b), (b, c), (c, a)])
        points += list(orbit)
        weight += [value] * len(orbit)
    return np.array(points), np.array(weight)


def lattice_steps(patches: int, sides: int, budget: int) -> int:
    """Return the steps of the sample lattice: the most within ``STEPS`` that keep all samples within the budget."""
    rule = len(quadrature(sides)[1])
    fitting = [
        steps for steps in range(STEPS[0], STEPS[1] + 1) if patches * (len(lattice(sides, steps)) + rule) <= budget
    ]
    return max(fitting, default=STEPS[0])


def sample_points(sides: int, corner_margin: float, steps: int, collapsed: tuple[int, ...] = ()) -> SamplePoints:
    """Return the sample points of a domain.

    With a corner margin, second derivatives are not looked at nearer to a corner than that; on the margin they are
    looked at in three directions from each corner, because the curvature of blended patches depends on the direction.
    Likewise along sides that are collapsed to a point.
    """
    nodes, weights = quadrature(sides)
    at = np.concatenate([nodes, lattice(sides, steps)])
    if corner_margin > 0.0:
        at = np.concatenate([at, _margin_points(sides, corner_margin, collapsed)])
    curved = corner_distance(sides, at, collapsed) >= corner_margin * (1.0 - 1e-9)
    return SamplePoints(at, np.concatenate([weights, np.zeros(len(at) - len(weights))]), curved)


def _margin_points(sides: int, margin: float, collapsed: tuple[int, ...]) -> Float:
    """Points at corner distance ``margin`` on both sides of each corner and between them, (3 sides, 2).

    Beside collapsed sides the corners count as one: points at three places along each, (3 sides collapsed, 2).
    """
    corners = CORNERS[sides]
    if collapsed:
        ahead = np.roll(corners, -1, axis=0) - corners
        along = np.array([[0.0], [0.5], [1.0]])
        # the next side of a square leads straight away from a side
        inward = [corners[side] + margin * ahead[(side + 1) % sides] + along * ahead[side] for side in collapsed]
        return np.concatenate(inward)
    forward, back = np.roll(corners, -1, axis=0) - corners, np.roll(corners, 1, axis=0) - corners
    between = 0.5 * (forward + back) if sides == 3 else forward + back
    return np.concatenate([corners + margin * direction for direction in (forward, between, back)])


def chunks(patches: int, samples: int) -> Iterator[slice]:
    """Divide a batch into slices of at most ``CHUNK`` samples, or one patch."""
    step = max(1, CHUNK // max(1, samples))
    return (slice(start, min(start + step, patches)) for start in range(0, patches, step))


def samples_per_patch(surface: Surface, budget: int) -> int:
    """Sample points of a patch; the largest number where parts differ."""
    return max(len(points.at) for points in _points_of_parts(surface, budget))


def _points_of_parts(surface: Surface, budget: int) -> list[SamplePoints]:
    count = surface.patch_count
    return [
        sample_points(batch.sides, batch.corner_margin, lattice_steps(count, batch.sides, budget), batch.collapsed)
        for batch in surface.batches
    ]


def sample(survey: Survey, budget: int) -> tuple[PatchSamples, ...]:
    """Sample every part of a surface; ask for it as ``survey.shared(sample, budget)``."""
    return tuple(
        _sample_part(batch, points)
        for batch, points in zip(survey.surface.batches, _points_of_parts(survey.surface, budget), strict=True)
    )


def _sample_part(batch: PatchBatch, where: SamplePoints) -> PatchSamples:
    patches, count = len(batch), len(where.at)
    points, normals = np.empty((2, patches, count, 3))
    rule = np.count_nonzero(where.weights)
    area = np.empty((patches, rule))
    gauss, mean = np.empty((2, patches, np.count_nonzero(where.curved)))
    for some in chunks(patches, count):
        jet = batch.take(some).jets(where.at, 2)
        # a singular parametrisation, or a patch that is not finite, has no normal and no curvature: NaN, which the
        # extremes propagate
        with np.errstate(invalid="ignore", over="ignore"):
            analysis = analyse(jet)
            area[some] = norm(cross(jet.fu[:, :rule], jet.fv[:, :rule]))
        points[some], normals[some] = jet.f, analysis.normal
        gauss[some], mean[some] = analysis.gauss[:, where.curved], analysis.mean[:, where.curved]
    return PatchSamples(where, points, normals, area, gauss, mean)
