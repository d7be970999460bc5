"""The catalogue: what schemes and boundary curves say of themselves, and what was found on checking them.

Nothing is written down here that a plugin says of itself elsewhere: citation, formula, status and known failures are
its class attributes, parameters its fields with their documentation, verdicts those of the conformance suite.
"""

import dataclasses
import inspect
import re
import sys
import typing
from dataclasses import dataclass
from typing import Any

from testbed.conformance.profile import Profile, profile
from testbed.conformance.subject import Outcome, Status
from testbed.conformance.suite import check
from testbed.plugins.base import Plugin, format_value
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data, Scheme
from testbed.registry import scheme


@dataclass(frozen=True)
class Parameter:
    """A parameter of a plugin: its name, default value and type as texts, and what it does."""

    name: str
    default: str
    type: str
    meaning: str


@dataclass(frozen=True)
class Card:
    """What a plugin says of itself.

    Parameters
    ----------
    name, title, reference, formula, status, failures
        Its class attributes.
    summary
        The first sentence of its documentation.
    documentation
        The documentation of its module.
    needs, matches
        Data at the vertices that it reads, boundary curves included, and that its result matches.
    parameters
        Its parameters.
    claims
        Claims of a scheme in words: continuity, order, shapes; empty for curves.
    faces
        Faces that a scheme takes, in words; empty for curves.
    support
        How far a scheme's surface depends on the data, in words; empty for curves.
    network
        The boundary curves a scheme stands on, ``its own`` if it takes no others; empty for curves.
    """

    name: str
    title: str
    reference: str
    formula: str
    status: str
    failures: str
    summary: str
    documentation: str
    needs: str
    matches: str
    parameters: tuple[Parameter, ...]
    claims: tuple[str, ...] = ()
    faces: str = ""
    support: str = ""
    network: str = ""


@dataclass(frozen=True)
class Findings:
    """What came of a scheme: its profile, None if it took no mesh of the suite, and the checks."""

    profile: Profile | None
    outcomes: tuple[Outcome, ...]

    @property
    def refusals(self) -> str:
        """What the suite tells of refusals."""
        return next((one.detail for one in self.outcomes if one.property == "refuses what it cannot take"), "")

    def count(self, status: Status) -> int:
        """Return how many checks ended so."""
        return sum(one.status is status for one in self.outcomes)


def card(plugin: Plugin) -> Card:
    """Return what a scheme or a boundary curve says of itself, with the parameters it has."""
    kind = type(plugin)
    module = sys.modules[kind.__module__]
    common: dict[str, Any] = {
        "name": kind.name,
        "title": kind.title,
        "reference": kind.reference,
        "formula": plugin.formula,
        "status": plugin.status,
        "failures": plugin.failures,
        "summary": summary(kind),
        "documentation": inspect.cleandoc(module.__doc__ or ""),
        "parameters": parameters(plugin),
    }
    if isinstance(plugin, Scheme):
        curves = [one for one in plugin.nested() if isinstance(one, BoundaryCurve)]
        return Card(
            **common,
            needs=data_words(needs(plugin)),
            matches=data_words(plugin.matches),
            claims=claims(plugin),
            faces=" or ".join({3: "triangles", 4: "quadrilaterals"}[sides] for sides in plugin.domain),
            support=_SUPPORT.get(plugin.support, f"{plugin.support} rings of faces around it"),
            network=", ".join(map(str, curves)) or "its own",
        )
    if isinstance(plugin, BoundaryCurve):
        return Card(**common, needs=data_words(plugin.needs), matches=data_words(plugin.matches))
    return Card(**common, needs="", matches="")


_SUPPORT: dict[int | None, str] = {
    None: "the whole mesh",
    0: "the face's own vertices",
    1: "the faces next to it",
}


def findings(text: str) -> Findings:
    """Check a scheme and look at its surfaces; runs in a worker, as any plugin code."""
    one = scheme(text)
    return Findings(profile(one), check(one))


def patch_words(found: Profile) -> str:
    """Return what a face becomes: ``3 Bézier triangles of degree 4``."""
    parts = []
    for one in found.kinds:
        count = f"{one.per_face:.3g}"
        degree = f" of degree {one.degree}" if one.degree is not None else ""
        plural = re.sub(r"(triangle|patch)(?=$| )", lambda match: _PLURALS[match[1]], one.kind, count=1)
        parts.append(f"{count} {one.kind if one.per_face == 1.0 else plural}{degree}")
    return " and ".join(parts)


_PLURALS = {"triangle": "triangles", "patch": "patches"}


def stored_words(found: Profile) -> str:
    """Return what is stored over a face: ``45 control points, 135 numbers``."""
    points = f"{found.control_points:.3g} control points, " if found.control_points is not None else ""
    return f"{points}{found.numbers:.4g} numbers"


def needs(one: Scheme) -> Data:
    """Return the data that a scheme reads, with those its boundary curves read."""
    found = Data.POINTS
    for plugin in one.nested():
        found |= getattr(plugin, "needs", Data.POINTS)
    return found


def data_words(data: Data) -> str:
    """Return data in words: ``points, normals, second forms``."""
    return ", ".join(str(flag.name).lower().replace("_", " ") for flag in data)


def claims(one: Scheme) -> tuple[str, ...]:
    """Return what a scheme claims, in words."""
    order = [f"order {one.order:g}"] if one.order is not None else []
    return (one.continuity.value, *order, *(f"reproduces {shape.value}" for shape in one.reproduces))


def summary(kind: type[Plugin]) -> str:
    """Return the first paragraph of a class's documentation."""
    return " ".join(inspect.cleandoc(kind.__doc__ or "").split("\n\n")[0].split())


def parameters(plugin: Plugin) -> tuple[Parameter, ...]:
    """Return the parameters of a plugin with the meaning that the numpydoc section of its class gives."""
    hints = typing.get_type_hints(type(plugin))
    meanings = parameter_meanings(inspect.cleandoc(type(plugin).__doc__ or ""))
    return tuple(
        Parameter(
            field.name,
            format_value(getattr(plugin, field.name)),
            _type(hints[field.name]),
            meanings.get(field.name, ""),
        )
        for field in dataclasses.fields(plugin)
    )


def parameter_meanings(documentation: str) -> dict[str, str]:
    """Return the texts of the ``Parameters`` section of a numpydoc docstring by name."""
    match = re.search(r"^Parameters\n-+\n(.*?)(?=^\S[^\n]*\n-+\n|\Z)", documentation, re.DOTALL | re.MULTILINE)
    meanings: dict[str, str] = {}
    for names, text in re.findall(r"^(\S[^\n]*)\n((?:[ \t]+[^\n]*\n?|\n)*)", match[1] if match else "", re.MULTILINE):
        for name in names.split(":")[0].split(","):
            meanings[name.strip()] = " ".join(text.split())
    return meanings


def _type(hint: Any) -> str:
    if isinstance(hint, type) and issubclass(hint, Plugin):
        return "boundary curves" if issubclass(hint, BoundaryCurve) else hint.__name__
    if typing.get_origin(hint) is typing.Literal:
        return " or ".join(map(str, typing.get_args(hint)))
    return inspect.formatannotation(hint)
