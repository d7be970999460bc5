"""Numbers of sections, tables and figures, and what refers to them."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

from testbed_reports.pdf.blocks import Block, Folio, Heading, Pictures, Plots, Reference, Table


def numbered(folios: Sequence[Folio]) -> tuple[Folio, ...]:
    """Return folios whose headings, tables and figures have numbers, and whose references say them.

    Raises
    ------
    KeyError
        A reference leads nowhere.
    """
    counted = [
        dataclasses.replace(folio, blocks=tuple(blocks)) for folio, blocks in zip(folios, _counted(folios), strict=True)
    ]
    numbers = {
        block.label: f"section {block.number}" if isinstance(block, Heading) else block.number
        for folio in counted
        for block in folio.blocks
        if isinstance(block, Heading | Table | Pictures | Plots) and block.label
    }
    return tuple(_referring(folio, numbers) for folio in counted)


def _counted(folios: Sequence[Folio]) -> Iterator[list[Block]]:
    chapter = section = tables = figures = 0
    for folio in folios:
        blocks: list[Block] = []
        for block in folio.blocks:
            match block:
                case Heading(level=1):
                    chapter, section = chapter + 1, 0
                    blocks.append(dataclasses.replace(block, number=f"{chapter}"))
                case Heading(level=2):
                    section += 1
                    blocks.append(dataclasses.replace(block, number=f"{chapter}.{section}"))
                case Table():
                    tables += 1
                    blocks.append(dataclasses.replace(block, number=f"Table {tables}"))
                case Pictures() | Plots():
                    figures += 1
                    blocks.append(dataclasses.replace(block, number=f"Figure {figures}"))
                case _:
                    blocks.append(block)
        yield blocks


def _referring(part: Any, numbers: dict[str, str]) -> Any:
    """Fill in the texts of references, wherever they stand."""
    if isinstance(part, Reference):
        return dataclasses.replace(part, text=numbers[part.label])
    if isinstance(part, tuple):
        return tuple(_referring(one, numbers) for one in part)
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        changed = {field.name: getattr(part, field.name) for field in dataclasses.fields(part)}
        held = {name: value for name, value in changed.items() if isinstance(value, tuple)}
        return dataclasses.replace(part, **{name: _referring(value, numbers) for name, value in held.items()})
    return part
