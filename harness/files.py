"""Files that are there whole or not at all."""

import os
import tempfile
from pathlib import Path


class OutputError(RuntimeError):
    """A result that could not be written; nothing half-written is left."""


def write_all(directory: Path, files: dict[str, bytes], option: str = "--output") -> list[Path]:
    """Write `files` (name: content) into `directory`, all or none of them.

    Every file is complete under a temporary name before the first takes its own. Raises
    `OutputError` with the reason and the `option` that names the folder, leaving what was there
    before.
    """
    staged: list[tuple[Path, Path]] = []
    try:
        for name, content in files.items():
            target = directory / name
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
            staged.append((Path(temporary), target))
            with os.fdopen(handle, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            Path(temporary).chmod(0o644)
        for temporary_path, target in staged:
            temporary_path.replace(target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{option} = {str(directory)!r}: cannot write there ({reason})") from None
    finally:
        for temporary_path, _ in staged:
            temporary_path.unlink(missing_ok=True)
    return [target for _, target in staged]
