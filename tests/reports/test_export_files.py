"""Files of surfaces read back: by trimesh, as XML, by hand; what they hold is the surface, and the same bytes again."""

import base64
import json
import struct
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

import testbed
from testbed import registry
from testbed.errors import SpecError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed_reports.export.formats import SUFFIXES, export_surface
from testbed_reports.export.ply import one_line
from testbed_reports.export.tessellation import tessellate
from testbed_reports.export.vertices import by_patch, by_place
from testbed_reports.rendering.colouring import MISSING, palette

HOSTILE = "<b>&--></remark>]]>\n\rend_header\nply \x1b[0m é ☃ \\ \"'"
ARRAYS = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}


def sample(scheme: str = "cubic-interpolant", dataset: str = "octahedron") -> tuple[Surface, ExactSurface | None]:
    found = registry.dataset(dataset)
    return registry.scheme(scheme).fit(found.mesh(0)), found.surface


def read_vtu(path: Path) -> dict[str, Any]:
    """Return the arrays of a grid by name, and the attributes of its sections."""
    root = ElementTree.parse(path).getroot()  # noqa: S314 - our own file
    assert root.attrib["type"] == "UnstructuredGrid"
    assert (root.attrib["byte_order"], root.attrib["header_type"]) == ("LittleEndian", "UInt64")
    found: dict[str, Any] = {}
    for section in ("PointData", "CellData", "Points", "Cells"):
        element = root.find(f"UnstructuredGrid/Piece/{section}")
        assert element is not None
        found[section] = dict(element.attrib)
        for array in element:
            data = base64.b64decode(array.text or "")
            assert int.from_bytes(data[:8], "little") == len(data) - 8
            values = np.frombuffer(data[8:], ARRAYS[array.attrib["type"]])
            width = array.attrib.get("NumberOfComponents")
            found[array.attrib["Name"]] = values if width is None else values.reshape(-1, int(width))
    piece = root.find("UnstructuredGrid/Piece")
    assert piece is not None
    assert int(piece.attrib["NumberOfPoints"]) == len(found["Points"])
    assert int(piece.attrib["NumberOfCells"]) == len(found["types"])
    found["remarks"] = [
        bytes(map(int, (array.text or "").split())).rstrip(b"\0").decode("ascii")
        for array in root.findall("UnstructuredGrid/FieldData/DataArray")
    ]
    return found


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_surface_gives_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    for name in ("one", "other"):
        surface, exact = sample("hansford")
        export_surface(surface, tmp_path / f"{name}{suffix}", exact=exact, title="what it is")
    one, other = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("one", "other"))
    assert one == other
    assert len(one) > 1000


@pytest.mark.parametrize("split", [False, True])
def test_ply_keeps_every_field_to_the_last_bit(split: bool, tmp_path: Path) -> None:
    surface, exact = sample()
    written = export_surface(
        surface, tmp_path / "a.ply", exact=exact, triangles=300, split=split, title="cubic-interpolant on octahedron"
    )
    one = tessellate(surface, 300, exact)
    expected = by_patch(one) if split else by_place(one)
    read = trimesh.load_mesh(tmp_path / "a.ply", process=False)
    np.testing.assert_array_equal(read.vertices, expected.points)
    np.testing.assert_array_equal(read.faces, expected.triangles)
    raw = read.metadata["_ply_raw"]
    table = raw["vertex"]["data"]
    np.testing.assert_array_equal(np.stack([table[name] for name in ("nx", "ny", "nz")], axis=-1), expected.normals)
    assert set(expected.scalars) >= {"gauss", "mean", "distance"}
    for name, values in expected.scalars.items():
        np.testing.assert_array_equal(table[name], values)
    for name in ("face", "part", "patch"):
        np.testing.assert_array_equal(raw["face"]["data"][name], getattr(one, name))
    if not split:
        assert read.is_watertight
        assert read.euler_number == 2
        assert read.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.05)
    header = (tmp_path / "a.ply").read_bytes().split(b"end_header\n")[0].decode("ascii")
    assert "comment cubic-interpolant on octahedron\n" in header
    for remark in written.remarks:
        assert f"comment {remark}\n" in header
    assert ("means of the patches'" in header) != split


def read_obj(path: Path) -> tuple[Float, Float, "np.ndarray[Any, Any]", "np.ndarray[Any, Any]"]:
    """Return positions, normals, and ids of both at the corners of the triangles."""
    lines = [line.split() for line in path.read_text("ascii").splitlines()]
    points, normals = (
        np.array([[float(word) for word in words] for key, *words in lines if key == name]) for name in ("v", "vn")
    )
    corners = np.array([[word.split("//") for word in words] for key, *words in lines if key == "f"], dtype=np.int64)
    return points, normals, corners[..., 0] - 1, corners[..., 1] - 1


