"""Two runs compared: what improved, regressed, changed, appeared or vanished, by cells, orders and claims.

Values are compared where both cells are ok (see :mod:`testbed.harness.value_differences`). Orders are better the larger
they are, and differ where their intervals are apart. What is gone is never a pass.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from testbed.harness.comparable import Comparable, Key, Row, Value
from testbed.harness.value_differences import ColumnComparison, Difference, Kind, is_near

#: Relative differences up to this are none, unless asked for otherwise.
TOLERANCE: Final = 1e-6
#: Kinds of differences, the worst first.
KINDS: Final[tuple[Kind, ...]] = ("regressed", "vanished", "changed", "improved", "appeared")
#: What each condition of a check counts as a failure.
FAILING: Final[Mapping[str, tuple[Kind, ...]]] = {"regressed": ("regressed", "vanished"), "changed": KINDS}
#: From good to bad.
STATUSES: Final = ("ok", "refused", "timeout", "failed")
VERDICTS: Final = ("exceeded", "met", "not testable", "missed")

#: Columns that tell meshes apart.
_OF_MESHES: Final = ("faces", "h", "diameter")


@dataclass(frozen=True)
class Comparison:
    """How new results differ from old ones.

    Parameters
    ----------
    differences
        The worst first.
    cells, orders, claims
        How many there are of each kind, and ``unchanged``; a cell counts once, by the worst that can be said of its
        status and values: ``regressed``, else ``improved``, else ``changed``.
    notes
        What was not or could not well be compared, a sentence each.
    """

    differences: tuple[Difference, ...]
    cells: Mapping[str, int]
    orders: Mapping[str, int]
    claims: Mapping[str, int]
    notes: tuple[str, ...]

    def fails(self, condition: str) -> bool:
        """Whether a check on a condition, ``regressed`` or ``changed``, fails; what vanished counts as regressed."""
        return any(one.kind in FAILING[condition] for one in self.differences)

    def sentence(self) -> str:
        """Return all in one sentence."""
        kinds = ("unchanged", "improved", "regressed", "changed")
        both = sum(self.cells.get(kind, 0) for kind in kinds)
        parts = [f"{both} cells in both: {_counted(self.cells, kinds)}"]
        beside = _counted(self.cells, ("vanished", "appeared"))
        parts += [f"cells {beside}"] if any(self.cells.get(kind) for kind in ("vanished", "appeared")) else []
        for name, counts in (("orders", self.orders), ("verdicts", self.claims)):
            if any(counts.get(kind) for kind in KINDS):
                parts.append(f"{name}: {_counted(counts, ('unchanged', *KINDS))}")
        return "; ".join(parts)


def compare(old: Comparable, new: Comparable, tolerance: float = TOLERANCE, seconds: float | None = None) -> Comparison:
    """Compare new results with old ones.

    Parameters
    ----------
    old, new
        The results.
    tolerance
        Relative difference up to which values are unchanged.
    seconds
        The same for times; None to pass them over.
    """
    columns = ColumnComparison.of(old, new, tolerance, seconds)
    differences = list(columns.differences())
    cells = _cells(old, new, columns)
    differences += [one for found in cells.values() for one in found]
    is_judged = old.is_judged and new.is_judged
    orders = list(_orders(old, new, tolerance)) if is_judged else []
    claims = list(_claims(old, new)) if is_judged else []
    differences += [one for one in (*orders, *claims) if one is not None]
    return Comparison(
        tuple(sorted(differences, key=_rank)),
        Counter(_kind_of(found) for found in cells.values()),
        Counter("unchanged" if one is None else one.kind for one in orders),
        Counter("unchanged" if one is None else one.kind for one in claims),
        (*old.notes, *new.notes, *_notes(old, new)),
    )


def _rank(one: Difference) -> tuple[int, float, tuple[str, str, str, int, str]]:
    return KINDS.index(one.kind), -one.severity, one.place


def _kind_of(found: Iterable[Difference]) -> str:
    """Return what can be said of a cell with differences."""
    kinds = {one.kind for one in found}
    whole = [one.kind for one in found if not one.quantity]
    if whole:
        return whole[0]
    if kinds & {"regressed", "vanished"}:
        return "regressed"
    return "improved" if "improved" in kinds else "changed" if kinds else "unchanged"


def _counted(counts: Mapping[str, int], kinds: Iterable[str]) -> str:
    return ", ".join(f"{counts.get(kind, 0)} {kind}" for kind in kinds if counts.get(kind)) or "none"


def _cells(old: Comparable, new: Comparable, columns: ColumnComparison) -> dict[Key, list[Difference]]:
    """Return the differences of each cell that either has."""
    found: dict[Key, list[Difference]] = {}
    for key in dict.fromkeys((*old.cells, *new.cells)):
        before, after = old.cells.get(key), new.cells.get(key)
        if before is None or after is None:
            kind: Kind = "appeared" if before is None else "vanished"
            was, is_now = (None if row is None else row["status"] for row in (before, after))
            reason = str((after or {}).get("reason") or "")
            found[key] = [Difference("cell", kind, *key, "", was, is_now, reason=reason)]
        elif before["status"] != after["status"]:
            kind = _ranked(STATUSES, before["status"], after["status"])
            reason = str(after.get("reason") or before.get("reason") or "")
            found[key] = [Difference("cell", kind, *key, "status", before["status"], after["status"], reason=reason)]
        else:
            found[key] = list(columns.values(key, before, after)) if after["status"] == "ok" else []
    return found


def _ranked(order: tuple[str, ...], old: Value, new: Value) -> Kind:
    """Whether a text has moved towards the front of an order or to its back."""
    if old not in order or new not in order:
        return "changed"
    before, after = order.index(str(old)), order.index(str(new))
    return "improved" if after < before else "regressed"


def _orders(old: Comparable, new: Comparable, tolerance: float) -> Iterator[Difference | None]:
    """Yield a difference, or None for none, for each order that either has of what both have cells of."""
    pairs = _pairs(old) & _pairs(new)
    for key in dict.fromkeys((*old.orders, *new.orders)):
        scheme, dataset, quantity = key
        if (scheme, dataset) not in pairs:
            continue  # the cells tell
        rows = old.orders.get(key, {}), new.orders.get(key, {})
        before, after = (row.get("order") for row in rows)
        if not isinstance(before, float) or not isinstance(after, float):
            if before is None and after is None:
                continue
            kind: Kind = "appeared" if before is None else "vanished"
            reason = str((rows[1] if after is None else rows[0]).get("reason") or "")
            yield Difference("order", kind, scheme, dataset, None, quantity, before, after, reason=reason)
            continue
        if is_near(before, after, tolerance, 0.0):
            yield None
            continue
        kind = "changed"
        if _end(rows[1], "high") < _end(rows[0], "low"):
            kind = "regressed"
        elif _end(rows[1], "low") > _end(rows[0], "high"):
            kind = "improved"
        yield Difference("order", kind, scheme, dataset, None, quantity, before, after)


def _end(row: Row, name: str) -> float:
    """An end of an order's interval; the order itself where there is no interval."""
    value = row.get(name)
    value = row.get("order") if value is None else value
    return value if isinstance(value, float) else math.nan


