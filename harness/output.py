"""Results to files: tables, frames and figures, there whole or not at all."""

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from analytic import InputError
from harness.figures import figure_files, own_style
from harness.plain import file_name
from harness.result import Result
from harness.tables import harmless, table_files

if TYPE_CHECKING:
    import pandas as pd

DIGITS = 10
"""Significant digits of a number in a tidy file: what machines agree on, and no more."""


class OutputError(RuntimeError):
    """A result that could not be written; nothing half-written is left."""


def result_files(results: Mapping[str, Result]) -> dict[str, bytes]:
    """Return the results' tables (.csv, .md, .tex), figures and tidy numbers as files to write.

    `results`: by the stem of their files' names.
    """
    files: dict[str, bytes] = {}
    for stem, result in results.items():
        files |= table_files({f"{stem}{file_name(end)}": t for end, t in result.tables().items()})
        with own_style():
            for ending, figure in result.figures().items():
                files |= figure_files(figure, f"{stem}{file_name(ending)}")
        files[f"{stem}-data.csv"] = tidy(result.to_frame())
    return files


def tidy(frame: "pd.DataFrame") -> bytes:
    """Return a frame as CSV, numbers with the digits that are significant."""
    frame = frame.copy()
    for name in frame.select_dtypes(exclude="number"):
        frame[name] = frame[name].map(harmless)
    text: str = frame.to_csv(index=False, lineterminator="\n", float_format=f"%.{DIGITS}g")
    return text.encode()


def check_folder(text: str, argument: str = "output", *, writes: bool = False) -> Path:
    """Return the folder that `text` names, which `writes` may have to make.

    Raises `InputError` where it cannot be one, or must be written and cannot.
    """
    folder = Path(text)
    try:
        text.encode()
        # What is to be made needs a folder above it that may be written.
        found = next(one for one in (folder, *folder.absolute().parents) if os.path.lexists(one))
        good = text != "" and found.is_dir()
    except (ValueError, OSError):
        good = False
    if not good:
        raise InputError(argument, text, "the name of a folder")
    if writes and not os.access(found, os.W_OK):
        raise InputError(argument, text, f"a folder that may be written, unlike {found}")
    return folder


def check_file(text: str, argument: str = "output") -> Path:
    """Return the file that `text` names, which is a regular one or is not there yet.

    Raises `InputError` for a folder, a link, a device and the like: writing would replace it.
    """
    path = Path(text)
    if not path.name or path.is_symlink() or (path.exists() and not path.is_file()):
        raise InputError(argument, text, "the name of a file, no folder, link or device")
    check_folder(str(path.parent), argument, writes=True)
    return path


def write_all(directory: Path, files: Mapping[str, bytes], argument: str = "output") -> list[Path]:
    """Write `files` (name: content) into `directory`, all or none of them.

    Every file is complete under a temporary name before the first takes its own. Raises
    `OutputError` with the reason and the `argument` that names the folder, leaving what was there
    before.
    """
    targets = [directory / name for name in files]
    with staged(directory, files, argument) as temporary:
        for path, content in zip(temporary, files.values(), strict=True):
            with path.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        for path, target in zip(temporary, targets, strict=True):
            path.replace(target)
    return targets


@contextmanager
def staged(
    directory: Path, names: Iterable[str], argument: str = "output"
) -> Iterator[tuple[Path, ...]]:
    """Yield an empty file beside each of `names` in `directory`: to fill and to rename.

    What has not been renamed at the end is removed. Raises `OutputError` for any `OSError` inside,
    with the reason and the `argument` that names the folder, and for a name that leaves it.
    """
    temporary: list[Path] = []
    try:
        for name in names:
            target = directory / name
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise OutputError(f"{argument}: {name!r} is no name of a file in the folder")
            if target.exists() and not target.is_file():
                raise OutputError(f"{argument}: {str(target)!r} is there and is no file")
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, path = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
            os.close(handle)
            temporary.append(Path(path))
            temporary[-1].chmod(0o644)
        yield tuple(temporary)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"{argument} = {str(directory)!r}: cannot write there ({reason})"
        ) from None
    finally:
        for staging in temporary:
            staging.unlink(missing_ok=True)
