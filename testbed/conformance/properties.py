"""Checks of what every scheme owes: invariance, locality, independence of batches and of history, refusal."""

from collections.abc import Callable

import numpy as np

from testbed.conformance.meshes import cases, grid, torus
from testbed.conformance.subject import Outcome, Status, Subject, Worst, normals_at, points_at, sample_places, size
from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int, dot, norm, unit
from testbed.plugins.scheme import Data, Scheme

#: Surfaces over moved, scaled or renamed data agree to this part of the size.
INVARIANCE_BOUND = 1e-9
#: Weight of deviations along the surface. The legs of a short geometric Hermite curve are a nearly triple root, so that
#: rounding, amplified, moves points along their curve: another parametrisation of the same surface to full precision.
ALONG = 1e-3

#: A rotation by a generic angle about a generic axis, and a translation.
_AXIS = np.array([0.48, 0.6, 0.64])
_SKEW = np.array([[0, -_AXIS[2], _AXIS[1]], [_AXIS[2], 0, -_AXIS[0]], [-_AXIS[1], _AXIS[0], 0]])
ROTATION = np.eye(3) + np.sin(1.1) * _SKEW + (1.0 - np.cos(1.1)) * (_SKEW @ _SKEW)
TRANSLATION = np.array([0.7, -1.3, 0.4])
#: The same in the plane z = 0, for schemes that take z for heights over it.
TURN = np.array([[np.cos(1.1), -np.sin(1.1), 0.0], [np.sin(1.1), np.cos(1.1), 0.0], [0.0, 0.0, 1.0]])
SHIFT = np.array([0.7, -1.3, 0.0])


def keeps(
    subject: Subject,
    name: str,
    change: Callable[[HermiteMesh], HermiteMesh],
    places: Callable[[HermiteMesh, Int, Float], tuple[Int, Float]],
    motion: Callable[[Float], Float],
) -> Outcome:
    """Compare the surface over changed data with the changed surface over the data.

    Parameters
    ----------
    change
        From a mesh to the changed mesh.
    places
        From faces and parameters of the mesh to those of the changed mesh.
    motion
        From points of the surface to where they ought to be on the changed one.
    """
    worst = Worst()
    for case, surface in subject.accepted:
        face, at = sample_places(case.mesh)
        changed = change(case.mesh)
        expected = motion(points_at(surface, face, at))
        normals = motion(normals_at(surface, face, at)) - motion(np.zeros(3))
        normals /= norm(normals)[:, None]
        try:
            found = points_at(subject.scheme.fit(changed), *places(case.mesh, face, at))
        except Refused as refusal:
            return Outcome(name, Status.FAILED, f"{case.name} is accepted, changed it is refused: {refusal.reason}")
        across = dot(found - expected, normals)
        along = norm(found - expected - across[:, None] * normals)
        error = (np.abs(across) + ALONG * along) / size(changed)
        place = int(np.argmax(error))
        worst = worst.or_worse(float(error[place]), f"{case.name}, face {face[place]} at {at[place].tolist()}")
    return worst.outcome(name, INVARIANCE_BOUND, "of the size")


def _same_place(_: HermiteMesh, face: Int, at: Float) -> tuple[Int, Float]:
    return face, at


def _same_point(points: Float) -> Float:
    return points


def moves_with_the_data(subject: Subject) -> Outcome:
    """A rigid motion of the data moves the surface; of schemes on heights, one of the plane z = 0."""
    in_plane = subject.scheme.vertical
    rotation, translation = (TURN, SHIFT) if in_plane else (ROTATION, TRANSLATION)
    return keeps(
        subject,
        "invariant under rigid motion" + (" of the plane z = 0" if in_plane else ""),
        lambda mesh: mesh.transformed(rotation, translation, 1.0),
        _same_place,
        lambda points: points @ rotation.T + translation,
    )


def scales_with_the_data(subject: Subject, factor: float) -> Outcome:
    """Data scaled by a factor give the surface scaled by it."""
    return keeps(
        subject,
        f"invariant under scaling by {factor:g}",
        lambda mesh: mesh.transformed(np.eye(3), np.zeros(3), factor),
        _same_place,
        lambda points: factor * points,
    )


def ignores_vertex_labels(subject: Subject) -> Outcome:
    """Renumbered vertices give the same surface."""
    return keeps(
        subject,
        "independent of vertex labels",
        lambda mesh: mesh.relabelled(np.random.default_rng(5).permutation(len(mesh.points))),
        _same_place,
        _same_point,
    )


