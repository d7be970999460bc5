"""The document: title page, chapters and the files they show."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from testbed.harness.results import Results
from testbed_reports.formatting import counted
from testbed_reports.pdf.appendix import HASH, appendix
from testbed_reports.pdf.blocks import Block, Name, Reference, Run, Runs, encoded, runs
from testbed_reports.pdf.dataset_pages import datasets
from testbed_reports.pdf.figures import Figures, figures, files
from testbed_reports.pdf.opening import orders, summary, verdicts
from testbed_reports.pdf.scheme_pages import Description, descriptions, schemes
from testbed_reports.view import Page, view

#: What every document is called.
TITLE: Final = "Surface schemes compared"


@dataclass(frozen=True)
class Document:
    """A document.

    Parameters
    ----------
    title, subtitle
        On the title page.
    facts
        How the results were made: names with texts.
    blocks
        Everything after the table of contents.
    files
        Pictures and plots by name.
    """

    title: str
    subtitle: Runs
    facts: tuple[tuple[str, Runs], ...]
    blocks: tuple[Block, ...]
    files: Mapping[str, bytes]

    def to_json(self) -> str:
        """Return all but the files as JSON, for the template."""
        parts = {
            "title": self.title,
            "subtitle": encoded(self.subtitle),
            "facts": encoded(self.facts),
            "blocks": encoded(self.blocks),
        }
        return json.dumps(parts, ensure_ascii=False, separators=(",", ":"))


def document(results: Results, jobs: int | None = None) -> Document:
    """Return the document of results, finished or not; its surfaces are fitted again and drawn.

    Parameters
    ----------
    results
        The results.
    jobs
        Worker processes; one a processor if None.
    """
    page = view(results)
    return composed(results, page, figures(results, page, jobs), descriptions(results))


def composed(results: Results, page: Page, drawn: Sequence[Figures], described: Sequence[Description]) -> Document:
    """Return the document of a page, its figures and what the schemes say of themselves."""
    blocks: list[Block] = [*summary(page), *verdicts(page)]
    if page.sections:
        blocks += [*orders(page), *datasets(page, tuple(drawn))]
    blocks += [*schemes(page, described, results.plan.schemes, drawn), *appendix(page)]
    subtitle = f"{counted(len(page.schemes), 'scheme')} on {counted(len(page.sections), 'dataset')}"
    return Document(TITLE, runs(subtitle), _facts(page), tuple(blocks), files(page, drawn))


def _facts(page: Page) -> tuple[tuple[str, Runs], ...]:
    facts = [(name, runs(Name(text) if name == "Command" else text)) for name, text in page.facts]
    return (*facts, ("Sources", tuple(_sources(page))))


def _sources(page: Page) -> list[Run]:
    """One hash a kind of plugins, made of those of its plugins, which the appendix has."""
    parts: list[str | Run] = []
    for kind, hashes in page.hashes:
        digest = hashlib.sha256(
            "".join(f"{name} {source}\n" for name, source in hashes).encode("utf-8", "backslashreplace")
        )
        parts += [f"{kind} ", Name(digest.hexdigest()[:HASH]), ", "]
    return list(runs(*parts, "each in ", Reference("sources"), "."))
