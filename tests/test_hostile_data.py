"""Hostile data, from mesh to measures and from file to command line: refused in a sentence, or measured."""

import dataclasses
import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from math import isnan
from pathlib import Path

import numpy as np
import pytest
from hostile_meshes import Data, hostile_mesh_data, tangential_forms
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from testbed import registry
from testbed.errors import MeshError, Refused, SpecError
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import norm, unit
from testbed.harness.plan import make_plan
from testbed.harness.results import read_results
from testbed.harness.run import run
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.measure import Measure, measure_all
from testbed.plugins.scheme import Scheme

SCHEMES = tuple(registry.catalogue(Scheme).values())  # type: ignore[type-abstract]
MEASURES = tuple(registry.catalogue(Measure).values())  # type: ignore[type-abstract]
CURVES = tuple(curve() for curve in registry.catalogue(BoundaryCurve).values())  # type: ignore[type-abstract]

#: Generated data sets.
EXAMPLES = 200
#: Seconds that one of them may take with all schemes and measures, some hundred times what it takes: a hang guard.
LONGEST = 30.0
#: Places that a sentence may name, and words that say what to do.
PLACE = re.compile(r"\b(vertex|vertices|faces?|edges?|points|normals?|second forms?|fundamental forms)\b")
ADVICE = re.compile(
    r"\b(check|correct|flip|give|leave|let|make|mend|move|put|refine|remove|replace|reverse|scale|turn|use|install)\b"
)


def check_clear(sentence: str) -> None:
    """One line, a place, and what to do behind the colon."""
    _, _, advice = sentence.partition(": ")
    assert "\n" not in sentence
    assert len(sentence) < 400
    assert PLACE.search(sentence), sentence
    assert ADVICE.search(advice), sentence
    assert "Error" not in sentence


def all_measures() -> list[Measure]:
    """All that are registered, their searches in few patches only: the meshes here have few."""
    smaller = {"budget": 2000, "candidates": 12}
    result = []
    for measure in MEASURES:
        names = {field.name for field in dataclasses.fields(measure)}
        result.append(measure(**{name: value for name, value in smaller.items() if name in names}))
    return result


def all_schemes(boundary: BoundaryCurve) -> list[Scheme]:
    """All that are registered, with this curve where they take one."""
    return [
        scheme(**{"boundary": boundary} if "boundary" in {field.name for field in dataclasses.fields(scheme)} else {})
        for scheme in SCHEMES
    ]


def outcome(scheme: Scheme, mesh: HermiteMesh, measures: list[Measure]) -> str:
    """``refused`` or ``measured``; whatever else is raised is a traceback to the user and fails the test."""
    try:
        surface = scheme.fit(mesh)
    except Refused as refusal:
        check_clear(refusal.reason)
        return "refused"
    values = measure_all(measures, surface, None)
    undefined = [name for name, value in values.items() if isinstance(value, float) and isnan(value)]
    assert not undefined, f"{scheme}: NaN in {', '.join(undefined)}"
    return "measured"


def with_centres(mesh: HermiteMesh) -> HermiteMesh:
    """Give quadrilaterals samples at their centres, as hostile as the data at their corners of which they are means."""
    if mesh.sides == 3 or mesh.second_forms is None:
        return mesh
    sums = mesh.corner_normals().sum(axis=1)
    length = norm(sums)
    normals = np.where((length > 1e-3)[:, None], unit(sums), mesh.corner_normals()[:, 0])
    forms = tangential_forms(mesh.corner_second_forms().mean(axis=1), normals)
    centres = Centres(mesh.corner_points().mean(axis=1), normals, forms)
    return HermiteMesh(mesh.points, mesh.faces, mesh.normals, mesh.second_forms, face_data=FaceData(centres))


def test_hostile_data_are_refused_in_a_clear_sentence_or_measured() -> None:
    measures = all_measures()
    found: Counter[str] = Counter()

    @settings(
        max_examples=EXAMPLES,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate],  # shrinking says little about meshes that are drawn from a seed
        suppress_health_check=list(HealthCheck),
    )
    @given(
        st.one_of(
            hostile_mesh_data(),
            hostile_mesh_data(quads=False),
            *(2 * [hostile_mesh_data(broken=False, quads=False)]),
            hostile_mesh_data(broken=False, quads=True),
        ),
        st.sampled_from(CURVES),
    )
    def every_example_is_refused_or_measured(data: Data, boundary: BoundaryCurve) -> None:
        start = time.monotonic()
        found["data"] += 1
        try:
            mesh = with_centres(HermiteMesh(**data))
        except MeshError as refusal:
            check_clear(str(refusal))
            found["mesh refused"] += 1
        else:
            for scheme in all_schemes(boundary):
                found[f"{outcome(scheme, mesh, measures)} by {scheme.name}"] += 1
        assert time.monotonic() - start < LONGEST

    every_example_is_refused_or_measured()
    # the generated data are neither all hopeless nor all harmless
    assert found["data"] >= EXAMPLES
    assert found["mesh refused"] > EXAMPLES // 20
    for scheme in SCHEMES:
        assert found[f"measured by {scheme.name}"] > EXAMPLES // 50, found
        assert found[f"refused by {scheme.name}"] > 0, found


