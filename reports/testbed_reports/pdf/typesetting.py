"""From a document to a PDF, by typst: with its own fonts and matplotlib's, without the system's, and without a time."""

import tempfile
import warnings
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from testbed.errors import TestbedError
from testbed_reports.pdf import lettering
from testbed_reports.pdf.document import Document

if TYPE_CHECKING:
    import typst

#: The template, in this package.
TEMPLATE: Final = "report.typ"


def typeset(document: Document) -> bytes:
    """Return a document as a PDF file; the same document gives the same bytes.

    Raises
    ------
    TestbedError
        Typst is not installed, or cannot set the document.

    Warns
    -----
    UserWarning
        With what typst warns of.
    """
    return b"".join(_compiled(document, "pdf", 72.0))


def pages(document: Document, ppi: float = 72.0) -> list[bytes]:
    """Return the pages of a document as PNG files of so many pixels an inch, to be looked at."""
    return _compiled(document, "png", ppi)


def _compiled(document: Document, form: Literal["pdf", "png"], ppi: float) -> list[bytes]:
    try:
        import typst
    except ImportError as error:
        raise TestbedError("a PDF needs typst: install it with pip install typst") from error
    with tempfile.TemporaryDirectory(prefix="testbed-") as name:
        folder = Path(name)
        for file, content in document.files.items():
            (folder / file).write_bytes(content)
        (folder / "document.json").write_text(document.to_json(), "utf-8")
        main = folder / TEMPLATE
        main.write_text(files("testbed_reports.pdf").joinpath(TEMPLATE).read_text("utf-8"), "utf-8")
        try:
            found, warned = typst.compile_with_warnings(
                main, root=folder, font_paths=_fonts(), format=form, ppi=ppi, timestamp=0
            )
        except typst.TypstError as error:
            raise TestbedError(
                f"typst cannot set the report ({error.message}): report this with the results"
            ) from error
    for one in warned:
        warnings.warn(f"typst: {one.message}", stacklevel=3)
    # one page or a PDF comes as bytes, several pages as a list
    return [found] if isinstance(found, bytes) else list(found or ())


def _fonts() -> "typst.Fonts":
    """Fonts that are the same everywhere."""
    import typst

    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=True, font_paths=[lettering.fonts()])
