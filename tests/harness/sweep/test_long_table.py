"""Rows on their way to a file: what is added is there, and memory holds one block of it."""

import tracemalloc
from contextlib import closing
from pathlib import Path

import numpy as np

from harness.sweep.long_table import TABLE, LongTable

COLUMNS = (("pose",), ("z_m", "gap"), ("f",), (1, 2))


def test_blocks_of_any_size_keep_their_own_numbers(tmp_path: Path) -> None:
    """Shorter and longer than the one before, of another type, none, or not finite."""
    blocks = [3, 1, 5, 2]
    given = [np.arange(n * 2.0).reshape(n, 2) + 100 * k for k, n in enumerate(blocks)]
    gaps: list[object] = [None, np.array([np.nan]), np.arange(5), np.array([0.5, np.inf])]
    with closing(LongTable(tmp_path / "rows.parquet", *COLUMNS)) as table:
        for k, (f, gap) in enumerate(zip(given, gaps, strict=True)):
            table.add({"pose": np.full(len(f), k), "z_m": f[:, 0] / 7, "f": f, "gap": gap})
        rows = table.base.execute(f"SELECT pose, z_m, mode, f, gap FROM {TABLE}").fetchall()
    expected = [
        (k, f[i, 0] / 7, mode, f[i, mode - 1],
         (None, None, float(i), (0.5, None)[i % 2])[k])
        for k, f in enumerate(given) for i in range(len(f)) for mode in (1, 2)
    ]  # fmt: skip
    assert rows == expected


def test_what_was_added_is_not_kept_in_memory(tmp_path: Path) -> None:
    block = {"pose": np.arange(7000), "z_m": np.ones(7000), "f": np.ones((7000, 2)), "gap": None}
    with closing(LongTable(tmp_path / "rows.parquet", *COLUMNS)) as table:
        table.add(block)
        tracemalloc.start()
        try:
            for _ in range(20):
                table.add({name: value if value is None else value.copy()
                           for name, value in block.items()})  # fmt: skip
            grown, _ = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert grown < 7000 * 8  # one column of one block of the twenty
