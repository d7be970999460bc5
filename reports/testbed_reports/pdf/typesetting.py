"""From a document to a PDF, by typst: with its own fonts and matplotlib's, without the system's, and without a time.

Typst keeps all it has set in memory until the end, so that hundreds of pages take gigabytes. Every folio is set by
itself, in worker processes, and tells where its headings, references and what they lead to are; then the folios are
bound into one file with title page, contents, page numbers and links.
"""

import json
import re
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from testbed.errors import TestbedError
from testbed_reports.pdf import lettering
from testbed_reports.pdf.blocks import Folio, Heading, Picture, Plots, Swatch, encoded
from testbed_reports.pdf.document import Document
from testbed_reports.pdf.figures import swatch_file
from testbed_reports.pdf.pool import Lost, Pool

if TYPE_CHECKING:
    import typst

#: The templates in this package: what both others draw blocks with, a folio, and the whole.
SHARED: Final = "blocks.typ"
FOLIO: Final = "folio.typ"
WHOLE: Final = "binding.typ"
#: Compilations that typst keeps what it has set for.
KEPT: Final = 10


@dataclass(frozen=True)
class Leaves:
    """The pages of a folio.

    Parameters
    ----------
    pdf
        The file.
    places
        What the template tells: ``pages``, how many they are, and where its headings, links and anchors are.
    warnings
        What typst warns of.
    """

    pdf: bytes
    places: Mapping[str, Any]
    warnings: tuple[str, ...]


def typeset(document: Document, pool: Pool) -> bytes:
    """Return a document as a PDF file; the same document gives the same bytes, whatever the pool.

    Raises
    ------
    TestbedError
        Typst is not installed, or cannot set the document.

    Warns
    -----
    UserWarning
        With what typst warns of.
    """
    pdf, warned = _bound(document, leaves(document, pool))
    for one in warned:
        warnings.warn(f"typst: {one}", stacklevel=2)
    return pdf


def leaves(document: Document, pool: Pool) -> list[Leaves]:
    """Set the folios of a document; TestbedError if one cannot be."""
    _require_typst()
    tasks = [
        (json.dumps(encoded(folio), ensure_ascii=False), {name: document.files[name] for name in sorted(shown(folio))})
        for folio in document.folios
    ]
    found = pool.map(set_folio, tasks)
    for one, folio in zip(found, document.folios, strict=True):
        if isinstance(one, Lost):
            raise TestbedError(
                f"the pages of {_title(folio)} cannot be set ({one.reason}): report this with the results"
            )
    return found


def set_folio(folio: str, images: Mapping[str, bytes]) -> Leaves:
    """Set a folio, given as JSON, with the images it shows; runs in a worker."""
    found, warned, places = _compiled(FOLIO, {**images, "folio.json": folio.encode()})
    _forget()
    return Leaves(found, places, tuple(warned))


def _bound(document: Document, set_folios: Sequence[Leaves]) -> tuple[bytes, list[str]]:
    """Return the folios as one file, and what typst warns of."""
    folios = [
        {
            "file": f"folio-{number}.pdf",
            "lying": folio.lying,
            "headings": [encoded(block) for block in folio.blocks if isinstance(block, Heading) and block.level < 3],
            **one.places,
        }
        for number, (folio, one) in enumerate(zip(document.folios, set_folios, strict=True))
    ]
    whole = {
        "title": document.title,
        "subtitle": document.subtitle,
        "facts": encoded(document.facts),
        "folios": folios,
    }
    needed = {f"folio-{number}.pdf": one.pdf for number, one in enumerate(set_folios)}
    needed |= {name: content for name, content in document.files.items() if name.startswith("swatch")}
    needed["document.json"] = json.dumps(whole, ensure_ascii=False).encode()
    found, warned, _ = _compiled(WHOLE, needed)
    return found, [*(text for one in set_folios for text in one.warnings), *warned]


def shown(part: Any) -> set[str]:
    """Return the names of the files that blocks show."""
    if isinstance(part, Swatch):
        return {swatch_file(part.position)}
    if isinstance(part, Picture):
        return {part.file} - {""}
    if isinstance(part, Plots):
        return {*part.files, *(swatch_file(position) for position, _ in part.key)}
    if isinstance(part, tuple):
        return set().union(*map(shown, part))
    fields = getattr(part, "__dataclass_fields__", {})
    return set().union(*(shown(getattr(part, name)) for name in fields))


def _compiled(template: str, needed: Mapping[str, bytes]) -> tuple[bytes, list[str], Mapping[str, Any]]:
    """Return the PDF that typst makes of a template and files, its warnings, and what a folio tells of itself."""
    import typst

    with tempfile.TemporaryDirectory(prefix="testbed-") as name:
        folder = Path(name)
        package = files("testbed_reports.pdf")
        for file in (template, SHARED):
            (folder / file).write_text(package.joinpath(file).read_text("utf-8"), "utf-8")
        for file, content in needed.items():
            (folder / file).write_bytes(content)
        compiler = typst.Compiler(folder / template, root=folder, font_paths=_fonts())
        try:
            # tags would double the file; the HTML page is the accessible form
            found, warned = compiler.compile_with_warnings(format="pdf", timestamp=0, pdf_tags=False)
            told = compiler.query("<places>", field="value", one=True) if template == FOLIO else "{}"
        except typst.TypstError as error:
            text = re.sub(r"\s+", " ", str(error.message))
            raise TestbedError(f"typst cannot set the report ({text}): report this with the results") from error
    assert isinstance(found, bytes)  # noqa: S101 - a PDF is one file
    return found, [str(one.message) for one in warned], json.loads(told)


def _forget() -> None:
    """Let typst drop what it keeps for the next compilation: it does so with what ten have not asked for."""
    import typst

    for _ in range(KEPT + 1):
        typst.Compiler(b"nothing", font_paths=_fonts()).compile(format="pdf")


@cache
def _fonts() -> "typst.Fonts":
    """Fonts that are the same everywhere."""
    import typst

    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=True, font_paths=[lettering.fonts()])


def _require_typst() -> None:
    try:
        import typst  # noqa: F401 - asked for only
    except ImportError as error:
        raise TestbedError("a PDF needs typst: install it with pip install typst") from error


def _title(folio: Folio) -> str:
    heading = next((block for block in folio.blocks if isinstance(block, Heading)), None)
    return " ".join(getattr(run, "text", "") for run in heading.runs) if heading else "a part"
