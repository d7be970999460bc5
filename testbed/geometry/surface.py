"""A surface: batches of patches and the complex that joins them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from testbed.errors import PluginError
from testbed.geometry.domain import CORNERS, side_points
from testbed.geometry.edges import PatchEdges, PatchSides, patch_edges
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.patches import PatchBatch
from testbed.geometry.subdomains import covers_face, from_face, in_face_parameters, inside, to_face
from testbed.geometry.vectors import Float, Int

#: Points evaluated at once; a bound on memory, without influence on the results.
CHUNK = 16384
#: How far outside its face a place may be, in barycentric coordinates: rounding of the caller's.
SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Part:
    """A batch of patches and where each stands in the surface.

    Parameters
    ----------
    batch
        P patches.
    corner_ids
        (P, sides) ids of the corners, shared by neighbouring patches; a corner that is a mesh vertex has the vertex's
        id, inner points of split domains have ids from V on.
    faces
        (P,) the mesh face each patch came from.
    corners_in_face
        (P, sides, 2) the parameters, in the face's own domain, of the patch's corners. Those of a patch beside the
        faces, along an edge of the mesh, lie on that edge; such a patch has no place that ``evaluate`` could find.
    strands
        (P, sides) which curve each side follows, where several join the same two corners; sides belong together that
        have the same corners and the same strand. None where there is one curve everywhere.
    """

    batch: PatchBatch
    corner_ids: Int
    faces: Int
    corners_in_face: Float
    strands: Int | None = None

    def __post_init__(self) -> None:
        count, sides = len(self.batch), self.batch.sides
        shapes = {"corner_ids": (count, sides), "faces": (count,), "corners_in_face": (count, sides, 2)}
        if self.strands is not None:
            shapes["strands"] = (count, sides)
        for name, shape in shapes.items():
            if (found := getattr(self, name).shape) != shape:
                raise PluginError(f"{name} has shape {found} for {count} patches of {sides} sides: give {shape}")

    @classmethod
    def of_split_faces(cls, mesh: HermiteMesh, batch: PatchBatch, faces: Int) -> "Part":
        """Three patches for each of some triangles (N,); patch 3 r + i has the corners i + 1, i + 2 of face faces[r].

        The third corner is the centre of the face f, id V + f.
        """
        corner, centre = mesh.faces[faces], len(mesh.points) + faces
        ids = np.stack([np.stack([corner[:, (i + 1) % 3], corner[:, (i + 2) % 3], centre], axis=-1) for i in range(3)])
        middle = np.full(2, 1.0 / 3.0)
        corners = np.stack([np.stack([CORNERS[3][(i + 1) % 3], CORNERS[3][(i + 2) % 3], middle]) for i in range(3)])
        return cls(
            batch,
            np.moveaxis(ids, 0, 1).reshape(-1, 3),
            np.repeat(faces, 3),
            np.broadcast_to(corners, (len(faces), 3, 3, 2)).reshape(-1, 3, 2),
        )


@dataclass(frozen=True, eq=False)
class Surface:
    """A piecewise surface through a mesh.

    Parameters
    ----------
    mesh
        The mesh it was built on.
    parts
        The batches with their places.
    notes
        Fallbacks taken while it was built, counted; ``{"curves without a root": 3}``.
    branches
        Which ordinary ways its construction took, where it has several, counted; ``{"centres with one root": 5}``.
    """

    mesh: HermiteMesh
    parts: tuple[Part, ...]
    notes: Mapping[str, int] = field(default_factory=dict)
    branches: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def over_faces(
        cls,
        mesh: HermiteMesh,
        batch: PatchBatch,
        notes: Mapping[str, int] | None = None,
        branches: Mapping[str, int] | None = None,
    ) -> "Surface":
        """One patch a face, corner for corner."""
        count = len(mesh.faces)
        corners = np.broadcast_to(CORNERS[mesh.sides], (count, mesh.sides, 2))
        return cls(mesh, (Part(batch, mesh.faces, np.arange(count), corners),), notes or {}, branches or {})

    @classmethod
    def over_split_faces(
        cls, mesh: HermiteMesh, batch: PatchBatch, notes: Mapping[str, int] | None = None
    ) -> "Surface":
        """Three patches a triangle; patch 3 f + i has the corners i + 1, i + 2 of face f and its centre, id V + f."""
        return cls(mesh, (Part.of_split_faces(mesh, batch, np.arange(len(mesh.faces))),), notes or {})

    @property
    def batches(self) -> tuple[PatchBatch, ...]:
        """The patch batches; Bezier ones have ``degree`` and ``control_points``."""
        return tuple(part.batch for part in self.parts)

    @property
    def patch_count(self) -> int:
        """Patches in all batches together."""
        return sum(len(part.batch) for part in self.parts)

    @cached_property
    def edges(self) -> PatchEdges:
        """All edges between patches and on the boundary, inner edges of split faces included, with their sides.

        Raises
        ------
        PluginError
            The corner ids make no surface; the message names the patches.
        """
        strands = [np.zeros_like(part.corner_ids) if part.strands is None else part.strands for part in self.parts]
        return patch_edges([part.corner_ids for part in self.parts], [part.faces for part in self.parts], strands)

    def side_jets(self, sides: PatchSides, t: Float, order: int = 2) -> Jet:
        """Jets at parameters ``t``, (S,) or (E, S), of E sides of patches, as each side runs: (rows, E, S, 3).

        Derivatives are along the patch's own parameters. NaN where there is no patch.
        """
        t = np.asarray(t, dtype=np.float64)
        result = np.full((ROWS[order], len(sides), t.shape[-1], 3), np.nan)
        for index, part in enumerate(self.parts):
            batch = part.batch
            if t.ndim == 1:
                # sides of one number share their sample points, so that their patches share one table
                for side in range(batch.sides):
                    (chosen,) = np.nonzero((sides.part == index) & (sides.side == side))
                    if len(chosen):
                        at = side_points(batch.sides, np.array([side]), t)[0]
                        result[:, chosen] = batch.take(sides.patch[chosen]).jets(at, order).coefficients
            else:
                (chosen,) = np.nonzero(sides.part == index)
                if len(chosen):
                    at = side_points(batch.sides, sides.side[chosen], t[chosen])
                    result[:, chosen] = batch.take(sides.patch[chosen]).jets(at, order).coefficients
        return Jet(result)

    def edge_jets(self, edges: PatchEdges, t: Float, order: int = 2) -> tuple[Jet, Jet]:
        """Jets of the left and of the right patches at the same points of edges, (rows, E, S, 3) each.

        Parameters
        ----------
        edges
            Interior edges of this surface, ``surface.edges[surface.edges.interior]`` or some of them.
        t
            (S,) or (E, S) parameters in [0, 1] along the edges, as their left sides run.
        order
            Order of the jets; derivatives are along each patch's own parameters.
        """
        t = np.asarray(t, dtype=np.float64)
        return self.side_jets(edges.left, t, order), self.side_jets(edges.right, 1.0 - t, order)

    def place(self, part: int, patches: Int, at: Float) -> tuple[Int, Float]:
        """Mesh faces (N,) and parameters in them (N, ..., 2) of points ``at`` (N, ..., 2) of patches (N,) of a part.

        On triangles ``domain.barycentric`` turns the parameters into barycentric coordinates of the face.
        """
        chosen = self.parts[part]
        corners = chosen.corners_in_face[patches]
        corners = corners.reshape(len(corners), *(1,) * (at.ndim - 2), *corners.shape[1:])
        return chosen.faces[patches], np.where(covers_face(corners)[..., None], at, to_face(corners, at))

    def evaluate(self, face: Int, bary: Float, order: int = 2) -> Jet:
        """Jets at points given by mesh face and place in it: coefficients (rows, N, 3).

        Parameters
        ----------
        face
            (N,) mesh faces.
        bary
            (N, 3) barycentric coordinates in triangles, (N, 2) parameters in quadrilaterals.
        order
            0, 1 or 2. Derivatives are along the face's own parameters, on split faces too; on an inner edge of a split
            face they are those of one of its patches, always the same one.

        Raises
        ------
        ValueError
            A face that does not exist or has no patch, or a place outside its face; the message names the first one.
        """
        face, at = checked_places(self.mesh, face, bary)
        part_of, patch_of, local = self._sub_patches(face, at)
        result = np.empty((ROWS[order], len(face), 3))
        for index, part in enumerate(self.parts):
            (mine,) = np.nonzero(part_of == index)
            for chosen in np.array_split(mine, max(1, -(-len(mine) // CHUNK))):
                patches = patch_of[chosen]
                jet = part.batch.take(patches).jets(local[chosen][:, None], order)
                flat = Jet(jet.coefficients[:, :, 0])
                corners = part.corners_in_face[patches]
                converted = in_face_parameters(flat, corners, local[chosen]).coefficients
                result[:, chosen] = np.where(covers_face(corners)[:, None], flat.coefficients, converted)
        return Jet(result)

    @cached_property
    def _patches_by_face(self) -> tuple[Int, Int, Int]:
        """Part and patch of all patches ordered by mesh face, and (F + 1,) where each face's begin."""
        rows = [np.empty((3, 0), dtype=np.int64)]
        for index, part in enumerate(self.parts):
            rows.append(np.stack([part.faces, np.full_like(part.faces, index), np.arange(len(part.faces))]))
        faces, part_of, patch_of = np.concatenate(rows, axis=1)
        order = np.argsort(faces, kind="stable")
        return part_of[order], patch_of[order], np.searchsorted(faces[order], np.arange(len(self.mesh.faces) + 1))

    def _sub_patches(self, face: Int, at: Float) -> tuple[Int, Int, Float]:
        """Part, patch and patch parameters (N,), (N,), (N, 2) of points ``at`` (N, 2) of mesh faces."""
        part_by_face, patch_by_face, begin = self._patches_by_face
        first, count = begin[face], begin[face + 1] - begin[face]
        if (count == 0).any():
            raise ValueError(
                f"face {face[count == 0][0]} of the mesh has no patch on this surface: evaluate other faces"
            )
        best = np.full(len(face), -np.inf)
        part_of, patch_of, local = np.zeros(len(face), np.int64), np.zeros(len(face), np.int64), at.copy()
        # a handful of patches in a face, all faces at once; of patches that hold the point equally well, the first
        for step in range(int(count.max(initial=0))):
            for index, part in enumerate(self.parts):
                (rows,) = np.nonzero(step < count)
                rows = rows[part_by_face[first[rows] + step] == index]
                patches = patch_by_face[first[rows] + step]
                corners = part.corners_in_face[patches]
                candidate = np.where(covers_face(corners)[:, None], at[rows], from_face(corners, at[rows]))
                depth = inside(part.batch.sides, candidate)
                better = depth > best[rows]
                rows, depth = rows[better], depth[better]
                best[rows], part_of[rows], patch_of[rows] = depth, index, patches[better]
                local[rows] = candidate[better]
        return part_of, patch_of, local


