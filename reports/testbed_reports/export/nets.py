"""Control nets as named arrays in NumPy's NPZ files: all that makes up a surface of Bézier patches, to the last bit."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from testbed.geometry.bezier import RationalBezierTriangles
from testbed.geometry.mesh_arrays import mesh_arrays
from testbed.geometry.surface import Surface
from testbed_reports.export.bezier_cells import check_bezier, is_bezier


def nets(surface: Surface, remarks: Sequence[str]) -> bytes:
    """Return a file.

    For part number ``r``, with P patches: ``part<r>_control_points``, (P, n, 3) for triangles, by decreasing exponent
    of b0, then of b1, or (P, m + 1, n + 1, 3) along u and v; ``part<r>_weights``, (P, n), of rational ones;
    ``part<r>_corner_ids`` (P, sides), equal for corners that neighbours share; ``part<r>_faces`` (P,), the mesh faces;
    ``part<r>_corners_in_face`` (P, sides, 2), the corners' parameters there; ``part<r>_strands`` (P, sides) where
    several curves join two corners. ``parts`` is their number, ``mesh_<name>`` the data of the mesh (see
    ``testbed.save_mesh``), ``remarks`` the texts.

    Raises
    ------
    TestbedError
        Some patches are no Bézier patches.
    """
    check_bezier(surface, "write triangles, as .ply or with --tessellated as .vtu")
    arrays: dict[str, Any] = {"parts": np.int64(len(surface.parts)), "remarks": np.array(list(remarks))}
    for index, part in enumerate(surface.parts):
        batch = part.batch
        assert is_bezier(batch)  # noqa: S101 - checked above
        of_part: dict[str, Any] = {"control_points": batch.control_points}
        if isinstance(batch, RationalBezierTriangles):
            of_part["weights"] = batch.weights
        of_part |= {
            "corner_ids": part.corner_ids,
            "faces": part.faces,
            "corners_in_face": part.corners_in_face,
        }
        if part.strands is not None:
            of_part["strands"] = part.strands
        arrays |= {f"part{index}_{name}": values for name, values in of_part.items()}
    arrays |= {f"mesh_{name}": values for name, values in mesh_arrays(surface.mesh).items()}
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()
