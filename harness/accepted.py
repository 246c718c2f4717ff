"""The few tables and figures that README shows; none of them holds seconds."""

from pathlib import Path

from analytic import InputError

SHOWN = ("table1.md", "table1.csv", "fig3.svg", "fig3.csv", "budget.svg", "budget.md", "summary.md")
"""Files of the main job that are kept under results/accepted."""


def files(folder: Path) -> dict[str, bytes]:
    """Return the files `SHOWN` of `folder`; raises `InputError` where the main job made none."""
    found = {}
    for name in SHOWN:
        try:
            found[name] = (folder / name).read_bytes()
        except OSError as error:
            expected = f"a folder written by rps-bench reproduce ({name}: {error.strerror})"
            raise InputError("latest", str(folder), expected) from None
    return found