def checked_places(mesh: HermiteMesh, face: Int, bary: Float) -> tuple[Int, Float]:
    """Mesh faces (N,) and parameters in them (N, 2) from faces and barycentric coordinates or parameters, checked."""
    face, bary = np.atleast_1d(np.asarray(face)), np.atleast_2d(np.asarray(bary, dtype=np.float64))
    width = {3: 3, 4: 2}[mesh.sides]
    if face.dtype.kind not in "iu" or face.ndim != 1:
        raise ValueError(f"face holds {face.dtype} of shape {face.shape}: give (N,) integers")
    if bary.shape != (len(face), width):
        kind = "barycentric coordinates" if width == 3 else "parameters"
        raise ValueError(f"bary has shape {bary.shape}: give ({len(face)}, {width}) {kind}, a row for each face")
    missing = (face < 0) | (face >= len(mesh.faces))
    if missing.any():
        raise ValueError(f"there is no face {face[missing][0]}: the mesh has faces 0 to {len(mesh.faces) - 1}")
    at = bary[:, -2:]
    # written so that NaN is outside
    outside = ~(inside(mesh.sides, at) >= -SLACK)
    if width == 3:
        outside |= ~(np.abs(bary.sum(axis=1) - 1.0) <= SLACK)
    if outside.any():
        row = int(np.argmax(outside))
        raise ValueError(
            f"row {row} of bary, {bary[row].tolist()}, is not a place in face {face[row]}: "
            + ("give coordinates >= 0 that sum to 1" if width == 3 else "give parameters between 0 and 1")
        )
    return face.astype(np.int64), at
