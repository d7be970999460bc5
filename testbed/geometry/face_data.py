"""Data of a mesh that belong to its faces: samples at face centres, second forms by corner, tangents of given curves.

Most meshes have none. Patches that interpolate a surface at face centres need samples there. A surface that is smooth
to first order only, such as a network of S-patches, has other second forms on each side of its inner edges, and patches
that approximate it have to follow those edges, as they follow its boundary.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.mesh_checks import checked_normals, checked_vectors, named, tangential_forms
from testbed.geometry.vectors import Bool, Float, Int, dot, norm, unit

#: How far a given tangent may be from the tangent plane, and from the same tangent as the neighbouring face has it.
TANGENT = 1e-6


@dataclass(frozen=True, eq=False)
class Centres:
    """Samples of a surface at the centres of F faces.

    Parameters
    ----------
    points
        (F, 3) points of the surface, those at the middle of the faces' parameters.
    normals
        (F, 3) unit normals there.
    second_forms
        (F, 3, 3) second fundamental forms W there.
    """

    points: Float
    normals: Float
    second_forms: Float


@dataclass(frozen=True, eq=False)
class FaceData:
    """Data that belong to faces, all of them optional.

    Parameters
    ----------
    centres
        Samples at the centres of the faces.
    corner_second_forms
        (F, sides, 3, 3) second fundamental forms at the faces' corners, where they differ from face to face; they stand
        for those of the vertices.
    side_tangents
        (F, sides, 2, 3) unit tangents, at the start and at the end of side s and in the direction it runs in, of the
        curve that the surface has to follow there; NaN where none is prescribed. Both faces at an edge have the same
        curve.
    """

    centres: Centres | None = None
    corner_second_forms: Float | None = None
    side_tangents: Float | None = None

    def checked(self, faces: Int, normals: Float | None, h: float) -> "FaceData":
        """Return the data, checked and scaled as those of vertices are, for a mesh with longest edge ``h``.

        Raises
        ------
        MeshError
            One sentence that names the face.
        """
        data = (self.centres, self.corner_second_forms, self.side_tangents)
        if normals is None and any(given is not None for given in data):
            raise MeshError("the mesh has data at its faces and no normals: give normals too")
        centres, forms, tangents = data
        if centres is not None:
            centres = checked_centres(centres, faces, h)
        if normals is not None and forms is not None:
            count, sides = faces.shape
            flat = checked_vectors(forms, "second forms by corner", (None, sides, 3, 3))
            check_count(len(flat), count, "second forms by corner")
            at_corners = normals[faces].reshape(-1, 3)
            flat = tangential_forms(
                flat.reshape(-1, 3, 3),
                at_corners,
                h,
                lambda row: f"at corner {row % sides} of {named(faces, row // sides)}",
            )
            forms = flat.reshape(count, sides, 3, 3)
        if normals is not None and tangents is not None:
            tangents = checked_tangents(tangents, faces, normals)
        result = FaceData(centres, forms, tangents)
        for array in result.arrays().values():
            array.flags.writeable = False
        return result

    def arrays(self) -> Mapping[str, Float]:
        """Return the arrays there are, by name, faces along the first axis of each."""
        of_centres = {} if self.centres is None else {f"centre_{name}": at for name, at in vars(self.centres).items()}
        own = {"corner_second_forms": self.corner_second_forms, "side_tangents": self.side_tangents}
        return {**of_centres, **{name: array for name, array in own.items() if array is not None}}

    def take(self, faces: Int | Bool) -> "FaceData":
        """Return the data of some faces, in the order chosen."""
        centres = self.centres
        if centres is not None:
            centres = Centres(centres.points[faces], centres.normals[faces], centres.second_forms[faces])
        forms, tangents = self.corner_second_forms, self.side_tangents
        return FaceData(centres, None if forms is None else forms[faces], None if tangents is None else tangents[faces])

    def rotated(self, columns: Int) -> "FaceData":
        """Return the data of faces whose corner s is corner ``columns[f, s]`` of before, (F, sides)."""
        forms, tangents = self.corner_second_forms, self.side_tangents
        rows = np.arange(len(columns))[:, None]
        return replace(
            self,
            corner_second_forms=None if forms is None else forms[rows, columns],
            side_tangents=None if tangents is None else tangents[rows, columns],
        )

    def flipped(self) -> "FaceData":
        """Return the data of the surface turned inside out, its faces running the other way."""
        centres, forms, tangents = self.centres, self.corner_second_forms, self.side_tangents
        if centres is not None:
            centres = Centres(centres.points, -centres.normals, -centres.second_forms)
        if tangents is not None:
            # side s runs back along side sides - 2 - s of before, the last one along the last one
            sides = np.roll(np.arange(tangents.shape[1])[::-1], -1)
            tangents = -tangents[:, sides, ::-1]
        return FaceData(centres, None if forms is None else -forms[:, ::-1], tangents)

    def transformed(self, rotation: Float, translation: Float, scale: float) -> "FaceData":
        """Rotate by a matrix (3, 3), scale by a positive number and then move by a vector (3,)."""
        centres, forms, tangents = self.centres, self.corner_second_forms, self.side_tangents
        if centres is not None:
            centres = Centres(
                scale * (centres.points @ rotation.T) + translation,
                centres.normals @ rotation.T,
                rotation @ centres.second_forms @ rotation.T / scale,
            )
        return FaceData(
            centres,
            None if forms is None else rotation @ forms @ rotation.T / scale,
            None if tangents is None else tangents @ rotation.T,
        )

    def without_second_forms(self) -> "FaceData":
        """Return the tangents alone."""
        return FaceData(side_tangents=self.side_tangents)


def checked_centres(centres: Centres, faces: Int, h: float) -> Centres:
    """Return the centre samples with unit normals and tangential second forms; MeshError names the face."""
    points = checked_vectors(centres.points, "points at face centres", (None, 3))
    normals = checked_vectors(centres.normals, "normals at face centres", (None, 3))
    forms = checked_vectors(centres.second_forms, "second forms at face centres", (None, 3, 3))
    for array, what in ((points, "points"), (normals, "normals"), (forms, "second forms")):
        check_count(len(array), len(faces), f"{what} at face centres")
    normals = checked_normals(normals, len(faces))
    forms = tangential_forms(forms, normals, h, lambda row: f"at the centre of {named(faces, row)}")
    return Centres(points, normals, forms)


def checked_tangents(values: Float, faces: Int, normals: Float) -> Float:
    """Return unit tangents (F, sides, 2, 3) or NaN; MeshError names the face where they are not a curve's."""
    tangents = np.array(values, dtype=np.float64)
    if tangents.shape != (*faces.shape, 2, 3):
        raise MeshError(f"the tangents of sides have shape {tangents.shape}: give {(*faces.shape, 2, 3)}")
    given: Bool = np.asarray(np.isfinite(tangents).all(axis=(2, 3)))
    partly = ~given & ~np.isnan(tangents).all(axis=(2, 3))
    if partly.any():
        face, side = np.argwhere(partly)[0].tolist()
        raise MeshError(
            f"side {side} of {named(faces, face)} has half of its tangents: give both, or NaN where no curve is given"
        )
    ends = np.stack([normals[faces], np.roll(normals[faces], -1, axis=1)], axis=2)
    length = norm(np.where(given[..., None, None], tangents, 1.0))
    with np.errstate(invalid="ignore"):  # NaN where none is given
        off = np.abs(dot(tangents, ends)) > TANGENT * length
    off |= length == 0.0
    if off.any():
        face, side, _ = np.argwhere(off)[0].tolist()
        raise MeshError(
            f"a tangent of side {side} of {named(faces, face)} is not in the tangent plane there: give one that is"
        )
    check_shared(tangents, given, faces)
    return unit(tangents)


def check_shared(tangents: Float, given: Bool, faces: Int) -> None:
    """Check that the two faces at an edge have the same tangents there, or none; MeshError names a face."""
    start, end = faces, np.roll(faces, -1, axis=1)
    low, high = np.minimum(start, end).ravel(), np.maximum(start, end).ravel()
    runs_back = (start > end).ravel()
    order = np.lexsort((runs_back, high, low))
    pair = np.flatnonzero((low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1]))
    one, other = order[pair], order[pair + 1]
    flat, is_given = unit(tangents).reshape(-1, 2, 3), given.ravel()
    apart = norm(flat[one] + flat[other][:, ::-1]).max(axis=1)
    wrong = (is_given[one] != is_given[other]) | (is_given[one] & is_given[other] & ~(apart <= TANGENT))
    if wrong.any():
        row = int(one[np.argmax(wrong)])
        sides = faces.shape[1]
        raise MeshError(
            f"side {row % sides} of {named(faces, row // sides)} has other tangents than the face beyond it: give both "
            "faces the tangents of one curve"
        )


def check_count(given: int, faces: int, what: str) -> None:
    """Check that there is a row for each face."""
    if given != faces:
        raise MeshError(f"there are {given} {what} for {faces} faces: give one for each face")