@pytest.mark.parametrize(("scheme", "is_smooth"), [("cubic-interpolant", False), ("shirman-sequin", True)])
def test_obj_shares_positions_and_keeps_the_normals_of_every_patch(
    scheme: str, is_smooth: bool, tmp_path: Path
) -> None:
    surface, _ = sample(scheme, "torus")
    export_surface(surface, tmp_path / "a.obj", triangles=2000, title="a title")
    one = tessellate(surface, 2000)
    points, normals, corners, of_corners = read_obj(tmp_path / "a.obj")
    order = np.argsort(one.face, kind="stable")
    np.testing.assert_array_equal(points[corners], one.points[one.triangles][order])
    np.testing.assert_allclose(normals[of_corners], one.normals[one.triangles][order], rtol=0, atol=1e-10)
    assert len(points) == one.place.max() + 1
    assert (len(normals) < 1.01 * len(points)) == is_smooth
    assert "# OBJ has no fields: curvatures and distances are left out\n" in (tmp_path / "a.obj").read_text()
    read = trimesh.load_mesh(tmp_path / "a.obj", process=False, maintain_order=True)
    assert len(read.faces) == len(corners)
    assert read.area == pytest.approx(trimesh.Trimesh(points, corners, process=False).area)


def read_glb(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the header and the arrays of the one mesh, taken apart by hand."""
    data = path.read_bytes()
    magic, version, length, size = struct.unpack("<4sIII", data[:16])
    assert (magic, version, length) == (b"glTF", 2, len(data))
    header = json.loads(data[20 : 20 + size])
    binary = data[28 + size :]
    types = {5121: "u1", 5125: "<u4", 5126: "<f4"}
    widths = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
    (primitive,) = header["meshes"][0]["primitives"]
    arrays = {}
    for name, index in {**primitive["attributes"], "indices": primitive["indices"]}.items():
        accessor = header["accessors"][index]
        begin = header["bufferViews"][accessor["bufferView"]]["byteOffset"] + accessor.get("byteOffset", 0)
        count = accessor["count"] * widths[accessor["type"]]
        arrays[name] = np.frombuffer(binary, types[accessor["componentType"]], count, begin).reshape(
            accessor["count"], -1
        )
    return header, arrays


def shown_colours(linear: "np.ndarray[Any, Any]") -> Float:
    """Colours on a screen, from 0 to 1, of glTF's vertex colours."""
    light = linear[:, :3] / 255.0
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)


def test_glb_has_exact_normals_and_the_colours_of_a_field(tmp_path: Path) -> None:
    surface, exact = sample("shirman-sequin")
    export_surface(surface, tmp_path / "a.glb", exact=exact, triangles=1000, field="gauss", limit=3.0, title="a title")
    header, arrays = read_glb(tmp_path / "a.glb")
    one = tessellate(surface, 1000)
    corners = arrays["indices"].reshape(-1, 3)
    np.testing.assert_array_equal(arrays["POSITION"][corners], one.points[one.triangles].astype(np.float32))
    np.testing.assert_allclose(arrays["NORMAL"][corners], one.normals[one.triangles], rtol=0, atol=2e-7)
    # a vertex has the colour that the map gives to its curvature
    t = ((one.gauss + 3.0) / 6.0).clip(0.0, 1.0)
    expected = palette("gauss")[np.round(255 * t).astype(int)][one.triangles]
    assert np.abs(shown_colours(arrays["COLOR_0"])[corners] - expected).max() < 0.012
    assert len(np.unique(arrays["COLOR_0"], axis=0)) > 10
    extras = header["asset"]["extras"]
    assert (extras["field"], extras["low"], extras["high"]) == ("gauss", -3.0, 3.0)
    assert extras["remarks"][0] == "a title"
    (material,) = header["materials"]
    assert material["pbrMetallicRoughness"]["metallicFactor"] == 0.0
    # the scene is upright in a world whose y points upwards
    lifted = trimesh.load_scene(tmp_path / "a.glb", process=False).to_mesh()
    x, y, z = arrays["POSITION"].T
    np.testing.assert_allclose(lifted.vertices, np.stack([x, z, -y], axis=-1), rtol=0, atol=1e-6)
    assert lifted.volume > 3.0
    read = trimesh.load_mesh(tmp_path / "a.glb", process=False)
    read.merge_vertices(merge_tex=True, merge_norm=True)
    assert read.is_watertight
    assert read.euler_number == 2


def test_glb_splits_vertices_at_creases_only_and_their_positions_stay_equal(tmp_path: Path) -> None:
    counts = {}
    for scheme in ("flat", "shirman-sequin"):
        surface, _ = sample(scheme)
        export_surface(surface, tmp_path / "a.glb", triangles=600)
        _, arrays = read_glb(tmp_path / "a.glb")
        counts[scheme] = len(arrays["POSITION"]), len(np.unique(arrays["POSITION"], axis=0))
        np.testing.assert_allclose(norm(arrays["NORMAL"].astype(float)), 1.0, rtol=0, atol=1e-6)
    assert counts["flat"][0] == 8 * 45  # every vertex lies on one face, 8 steps a side
    assert counts["flat"][1] == 4 * 64 + 2
    assert counts["shirman-sequin"][0] == counts["shirman-sequin"][1]


