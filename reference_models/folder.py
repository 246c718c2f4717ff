"""Where this bench keeps what takes long to make."""

import os
from pathlib import Path


def default_folder() -> Path:
    """Return the user's cache folder, as the XDG base directories name it."""
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "rps-bench"
