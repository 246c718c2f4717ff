"""All files or none, whatever the disk does."""

import errno
import os
from pathlib import Path

import pytest

from harness.files import OutputError, write_all


def test_files_arrive_whole(tmp_path: Path) -> None:
    written = write_all(tmp_path / "new", {"a.csv": b"1", "deep/b.md": b"2"})
    assert [path.read_bytes() for path in written] == [b"1", b"2"]
    assert sorted(p.name for p in (tmp_path / "new").rglob("*") if p.is_file()) == ["a.csv", "b.md"]


@pytest.mark.parametrize("failing", [1, 2, 3])
def test_a_full_disk_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    write_all(tmp_path, {"a": b"old a", "b": b"old b", "c": b"old c"})
    synced = 0

    def full(handle: int) -> None:
        nonlocal synced
        synced += 1
        if synced == failing:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"cannot write there \(No space left on device\)"):
        write_all(tmp_path, {"a": b"new a", "b": b"new b", "c": b"new c"})
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {
        "a": b"old a", "b": b"old b", "c": b"old c",
    }  # fmt: skip
