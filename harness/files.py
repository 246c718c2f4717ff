"""Files that are there whole or not at all."""

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path


class OutputError(RuntimeError):
    """A result that could not be written; nothing half-written is left."""


def write_all(directory: Path, files: dict[str, bytes], option: str = "--output") -> list[Path]:
    """Write `files` (name: content) into `directory`, all or none of them.

    Every file is complete under a temporary name before the first takes its own. Raises
    `OutputError` with the reason and the `option` that names the folder, leaving what was there
    before.
    """
    targets = [directory / name for name in files]
    with staged(directory, files, option) as temporary:
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
    directory: Path, names: Iterable[str], option: str = "--output"
) -> Iterator[tuple[Path, ...]]:
    """Yield an empty file beside each of `names` in `directory`: to fill and to rename.

    What has not been renamed at the end is removed. Raises `OutputError` for any `OSError` inside,
    with the reason and the `option` that names the folder.
    """
    temporary: list[Path] = []
    try:
        for name in names:
            target = directory / name
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, path = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
            os.close(handle)
            temporary.append(Path(path))
            temporary[-1].chmod(0o644)
        yield tuple(temporary)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{option} = {str(directory)!r}: cannot write there ({reason})") from None
    finally:
        for staging in temporary:
            staging.unlink(missing_ok=True)
