"""The document: what stands on the title page, the pages after it, and the files they show."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from testbed.harness.results import Results
from testbed_reports.formatting import counted
from testbed_reports.pdf.appendix import HASH, appendix
from testbed_reports.pdf.blocks import Folio, Name, Run, Runs, runs
from testbed_reports.pdf.dataset_pages import datasets
from testbed_reports.pdf.figures import Figures, files
from testbed_reports.pdf.numbering import numbered
from testbed_reports.pdf.opening import opening
from testbed_reports.pdf.scheme_pages import Description, schemes
from testbed_reports.view import Page

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
    folios
        All pages after the table of contents.
    files
        Pictures and plots by name.
    """

    title: str
    subtitle: str
    facts: tuple[tuple[str, Runs], ...]
    folios: tuple[Folio, ...]
    files: Mapping[str, bytes]


def document(results: Results, page: Page, drawn: Sequence[Figures], described: Sequence[Description]) -> Document:
    """Return the document of results, finished or not.

    Parameters
    ----------
    results, page
        The results, and the page made of them.
    drawn
        The figures of each dataset.
    described
        What each scheme says of itself.
    """
    folios = (
        *opening(page),
        *datasets(page, drawn),
        *schemes(page, described, results.plan.schemes, drawn),
        *appendix(page),
    )
    subtitle = f"{counted(len(page.schemes), 'scheme')} on {counted(len(page.sections), 'dataset')}"
    return Document(TITLE, subtitle, _facts(page), numbered(folios), files(page, drawn))


def _facts(page: Page) -> tuple[tuple[str, Runs], ...]:
    facts = [(name, runs(Name(text) if name == "Command" else text)) for name, text in page.facts]
    return (*facts, ("Sources", tuple(_sources(page))))


def _sources(page: Page) -> list[Run]:
    """One hash a kind of plugins, made of those of its plugins, which the appendix has."""
    parts: list[str | Run] = []
    for kind, hashes in page.hashes:
        text = "".join(f"{name} {source}\n" for name, source in hashes)
        digest = hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()
        parts += [f"{kind} ", Name(digest[:HASH]), ", "]
    return list(runs(*parts[:-1], "; of each plugin in the appendix."))