def _claims(old: Comparable, new: Comparable) -> Iterator[Difference | None]:
    """Yield a difference, or None for none, for each claim that either has of what both have cells of."""
    pairs = _pairs(old) & _pairs(new)
    schemes = {scheme for scheme, _ in pairs}
    for key in dict.fromkeys((*old.claims, *new.claims)):
        scheme, claim, dataset = key
        if (scheme, dataset) not in pairs and (dataset or scheme not in schemes):
            continue  # the cells tell
        before, after = (rows.get(key, {}).get("verdict") for rows in (old.claims, new.claims))
        if before == after:
            yield None
            continue
        reason = str((new.claims.get(key) or old.claims[key]).get("reason") or "")
        kind: Kind = "appeared" if before is None else "vanished" if after is None else _ranked(VERDICTS, before, after)
        yield Difference("claim", kind, scheme, dataset, None, claim, before, after, reason=reason)


def _pairs(results: Comparable) -> set[tuple[str, str]]:
    return {(scheme, dataset) for scheme, dataset, _ in results.cells}


def _notes(old: Comparable, new: Comparable) -> Iterator[str]:
    """Yield what could not well be compared, a sentence each."""
    for results in (old, new):
        if not results.is_judged:
            yield f"{results.name} holds cells alone: orders and verdicts are not compared"
    common = [key for key in old.cells if key in new.cells]
    if not common:
        yield "no cell is in both: name results of the same schemes, datasets and levels"
    moved = sum(_is_moved(old.cells[key], new.cells[key]) for key in common)
    if moved:
        yield f"{moved} cells have other meshes than before (faces, h or diameter differ): so may all their values"


def _is_moved(old: Row, new: Row) -> bool:
    """Whether two rows are about different meshes."""
    for name in _OF_MESHES:
        before, after = old.get(name), new.get(name)
        if isinstance(before, float) and isinstance(after, float) and not math.isclose(before, after, rel_tol=1e-9):
            return True
    return False
