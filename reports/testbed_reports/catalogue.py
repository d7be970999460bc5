"""The catalogue as a page: every scheme and boundary curve, what each claims and what came of checking it."""

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from testbed.conformance.catalogue import Card, Findings, patch_words, stored_words
from testbed.conformance.subject import Status
from testbed.plugins.not_built import NotBuilt


@dataclass(frozen=True)
class SchemeEntry:
    """A scheme in the catalogue.

    Parameters
    ----------
    card
        What it says of itself.
    findings
        What came of checking it, or None if that could not be done.
    trouble
        Why it could not.
    """

    card: Card
    findings: Findings | None
    trouble: str = ""

    @property
    def patches(self) -> str:
        """What a face becomes, in words."""
        return patch_words(self.findings.profile) if self.findings and self.findings.profile else ""

    @property
    def stored(self) -> str:
        """What is stored over a face, in words."""
        return stored_words(self.findings.profile) if self.findings and self.findings.profile else ""

    @property
    def numbers(self) -> str:
        """How many numbers are stored over a face."""
        return f"{self.findings.profile.numbers:.4g}" if self.findings and self.findings.profile else ""

    @property
    def cost(self) -> str:
        """Cost of a jet in cubic triangles."""
        return f"{self.findings.profile.cost:g}" if self.findings and self.findings.profile else ""

    @property
    def verdict(self) -> str:
        """What the checks say together: ``14 passed``, ``1 failed``; the trouble where there are none."""
        if self.findings is None:
            return self.trouble
        counts = ((self.findings.count(status), status.value) for status in Status if status is not Status.NOT_CLAIMED)
        return ", ".join(f"{count} {word}" for count, word in counts if count)


def to_json(schemes: Sequence[SchemeEntry], curves: Sequence[Card], not_built: Sequence[NotBuilt]) -> str:
    """Return the catalogue as JSON."""
    record = {
        "schemes": [{**dataclasses.asdict(one), "findings": _plain(one.findings)} for one in schemes],
        "curves": [dataclasses.asdict(one) for one in curves],
        "not_built": [dataclasses.asdict(one) for one in not_built],
    }
    return json.dumps(record, indent=1, ensure_ascii=False) + "\n"


def _plain(found: Findings | None) -> object:
    if found is None:
        return None
    outcomes = [{**dataclasses.asdict(one), "status": one.status.value} for one in found.outcomes]
    return {"profile": found.profile and dataclasses.asdict(found.profile), "outcomes": outcomes}


def render(schemes: Sequence[SchemeEntry], curves: Sequence[Card], not_built: Sequence[NotBuilt]) -> str:
    """Return the page as HTML; whatever plugins say is text in it."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    folder = files("testbed_reports")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["paragraphs"] = paragraphs
    template = environment.from_string(folder.joinpath("catalogue.html.j2").read_text("utf-8"))
    stylesheet = Markup(folder.joinpath("page.css").read_text("utf-8"))  # noqa: S704 - ours
    text = template.render(schemes=schemes, curves=curves, not_built=not_built, stylesheet=stylesheet)
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of a docstring; one that is indented is a display, set as it stands."""

    text: str
    display: bool


def paragraphs(documentation: str) -> tuple[Paragraph, ...]:
    """Return the paragraphs of a docstring, without the marks of its markup."""
    found = []
    for block in documentation.split("\n\n"):
        display = block.startswith("    ")
        text = block if display else " ".join(block.split())
        found.append(Paragraph(text.replace("**", "").replace("``", "").replace(":func:", ""), display))
    return tuple(found)
