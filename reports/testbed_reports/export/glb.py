"""GLB files, binary glTF, of triangles: what browsers, Blender and slides show; one field as the vertices' colours."""

from collections.abc import Sequence
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from testbed.geometry.vectors import Float, Int
from testbed_reports.export.tessellation import Tessellation
from testbed_reports.export.vertices import distinct, shared_normals
from testbed_reports.rendering.colouring import MISSING, OUTER, Scale, palette

#: glTF's y points upwards, and ours is z: the scene turns the surface, whose positions stay what they are.
UPRIGHT: Final = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
#: Normals up to this far apart are one in single precision.
AGREEMENT: Final = 1e-7

Field: TypeAlias = Literal["gauss", "mean", "distance"]


def glb(tessellation: Tessellation, field: Field | None, limit: float | None, remarks: Sequence[str]) -> bytes:
    """Return a file; patches that agree at a place in normal and colour, as the file holds them, share a vertex.

    Parameters
    ----------
    tessellation
        The triangles.
    field
        What the colours show, as in pictures; None for one colour.
    limit
        Upper limit of the colours' scale; None for one that suits the values.
    remarks
        Kept as ``asset.extras``.
    """
    import trimesh
    from trimesh.visual.material import PBRMaterial
    from trimesh.visual.texture import TextureVisuals

    normals = shared_normals(tessellation, AGREEMENT).astype(np.float32)
    shown = np.zeros(len(normals), dtype=np.int64)
    extras: dict[str, Any] = {"remarks": list(remarks)}
    colours = _linear(OUTER[None])
    if field is not None:
        values = _surrounded(tessellation.scalars[field], tessellation.triangles)
        scale = Scale.of(field, values)
        if limit is not None:
            scale = Scale(-limit if scale.low < 0.0 else 0.0, limit)
        table = palette(field)
        colours = _linear(np.concatenate([table, MISSING[None]]))
        t = (values - scale.low) / (scale.high - scale.low)
        shown = np.where(np.isnan(t), len(table), np.round(t.clip(0.0, 1.0) * (len(table) - 1))).astype(np.int64)
        extras |= {"field": field, "low": scale.low, "high": scale.high}
    keys = np.concatenate([tessellation.place[:, None].astype(np.float64), normals, shown[:, None]], axis=1)
    leader, vertex = distinct(keys)
    mesh = trimesh.Trimesh(
        tessellation.points[leader], vertex[tessellation.triangles], vertex_normals=normals[leader], process=False
    )
    material = PBRMaterial(  # type: ignore[no-untyped-call]  # trimesh is partly typed
        name="surface", baseColorFactor=[255, 255, 255, 255], metallicFactor=0.0, roughnessFactor=0.6, doubleSided=True
    )
    mesh.visual = TextureVisuals(material=material)  # type: ignore[no-untyped-call]  # trimesh is partly typed
    mesh.visual.vertex_attributes["color"] = colours[shown[leader]]

    def describe(tree: dict[str, Any]) -> None:
        tree["asset"]["extras"] = extras

    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name="surface", geom_name="surface", transform=np.array(UPRIGHT))
    data: bytes = trimesh.exchange.gltf.export_glb(  # type: ignore[no-untyped-call]  # trimesh is partly typed
        scene, include_normals=True, unitize_normals=False, tree_postprocessor=describe
    )
    return data


def _surrounded(values: Float, triangles: Int) -> Float:
    """Values, where there is none the mean of those at the other corners of the triangles of the same patch."""
    lacking = np.isnan(values)
    if not lacking.any():
        return values
    total, count = np.zeros((2, len(values)))
    for corner in range(3):
        for other in (1, 2):
            around = values[triangles[:, (corner + other) % 3]]
            known = ~np.isnan(around)
            np.add.at(total, triangles[known, corner], around[known])
            np.add.at(count, triangles[known, corner], 1.0)
    with np.errstate(invalid="ignore"):
        return np.where(lacking, total / count, values)


def _linear(colours: Float) -> Any:
    """Bytes (N, 4) of colours (N, 3) for glTF, whose vertex colours count light: sRGB's curve undone."""
    light = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    opaque = np.concatenate([light, np.ones((len(light), 1))], axis=1)
    return np.round(255.0 * opaque).astype(np.uint8)
