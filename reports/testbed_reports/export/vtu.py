"""VTU files, VTK's unstructured grids in XML, of triangles or of Bézier cells; ParaView opens them."""

import base64
import io
from collections.abc import Mapping, Sequence
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

from testbed.geometry.vectors import Float, Int
from testbed_reports.export.bezier_cells import BezierCells
from testbed_reports.export.tessellation import Tessellation
from testbed_reports.export.vertices import Vertices

#: VTK's cell type of a triangle.
TRIANGLE: Final = 5
_TYPES: Final = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def bezier_vtu(cells: BezierCells, remarks: Sequence[str]) -> bytes:
    """Return a file of Bézier cells.

    The control points are the grid's points. ``HigherOrderDegrees`` are the cells' degrees along u and v,
    ``RationalWeights`` the points' weights, where some are not 1; under these names VTK uses them.

    Parameters
    ----------
    cells
        The cells.
    remarks
        Texts kept in the file as field data.
    """
    of_points = {} if cells.weights is None else {"RationalWeights": cells.weights}
    return _written(
        cells.points,
        (np.arange(len(cells.points)), cells.offsets, cells.types),
        (of_points, {name: name for name in of_points}),
        (
            {"HigherOrderDegrees": cells.degrees, "face": cells.face, "part": cells.part},
            {"HigherOrderDegrees": "HigherOrderDegrees"},
        ),
        remarks,
    )


def triangle_vtu(vertices: Vertices, tessellation: Tessellation, remarks: Sequence[str]) -> bytes:
    """Return a file of triangles with the values at the vertices, and the mesh face and patch of each triangle."""
    count = len(vertices.triangles)
    return _written(
        vertices.points,
        (vertices.triangles.ravel(), 3 * np.arange(1, count + 1), np.full(count, TRIANGLE)),
        ({"normals": vertices.normals, **vertices.scalars}, {"Normals": "normals"}),
        ({"face": tessellation.face, "part": tessellation.part, "patch": tessellation.patch}, {}),
        remarks,
    )


def _written(
    points: Float,
    cells: tuple[Int, Int, Int],
    point_data: tuple[Mapping[str, Float], Mapping[str, str]],
    cell_data: tuple[Mapping[str, Int], Mapping[str, str]],
    remarks: Sequence[str],
) -> bytes:
    """Return the file; data come with a map from VTK's attributes to the names of their arrays."""
    connectivity, offsets, types = cells
    root = ElementTree.Element(
        "VTKFile", type="UnstructuredGrid", version="1.0", byte_order="LittleEndian", header_type="UInt64"
    )
    grid = ElementTree.SubElement(root, "UnstructuredGrid")
    about = ElementTree.SubElement(grid, "FieldData")
    for number, remark in enumerate(remarks):
        # characters as numbers, so that no text can end what it stands in
        text = remark.encode("ascii", "backslashreplace") + b"\0"
        array = ElementTree.SubElement(
            about, "DataArray", type="String", Name=f"remark{number}", NumberOfTuples="1", format="ascii"
        )
        array.text = " ".join(str(byte) for byte in text)
    piece = ElementTree.SubElement(grid, "Piece", NumberOfPoints=str(len(points)), NumberOfCells=str(len(offsets)))
    for tag, (arrays, attributes) in (("PointData", point_data), ("CellData", cell_data)):
        element = ElementTree.SubElement(piece, tag, dict(attributes))
        for name, values in arrays.items():
            _append(element, name, values)
    _append(ElementTree.SubElement(piece, "Points"), "Points", points)
    element = ElementTree.SubElement(piece, "Cells")
    _append(element, "connectivity", connectivity)
    _append(element, "offsets", offsets)
    _append(element, "types", types.astype(np.uint8))
    ElementTree.indent(root, " ")
    stream = io.BytesIO()
    ElementTree.ElementTree(root).write(stream, "utf-8", xml_declaration=True)
    return stream.getvalue() + b"\n"


def _append(parent: ElementTree.Element, name: str, values: Any) -> None:
    """Append an array, its bytes with their number before them in base 64."""
    array = np.ascontiguousarray(values)
    array = array.astype(array.dtype.newbyteorder("<"))
    element = ElementTree.SubElement(parent, "DataArray", type=_TYPES[array.dtype.str[1:]], Name=name)
    if array.ndim == 2:
        element.set("NumberOfComponents", str(array.shape[1]))
    element.set("format", "binary")
    data = array.tobytes()
    element.text = base64.b64encode(len(data).to_bytes(8, "little") + data).decode("ascii")