def ignores_first_corners(subject: Subject) -> Outcome:
    """Faces that start at another of their corners give the same surface."""

    def places(mesh: HermiteMesh, face: Int, at: Float) -> tuple[Int, Float]:
        if mesh.sides == 3:  # corner 1 comes first: (b0, b1, b2) is written (b1, b2, b0)
            return face, np.stack([at[:, 1], 1.0 - at.sum(axis=1)], axis=-1).clip(0.0, 1.0)
        return face, np.stack([at[:, 1], 1.0 - at[:, 0]], axis=-1)

    return keeps(
        subject,
        "independent of the corner a face starts at",
        lambda mesh: mesh.rotated_corners(1),
        places,
        _same_point,
    )


def ignores_face_order(subject: Subject) -> Outcome:
    """Reordered faces give the same surface."""
    return keeps(
        subject,
        "independent of the order of faces",
        lambda mesh: mesh.with_face_order(np.arange(len(mesh.faces))[::-1]),
        lambda mesh, face, at: (len(mesh.faces) - 1 - face, at),
        _same_point,
    )


def ignores_orientation(subject: Subject) -> Outcome:
    """Faces turned over, with normals and second forms negated, give the same surface seen from its other side."""

    def places(mesh: HermiteMesh, face: Int, at: Float) -> tuple[Int, Float]:
        """Corners in reverse: (b0, b1, b2) is written (b2, b1, b0), (u, v) of a square (u, 1 - v)."""
        v = 1.0 - at.sum(axis=1) if mesh.sides == 3 else 1.0 - at[:, 1]
        return face, np.stack([at[:, 0], v], axis=-1).clip(0.0, 1.0)

    return keeps(subject, "independent of orientation", lambda mesh: mesh.flipped(), places, _same_point)


def is_local(subject: Subject) -> Outcome:
    """Data changed at one vertex change the faces within the claimed rings, and not a bit elsewhere."""
    name = "local"
    support = subject.scheme.support
    if support is None:
        return Outcome(name, Status.NOT_CLAIMED, "the surface depends on the whole mesh")
    for sides in subject.scheme.domain:
        mesh = torus(10, 8, sides)
        changed = _changed_at(mesh, 11)
        try:
            before, after = subject.scheme.fit(mesh), subject.scheme.fit(changed)
        except Refused as refusal:
            return Outcome(name, Status.NOT_TESTABLE, f"refused the torus: {refusal.reason}")
        face, at = sample_places(mesh)
        differs = (points_at(before, face, at) != points_at(after, face, at)).any(axis=1)
        allowed = _faces_around(mesh, 11, support)
        outside = differs & ~allowed[face]
        if outside.any():
            where = f"coarse torus: vertex 11 changed, face {face[outside][0]} changed outside {support} rings"
            return Outcome(name, Status.FAILED, where)
        if not differs.any():
            return Outcome(name, Status.FAILED, "coarse torus: vertex 11 changed and the surface did not")
    return Outcome(name, Status.PASSED, f"a face depends on its own vertices and {support} rings of faces around it")


def _changed_at(mesh: HermiteMesh, vertex: int) -> HermiteMesh:
    """Return the mesh with other data, of the same kind, at one vertex."""
    assert mesh.normals is not None  # noqa: S101 - the suite's meshes have them
    assert mesh.second_forms is not None  # noqa: S101 - likewise
    points, normals, forms = mesh.points.copy(), mesh.normals.copy(), mesh.second_forms.copy()
    points[vertex] += 0.02 * size(mesh) * np.array([0.3, -0.5, 0.4])
    normals[vertex] = unit(normals[vertex] + np.array([0.1, 0.05, -0.08]))
    tangent = np.eye(3) - np.outer(normals[vertex], normals[vertex])
    forms[vertex] = tangent @ (forms[vertex] + 0.1 * np.eye(3)) @ tangent
    forms[vertex] = 0.5 * (forms[vertex] + forms[vertex].T)
    return HermiteMesh(points, mesh.faces, normals, forms, face_data=mesh.face_data)


def _faces_around(mesh: HermiteMesh, vertex: int, rings: int) -> Bool:
    """(F,) true for the faces at a vertex and for so many rings of faces around those."""
    around = np.isin(mesh.faces, [vertex]).any(axis=1)
    for _ in range(rings):
        around = np.isin(mesh.faces, mesh.faces[around]).any(axis=1)
    return np.asarray(around, dtype=np.bool_)