def test_points_without_curvature_have_the_colour_of_their_surroundings_and_are_counted(tmp_path: Path) -> None:
    surface, _ = sample("nielson")
    written = export_surface(surface, tmp_path / "a.glb", triangles=600, field="mean")
    _, arrays = read_glb(tmp_path / "a.glb")
    missing = np.abs(shown_colours(arrays["COLOR_0"]) - MISSING).max(axis=1) < 0.02
    assert not missing.any()
    assert any("24 points of patches without a mean curvature" in remark for remark in written.remarks)


def test_a_tessellated_vtu_has_the_fields_of_the_ply(tmp_path: Path) -> None:
    surface, exact = sample()
    export_surface(surface, tmp_path / "a.vtu", exact=exact, triangles=300, tessellated=True, title="a title")
    grid, one = read_vtu(tmp_path / "a.vtu"), tessellate(surface, 300, exact)
    expected = by_place(one)
    np.testing.assert_array_equal(grid["Points"], expected.points)
    np.testing.assert_array_equal(grid["normals"], expected.normals)
    assert grid["PointData"] == {"Normals": "normals"}
    for name, values in expected.scalars.items():
        np.testing.assert_array_equal(grid[name], values)
    np.testing.assert_array_equal(grid["connectivity"].reshape(-1, 3), expected.triangles)
    np.testing.assert_array_equal(grid["offsets"], 3 * np.arange(1, len(one.triangles) + 1))
    assert set(grid["types"].tolist()) == {5}
    np.testing.assert_array_equal(grid["face"], one.face)
    assert grid["remarks"][0] == "a title"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_names_are_text_wherever_they_stand(suffix: str, tmp_path: Path) -> None:
    surface, _ = sample()
    path = tmp_path / f"a{suffix}"
    export_surface(surface, path, triangles=None if suffix in (".vtu", ".npz") else 100, title=HOSTILE)
    if suffix == ".vtu":
        assert read_vtu(path)["remarks"] == [HOSTILE.encode("ascii", "backslashreplace").decode("ascii")]
    elif suffix == ".npz":
        with np.load(path, allow_pickle=False) as stored:
            assert stored["remarks"].tolist() == [HOSTILE]
    elif suffix == ".glb":
        assert read_glb(path)[0]["asset"]["extras"]["remarks"][0] == HOSTILE
    else:
        assert len(trimesh.load_mesh(path, process=False).faces) == 72
        mark = b"comment " if suffix == ".ply" else b"# "
        assert mark + one_line(HOSTILE).encode() + b"\n" in path.read_bytes()


def test_control_nets_read_back_with_their_places(tmp_path: Path) -> None:
    for scheme in ("hansford", "peters"):
        surface, _ = sample(scheme, "torus" if scheme == "peters" else "octahedron")
        export_surface(surface, tmp_path / "a.npz")
        with np.load(tmp_path / "a.npz", allow_pickle=False) as stored:
            assert stored["parts"] == len(surface.parts)
            for index, part in enumerate(surface.parts):
                assert (f"part{index}_weights" in stored) == hasattr(part.batch, "weights")
                for name in ("control_points", "weights"):
                    if hasattr(part.batch, name):
                        np.testing.assert_array_equal(stored[f"part{index}_{name}"], getattr(part.batch, name))
                for name in ("corner_ids", "faces", "corners_in_face"):
                    np.testing.assert_array_equal(stored[f"part{index}_{name}"], getattr(part, name))
            np.testing.assert_array_equal(stored["mesh_points"], surface.mesh.points)
            np.testing.assert_array_equal(stored["mesh_faces"], surface.mesh.faces)


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("a.stl", {}, "does not end in the name of a format: take .glb"),
        ("a.glb", {"field": "torsion"}, "there is no field 'torsion': take gauss"),
        ("a.glb", {"field": "distance"}, "no exact surface"),
        ("a.glb", {"limit": 2.0}, "positive number, with a field"),
        ("a.glb", {"field": "gauss", "limit": np.nan}, "limit nan"),
        ("a.ply", {"field": "gauss"}, "colours of .glb files"),
        ("a.ply", {"triangles": 0}, "ask for 1 to"),
        ("a.npz", {"triangles": 7}, "leave out the number of triangles"),
        ("a.vtu", {"triangles": 7}, "leave out the number of triangles"),
        ("a.vtu", {"split": True}, "leave it out"),
        ("a.obj", {"split": True}, "leave it out"),
        ("a.glb", {"tessellated": True}, "leave it out"),
    ],
)
def test_an_option_that_says_nothing_in_a_format_is_refused(
    name: str, options: dict[str, Any], words: str, tmp_path: Path
) -> None:
    surface, _ = sample()
    with pytest.raises(SpecError, match=words) as caught:
        testbed.export_surface(surface, tmp_path / name, **options)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())
