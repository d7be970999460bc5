"""Checks of what a scheme claims: interpolation, continuity, reproduction, order of convergence."""

import numpy as np
from numpy.polynomial import polynomial

from testbed.conformance.meshes import GENERIC, grid
from testbed.conformance.subject import Outcome, Status, Subject, Worst, points_at, sample_places, size, vertices_of
from testbed.errors import Refused
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between, as_float, norm
from testbed.measures.centre_errors import MISSED, centre_errors
from testbed.measures.convergence import estimate_order, verdict
from testbed.measures.corner_forms import corner_forms
from testbed.plugins.scheme import Continuity, Data, Shape

#: Parameters of an edge at which continuity is looked at, also near its ends.
EDGE_PARAMETERS = np.concatenate([[1e-3, 1e-2], np.arange(1, 32) / 32, [1 - 1e-2, 1 - 1e-3]])

POSITION_BOUND = 1e-12
NORMAL_BOUND_DEG = 1e-8
FORM_BOUND = 1e-8
#: For limits at the corners of blended patches, which are extrapolated: rounding is larger there, and in narrow faces.
LIMIT_BOUND = 1e-6
CURVATURE_JUMP_BOUND = 1e-6


def interpolates_points(subject: Subject) -> Outcome:
    """The surface passes through every vertex, at every patch that meets there."""
    worst = Worst()
    for case, surface in subject.accepted:
        for index, patch, corner, vertex in vertices_of(surface):
            batch = surface.parts[index].batch
            f = batch.jets(CORNERS[batch.sides], 0).f[patch, corner]
            worst = _at_vertices(worst, norm(f - case.mesh.points[vertex]) / size(case.mesh), case.name, vertex)
    return worst.outcome("interpolates points", POSITION_BOUND, "of the size")


def interpolates_normals(subject: Subject) -> Outcome:
    """The surface has the given normal at every vertex, at every patch that meets there."""
    name = "interpolates normals"
    if Data.NORMALS not in subject.scheme.matches:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst = Worst()
    for case, surface in subject.accepted:
        for index, patch, corner, vertex in vertices_of(surface):
            batch = surface.parts[index].batch
            normals = batch.jets(CORNERS[batch.sides], 1).normal[patch, corner]
            assert case.mesh.normals is not None  # noqa: S101 - the suite's meshes have them
            angles = np.degrees(angle_between(normals, case.mesh.normals[vertex]))
            worst = _at_vertices(worst, angles, case.name, vertex)
    return worst.outcome(name, NORMAL_BOUND_DEG, "degrees")


def interpolates_second_forms(subject: Subject) -> Outcome:
    """The surface has the given second fundamental form at every vertex, wherever no fallback was taken.

    Of blended patches, the limits along several directions have to be the given form.
    """
    name = "interpolates second fundamental forms"
    if Data.SECOND_FORMS not in subject.scheme.matches:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst, bound = Worst(), 0.0
    for case, surface in subject.accepted:
        if any(surface.notes.values()):
            continue  # the claim ends where the scheme says that it had to depart from its construction
        for index, patch, corner, vertex in vertices_of(surface):
            batch = surface.parts[index].batch
            forms = corner_forms(batch)[patch, corner]
            assert case.mesh.second_forms is not None  # noqa: S101 - the suite's meshes have them
            error = np.abs(forms - case.mesh.second_forms[vertex][:, None]).max(axis=(1, 2, 3)) * size(case.mesh)
            worst = _at_vertices(worst, error, case.name, vertex)
            bound = max(bound, FORM_BOUND if batch.corner_margin == 0.0 else LIMIT_BOUND)
    return worst.outcome(name, bound, "of 1/size")


def interpolates_centres(subject: Subject) -> Outcome:
    """The surface has the given point, normal and second form at the centre of every face, but for noted fallbacks.

    As many faces of a mesh may miss their samples as the scheme says that it had to depart from its construction.
    """
    name = "interpolates samples at face centres"
    if Data.CENTRES not in subject.scheme.matches:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst, faces = Worst(), 0
    for case, surface in subject.accepted:
        error = centre_errors(surface)
        if error is None:
            continue
        relative, missed = error.relative(size(case.mesh)), error.missed(size(case.mesh))
        departures = sum(surface.notes.values())
        if missed.sum() > departures:
            face = int(np.argmax(missed))
            where = f"{case.name}, face {face}: {missed.sum()} faces miss their samples and {departures} are noted"
            return Outcome(name, Status.FAILED, where)
        faces += int((~missed).sum())
        if not missed.all():
            at = np.flatnonzero(~missed)
            worst = _at_faces(worst, relative[:, at].max(axis=0), case.name, at, np.full((len(at), 2), 0.5))
    outcome = worst.outcome(name, MISSED, "of the size, radians or 1/size")
    return Outcome(name, outcome.status, f"{outcome.detail}; {faces} faces")


def is_continuous(subject: Subject) -> Outcome:
    """Neighbouring patches share their edges, inner ones of split faces too."""
    worst = Worst()
    for case, surface in subject.accepted:
        left, right = surface.edge_jets(surface.edges[surface.edges.interior], EDGE_PARAMETERS, 0)
        worst = _at_edges(worst, norm(left.f - right.f) / size(case.mesh), case.name, surface)
    return worst.outcome("C0 on every edge", POSITION_BOUND, "of the size")