def is_independent_of_batches(subject: Subject) -> Outcome:
    """A patch evaluated alone, or a point evaluated alone, has the same jet as among others."""
    worst = Worst()
    for case, surface in subject.accepted:
        face, at = sample_places(case.mesh)
        together = points_at(surface, face, at)
        for one in range(0, len(face), max(1, len(face) // 12)):
            alone = points_at(surface, face[one : one + 1], at[one : one + 1])[0]
            error = float(norm(alone - together[one]) / size(case.mesh))
            worst = worst.or_worse(error, f"{case.name}, face {face[one]} at {at[one].tolist()}")
    return worst.outcome("independent of batch size", 0.0, "of the size")


def is_stateless(subject: Subject) -> Outcome:
    """Fitting other meshes in between changes no bit; neither does a new object."""
    name = "stateless"
    for case, surface in subject.accepted:
        face, at = sample_places(case.mesh)
        first = points_at(surface, face, at)
        fresh: Scheme = type(subject.scheme)(**vars(subject.scheme))
        for again in (subject.scheme.fit(case.mesh), fresh.fit(case.mesh)):
            differs = (points_at(again, face, at) != first).any(axis=1)
            if differs.any():
                return Outcome(name, Status.FAILED, f"{case.name}, face {face[differs][0]}: the second surface differs")
    if not subject.accepted:
        return Outcome(name, Status.NOT_TESTABLE, "refused every mesh of the suite")
    return Outcome(name, Status.PASSED, f"bit for bit on {len(subject.accepted)} meshes")


def refuses_what_it_cannot_take(subject: Subject) -> Outcome:
    """Missing data and faces of another kind are refused; hostile data are refused or give a finite surface."""
    name = "refuses what it cannot take"
    scheme = subject.scheme
    needs = scheme.needs
    for plugin in scheme.nested():
        needs |= getattr(plugin, "needs", Data.POINTS)
    whole = cases(scheme.domain[0])[0].mesh
    bare = HermiteMesh(whole.points, whole.faces)
    without_forms = whole.without_second_forms()
    demands: list[tuple[str, HermiteMesh]] = []
    if Data.NORMALS in needs:
        demands.append(("a mesh without normals", bare))
    if Data.SECOND_FORMS in needs:
        demands.append(("a mesh without second forms", without_forms))
    if Data.CENTRES in needs:
        demands.append(
            ("a mesh without centres", HermiteMesh(whole.points, whole.faces, whole.normals, whole.second_forms))
        )
    if len(scheme.domain) == 1:
        demands.append(("faces with another number of sides", grid(7 - scheme.domain[0], 2)))
    for what, mesh in demands:
        try:
            scheme.fit(mesh)
        except Refused:
            continue
        return Outcome(name, Status.FAILED, f"{what} was not refused")
    accepted = [what for what, mesh in _hostile(whole) if _is_built(scheme, mesh)]
    return Outcome(name, Status.PASSED, f"refused {len(demands)} of {len(demands)}; hostile but taken: {len(accepted)}")


def _hostile(mesh: HermiteMesh) -> list[tuple[str, HermiteMesh]]:
    """Return meshes whose normals no surface would have: along an edge, turned over, all equal."""
    assert mesh.normals is not None  # noqa: S101 - the suite's meshes have them
    along, folded = mesh.normals.copy(), mesh.normals.copy()
    along[mesh.faces[0, 0]] = unit(mesh.points[mesh.faces[0, 1]] - mesh.points[mesh.faces[0, 0]])
    folded[::2] *= -1.0
    equal = np.broadcast_to(np.array([0.0, 0.0, 1.0]), mesh.normals.shape)
    no_forms = np.zeros((len(mesh.points), 3, 3))

    def with_normals(normals: Float) -> HermiteMesh:
        return HermiteMesh(mesh.points, mesh.faces, normals, no_forms, face_data=mesh.face_data)

    return [
        ("a normal along an edge", with_normals(along)),
        ("every second normal turned over", with_normals(folded)),
        ("all normals equal", with_normals(equal)),
    ]


def _is_built(scheme: Scheme, mesh: HermiteMesh) -> bool:
    """Whether the scheme takes the mesh; ``fit`` itself refuses what is not finite, any other exception is a defect."""
    try:
        surface: Surface = scheme.fit(mesh)
    except Refused:
        return False
    return surface.patch_count > 0
