"""``approximate``: a known surface within given bounds, by a mesh that is refined where it has to be."""

import json
import math
import sys
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Final, get_args

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed import __version__, registry
from testbed.approximation.approximate import Limits, Target, approximate
from testbed.approximation.criteria import Criterion
from testbed.approximation.division import Splitting
from testbed.approximation.history import Approximation, Step
from testbed.approximation.longest_edge import LongestEdge
from testbed.approximation.record import outcome, write_approximation
from testbed.approximation.templates import Template
from testbed.cli.tables import wide
from testbed.errors import SpecError, TestbedError
from testbed.harness.run import LIBRARIES
from testbed.harness.sources import Sources
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Scheme
from testbed_reports.refinement_plot import write_history_plot, write_refinement_plot

#: How triangles can be split, by name.
SPLITTINGS: Final[dict[str, Splitting]] = {one.name: one for one in (Template(), LongestEdge())}


@dataclass(frozen=True)
class Task:
    """An approximation as asked for on the command line.

    Parameters
    ----------
    dataset, scheme
        Texts.
    epsilon
        Bound of the angle between normals, degrees.
    distance
        Bound of the distance, or None.
    split, criterion
        Names.
    steps, faces, angle
        Where to give up: refinements, faces, degrees.
    directory
        Where the results go.
    """

    dataset: str
    scheme: str
    epsilon: float
    distance: float | None
    split: str
    criterion: str
    steps: int
    faces: int
    angle: float
    directory: Path


def approximate_command(task: Task, *, as_json: bool) -> int:
    """Approximate, write the results and the pictures, and print the history.

    Returns
    -------
    code
        0 if all bounds were reached, else 1.
    """
    console = wide(stderr=as_json)
    if task.directory.exists() and not task.directory.is_dir():
        raise TestbedError(f"{task.directory} is a file: name a directory with -o")
    splitting = SPLITTINGS[_one_of("split", task.split, tuple(SPLITTINGS))]
    criterion: Criterion = _one_of("criterion", task.criterion, get_args(Criterion))
    target = Target(math.radians(task.epsilon), task.distance, criterion)
    limits = Limits(task.steps, task.faces, math.radians(task.angle))
    dataset, scheme = registry.dataset(task.dataset), registry.scheme(task.scheme)
    bounds = f"epsilon {task.epsilon:g} degrees" + (f", distance {task.distance:g}" if task.distance else "")
    with console.status("start mesh") as status:
        found = approximate(
            dataset,
            scheme,
            target,
            splitting=splitting,
            limits=limits,
            note=lambda step: status.update(f"{step.step} refinements, {step.faces} faces: {_bounds(step)}"),
        )
    console.print(f"{scheme} on {dataset}: {bounds}, in {task.directory}/", markup=False)
    written = list(write_approximation(task.directory, found, _origin(task, dataset, scheme)))
    title = f"{dataset}\n{scheme}"
    written.append(write_refinement_plot(task.directory, found, title))
    if found.history:
        written.append(write_history_plot(task.directory, found, title, task.epsilon, task.distance))
    if as_json:
        json.dump({**outcome(found), "written": list(map(str, written))}, sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        _print(console, found, task)
        for path in written:
            console.print(f"written: {path}", markup=False, soft_wrap=True)
    return int(not found.reached)


def _one_of(option: str, value: str, names: tuple[str, ...]) -> Any:
    if value not in names:
        raise SpecError(f"--{option} cannot be {value!r}: give {' or '.join(names)}")
    return value


def _origin(task: Task, dataset: Dataset, scheme: Scheme) -> dict[str, Any]:
    """Return what an approximation comes from, as JSON has it."""
    sources = Sources()
    return {
        "dataset": str(dataset),
        "scheme": str(scheme),
        "epsilon_deg": task.epsilon,
        "distance": task.distance,
        "split": task.split,
        "criterion": task.criterion,
        "limits": {"steps": task.steps, "faces": task.faces, "angle_deg": task.angle},
        "command": ["testbed", *sys.argv[1:]],
        "versions": {"testbed": __version__, **{name: metadata.version(name) for name in LIBRARIES}},
        "sources": {str(one): sources.content(one) for one in (dataset, scheme)},
    }


def _print(console: Console, found: Approximation, task: Task) -> None:
    table = Table(box=None, pad_edge=False)
    headings = (
        "step",
        "faces",
        "patches",
        "points",
        "shared",
        "epsilon °",
        "at ten °",
        "distance",
        "angle °",
        "split",
        "s",
    )
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for step in found.history:
        angle = _least(step.epsilon_deg, certified=step.epsilon_certified)
        apart = _least(step.distance, certified=step.distance_certified)
        if step.distance_certified:
            apart = f"{step.distance_found:.3g}..{apart}"
        table.add_row(
            str(step.step),
            str(step.faces),
            str(step.patches),
            _count(step.control_points),
            _count(step.shared_control_points),
            _marked(angle, step.epsilon_deg if task.criterion == "exact" else None, task.epsilon),
            _marked(
                f"{step.epsilon_sampled_deg:.3g}",
                step.epsilon_sampled_deg if task.criterion == "sampled" else None,
                task.epsilon,
            ),
            _marked(apart, step.distance if task.distance else None, task.distance or math.inf),
            f"{step.smallest_angle_deg:.1f}",
            str(step.edges_split),
            f"{step.seconds:.2f}",
        )
    console.print(table)
    levels = ", ".join(
        f"{count} of level {level}" for level, count in enumerate(outcome(found)["faces_by_level"]) if count
    )
    console.print(f"faces: {levels}", highlight=False)
    for kind, count in sorted((found.surface.notes if found.surface else {}).items()):
        console.print(f"fallbacks on the last mesh: {count} {kind}", markup=False)
    for line in _uncertified(found, task):
        console.print(line, markup=False)
    style = "green" if found.reached else "bold red"
    verdict = "reached" if found.reached else f"not reached ({found.stop})"
    console.print(f"[{style}]{verdict}[/]: {escape(found.reason)}", highlight=False)


def _uncertified(found: Approximation, task: Task) -> list[str]:
    """Return what is not guaranteed about the last surface, a line each."""
    if not found.history:
        return []
    last, lines = found.history[-1], []
    if not last.epsilon_certified:
        lines.append("~ epsilon is sampled and searched only: there is no guaranteed bound for patches of this kind")
    if task.distance is None:
        lines.append("~ distances are sampled only: --distance asks for a bound of them")
    elif not last.distance_certified:
        lines.append(
            "~ distances are not guaranteed: faces without a known bound, because of the exact surface or the kind of "
            "patches, are sampled only"
        )
    return lines


def _bounds(step: Step) -> str:
    return f"epsilon {step.epsilon_deg:.3g} degrees, distance {step.distance:.3g}"


def _least(value: float, *, certified: bool) -> str:
    return f"{value:.3g}" if certified else f"~{value:.3g}"


def _marked(text: str, value: float | None, bound: float) -> str:
    """Return a number in colour where a bound is asked of it."""
    return text if value is None else f"[green]{text}[/]" if value <= bound else f"[yellow]{text}[/]"


def _count(value: int | None) -> str:
    return "-" if value is None else str(value)
