"""Work in blocks: what belongs to a few thousand faces or edges stays in cache, and memory stays low."""

from collections.abc import Callable, Iterator

import numpy as np

from testbed.geometry.vectors import Float

#: Rows of a block.
BLOCK = 1024


def blocks(count: int) -> Iterator[slice]:
    """Divide ``range(count)`` into blocks, at least one, the last one shorter."""
    for start in range(0, max(count, 1), BLOCK):
        yield slice(start, min(start + BLOCK, count))


def in_blocks(compute: Callable[[slice], Float], count: int) -> Float:
    """Return ``compute(slice(0, count))`` as if at once, read-only; rows of the result depend on their own rows only.

    Parameters
    ----------
    compute
        From a slice of rows to their results, (rows, ...).
    count
        Number of rows.
    """
    result: Float | None = None
    for block in blocks(count):
        values = compute(block)
        if result is None:
            result = np.empty((count, *values.shape[1:]))
        result[block] = values
    assert result is not None  # noqa: S101 - there is at least one block
    result.flags.writeable = False  # so that patches need no copy of it
    return result
