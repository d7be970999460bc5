"""Blocks divide rows without losing, repeating or reordering one."""

import numpy as np
import pytest

from testbed.geometry.blocks import BLOCK, blocks, in_blocks
from testbed.geometry.vectors import Float


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 7])
def test_blocks_are_the_whole_range_in_order(count: int) -> None:
    rows = np.arange(count)
    assert np.array_equal(np.concatenate([rows[block] for block in blocks(count)]), rows)
    assert max(block.stop - block.start for block in blocks(count)) <= BLOCK


@pytest.mark.parametrize("count", [0, 5, 2 * BLOCK + 3])
def test_work_in_blocks_is_work_at_once(count: int) -> None:
    values = np.random.default_rng(0).normal(size=(count, 2))

    def compute(rows: slice) -> Float:
        return values[rows, :, None] * np.ones(3)

    assert np.array_equal(in_blocks(compute, count), compute(slice(0, count)))
