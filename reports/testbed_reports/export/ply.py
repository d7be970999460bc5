"""PLY files of triangles, binary, in double precision, with every field as a property.

trimesh keeps fields, but rounds positions to single precision and writes no comments; the format is a header and two
tables of records.
"""

from collections.abc import Sequence

import numpy as np

from testbed_reports.export.tessellation import Tessellation
from testbed_reports.export.vertices import Vertices


def ply(vertices: Vertices, tessellation: Tessellation, remarks: Sequence[str]) -> bytes:
    """Return a file: vertices with positions, normals and scalars; triangles with mesh face, part and patch.

    Parameters
    ----------
    vertices
        What a vertex is.
    tessellation
        Where the triangles come from.
    remarks
        Comments, a line each.
    """
    columns = {
        **{name: vertices.points[:, axis] for axis, name in enumerate(("x", "y", "z"))},
        **{name: vertices.normals[:, axis] for axis, name in enumerate(("nx", "ny", "nz"))},
        **vertices.scalars,
    }
    table = np.empty(len(vertices.points), dtype=[(name, "<f8") for name in columns])
    for name, values in columns.items():
        table[name] = values
    of_triangles = {"face": tessellation.face, "part": tessellation.part, "patch": tessellation.patch}
    record = [("corners", "u1"), ("vertex_indices", "<i4", 3), *((name, "<i4") for name in of_triangles)]
    triangles = np.empty(len(vertices.triangles), dtype=record)
    triangles["corners"], triangles["vertex_indices"] = 3, vertices.triangles
    for name, ids in of_triangles.items():
        triangles[name] = ids
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {one_line(remark)}" for remark in remarks),
        f"element vertex {len(table)}",
        *(f"property double {name}" for name in columns),
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        *(f"property int {name}" for name in of_triangles),
        "end_header\n",
    ]
    return "\n".join(header).encode("ascii") + table.tobytes() + triangles.tobytes()


def one_line(text: str) -> str:
    """Return a text as one line of printable ASCII; what is not that is written as Python escapes it."""
    return text.encode("unicode_escape").decode("ascii")