def is_tangent_continuous(subject: Subject) -> Outcome:
    """Neighbouring patches have the same oriented normal along their edge."""
    name = "G1 on every edge"
    if subject.scheme.continuity is Continuity.C0:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst = Worst()
    for case, surface in subject.accepted:
        left, right = surface.edge_jets(surface.edges[surface.edges.interior], EDGE_PARAMETERS, 1)
        worst = _at_edges(worst, np.degrees(angle_between(left.normal, right.normal)), case.name, surface)
    return worst.outcome(name, NORMAL_BOUND_DEG, "degrees")


def is_curvature_continuous(subject: Subject) -> Outcome:
    """Neighbouring patches have the same second fundamental form along their edge."""
    name = "G2 on every edge"
    if subject.scheme.continuity is not Continuity.G2:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst = Worst()
    for case, surface in subject.accepted:
        left, right = surface.edge_jets(surface.edges[surface.edges.interior], EDGE_PARAMETERS, 2)
        one, other = second_form_matrix(left), second_form_matrix(right)
        scale = np.abs(one).max(axis=(-1, -2)) + np.abs(other).max(axis=(-1, -2)) + 1.0 / size(case.mesh)
        worst = _at_edges(worst, np.abs(one - other).max(axis=(-1, -2)) / scale, case.name, surface)
    return worst.outcome(name, CURVATURE_JUMP_BOUND, "of the curvature")


def reproduces(subject: Subject, shape: Shape) -> Outcome:
    """Data sampled from the shape give the shape."""
    name = f"reproduces {shape.value}"
    if shape not in subject.scheme.reproduces:
        return Outcome(name, Status.NOT_CLAIMED, "")
    worst = Worst()
    for case, surface in subject.accepted:
        if shape in case.shapes and case.implicit is not None:
            face, at = sample_places(case.mesh)
            off = np.abs(case.implicit(points_at(surface, face, at))) / size(case.mesh)
            worst = _at_faces(worst, off, case.name, face, at)
    return worst.outcome(name, POSITION_BOUND, "of the size")


def converges(subject: Subject) -> Outcome:
    """The distance to a generic graph falls at least as fast as claimed, under halving of the edges."""
    name = "claimed order of convergence"
    claimed = subject.scheme.order
    if claimed is None:
        return Outcome(name, Status.NOT_CLAIMED, "")
    sides = subject.scheme.domain[0]
    h, errors = [], []
    for steps in (2, 4, 8, 16, 32):
        mesh = grid(sides, steps)
        try:
            surface = subject.scheme.fit(mesh)
        except Refused as refusal:
            return Outcome(name, Status.NOT_TESTABLE, f"refused the generic graph at {steps} steps: {refusal.reason}")
        samples = lattice(sides, 6)
        face = np.repeat(np.arange(len(mesh.faces)), len(samples))
        h.append(mesh.h)
        errors.append(_graph_distance(points_at(surface, face, np.tile(samples, (len(mesh.faces), 1)))).max())
    estimate = estimate_order(np.array(h), np.array(errors), size(grid(sides, 2)))
    found = (
        f"{estimate.order:.2f} in [{estimate.low:.2f}, {estimate.high:.2f}], claimed {claimed:g}, on a generic graph"
    )
    status = {"met": Status.PASSED, "exceeded": Status.PASSED, "missed": Status.FAILED}.get(
        verdict(claimed, estimate), Status.NOT_TESTABLE
    )
    return Outcome(name, status, found)


def _graph_distance(points: Float) -> Float:
    """Distance (N,) to the generic graph, up to its square: the vertical offset times the normal's vertical part."""
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    slopes = [polynomial.polyval2d(x, y, polynomial.polyder(GENERIC, axis=axis)) for axis in (0, 1)]
    return as_float(np.abs(z - polynomial.polyval2d(x, y, GENERIC)) / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2))


def _at_vertices(worst: Worst, values: Float, mesh: str, vertex: Int) -> Worst:
    if not len(values):  # a part of a surface may have no vertex of the mesh
        return worst
    place = int(np.argmax(values))  # argmax returns the first NaN where there is one
    return worst.or_worse(float(values[place]), f"{mesh}, vertex {int(vertex[place])}")


def _at_faces(worst: Worst, values: Float, mesh: str, face: Int, at: Float) -> Worst:
    place = int(np.argmax(values))
    return worst.or_worse(float(values[place]), f"{mesh}, face {int(face[place])} at {at[place].tolist()}")


def _at_edges(worst: Worst, values: Float, mesh: str, surface: Surface) -> Worst:
    """Values (E, S) over the interior edges."""
    if not values.size:
        return worst
    edge, sample = np.unravel_index(int(np.argmax(values)), values.shape)
    face = int(surface.edges[surface.edges.interior].left.face[edge])
    where = f"{mesh}, an edge of face {face} at t = {EDGE_PARAMETERS[sample]:g}"
    return worst.or_worse(float(values[edge, sample]), where)