def ply(vertices: list[tuple[float, ...]], faces: list[tuple[int, ...]]) -> bytes:
    head = [
        *("ply", "format ascii 1.0", f"element vertex {len(vertices)}"),
        *(f"property double {name}" for name in "xyz"),
        *(f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"),
    ]
    rows = [*vertices, *((len(face), *face) for face in faces)]
    return "\n".join([*head, *(" ".join(map(str, row)) for row in rows), ""]).encode()


POINTS: list[tuple[float, ...]] = [(0, 0, 0), (1, 0, 0.1), (0, 1, 0.1), (1, 1, 0.5)]
FACES: list[tuple[int, ...]] = [(0, 1, 2), (1, 3, 2)]
MEASURED = {
    "needle.ply": ply([(0, 0, 0), (1, 0, 0), (1, 1e-9, 0)], [(0, 1, 2)]),
    "one face.ply": ply(POINTS[:3], FACES[:1]),
    "huge.ply": ply([tuple(1e30 * x for x in point) for point in POINTS], FACES),
    "a[b=1],(c) \"d\" 'e' é☃.ply": ply(POINTS, FACES),
    "[x]<b>&amp;.ply": ply(POINTS, FACES),
    "new\nline.ply": ply(POINTS, FACES),
}
#: Files, and what their reasons tell besides the name.
REFUSED = {
    "nan.ply": (ply([(0, 0, float("nan")), *POINTS[1:]], FACES), "at vertex 0: replace NaN"),
    "beyond.ply": (ply(POINTS, [FACES[0], (1, 9, 2)]), "face 1 has vertex 9"),
    "negative.ply": (ply(POINTS, [FACES[0], (1, -3, 2)]), "face 1 has vertex -3"),
    "three.ply": (ply([*POINTS, (2, 0, 3)], [*FACES, (1, 2, 4)]), "a side of 3 faces 0, 1 and 2"),
    "line.ply": (ply([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)]), "face 0 (vertices 0, 1, 2) is degenerate"),
    "stray.ply": (ply([*POINTS, (9, 9, 9)], FACES), "vertex 4 is in no face"),
    "large.ply": (ply([tuple(1e40 * x for x in point) for point in POINTS], FACES), "scale the points down"),
    "faceless.ply": (ply(POINTS, []), "holds no faces"),
    "cut.ply": (ply(POINTS, FACES)[:-30], "check that the file is complete"),
    "lies.ply": (ply(POINTS, FACES).replace(b"vertex 4", b"vertex 4000000000"), "check that the file is complete"),
    **{
        f"empty.{kind}": (b"", "check that the file is complete") for kind in ("ply", "obj", "stl", "off", "glb", "npz")
    },
    **{
        f"garbage.{kind}": (bytes(range(256)) * 3, "check that the file is complete")
        for kind in ("ply", "stl", "obj", "off", "glb", "npz")
    },
    "nosuffix": (ply(POINTS, FACES), "has no suffix of a mesh format: use one of"),
}
HARMLESS = ["flat", "pn-triangle", "nielson"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, content in {**MEASURED, **{name: content for name, (content, _) in REFUSED.items()}}.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_hostile_files_are_refused_in_a_sentence_or_measured(folder: Path) -> None:
    plan = make_plan(HARMLESS, [f"mesh:{name}" for name in (*MEASURED, *REFUSED)])
    foreseen = {cell.dataset.removeprefix("mesh:") for cell in plan.cells if cell.foreseen}
    assert foreseen == set(REFUSED)
    run(plan, folder / "out", jobs=1)
    cells = read_results(folder / "out").cells
    assert len(cells) == len(HARMLESS) * (len(MEASURED) + len(REFUSED))
    for scheme, dataset, status, reason in cells[["scheme", "dataset", "status", "reason"]].itertuples(index=False):
        name = dataset.removeprefix("mesh:")
        name = json.loads(name) if name.startswith('"') else name
        if name in MEASURED:
            assert (status, reason) == ("ok", ""), (scheme, dataset, reason)
        else:
            assert status == "refused", (scheme, dataset, reason)
            assert reason.startswith(name)
            assert REFUSED[name][1] in reason
            assert "\n" not in reason
            assert ": " in reason
    measured = cells[cells["status"] == "ok"]
    for column in ("epsilon_deg", "gauss_min", "gauss_max", "mean_min", "mean_max", "h", "gap_max"):
        assert np.isfinite(measured[column]).all(), column


def test_the_command_line_shows_hostile_files_without_a_traceback(folder: Path) -> None:
    names = ["nan.ply", "three.ply", "empty.obj", "garbage.stl", "new\nline.ply", "[x]<b>&amp;.ply"]
    datasets = [part for name in names for part in ("-d", f"mesh:{name}")]
    result = command_line("run", "-s", "flat", *datasets, "-o", "out")
    assert result.returncode == 0, result.stderr
    assert "2 ok, 4 refused" in result.stdout
    for words in ("nan.ply", "at vertex 0: replace NaN", "is not manifold", "garbage.stl"):
        assert words in " ".join(result.stdout.split())
    assert "Traceback" not in result.stdout + result.stderr
    assert (folder / "out" / "index.html").stat().st_size > 0


def test_what_is_no_file_is_bad_usage_and_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    for name, why in {"folder.ply": "not a file", "pipe.ply": "not a file", "none.ply": "No such file"}.items():
        with pytest.raises(SpecError, match=rf"{name}.*{why}.*: (give|check) the path") as error:
            make_plan(["flat"], [f"mesh:{name}"])
        assert "\n" not in str(error.value)
    result = command_line("plan", "-s", "flat", "-d", "mesh:pipe.ply")
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1


def command_line(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from testbed.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)  # noqa: S603
