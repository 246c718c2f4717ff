"""What is accepted: the gate's figures, and the few tables that README shows, none with seconds."""

from collections.abc import Collection
from pathlib import Path

ACCEPTED = "results/accepted"
BASELINE = f"{ACCEPTED}/baseline"
_SHIPPED = Path(__file__).parent / "accepted_baseline"
SHOWN = ("table1.md", "table1.csv", "fig3.svg", "fig3.csv", "budget.svg", "budget.md", "summary.md")
"""Files of the main job that are kept under results/accepted."""


def baseline() -> Path:
    """Return the folder of accepted figures: this one's own, else what an installation carries."""
    own = Path(BASELINE)
    return own if own.exists() or not _SHIPPED.is_dir() else _SHIPPED


def files(folder: Path) -> dict[str, bytes]:
    """Return the files `SHOWN` of `folder`; raises `InputError` where the main job made none."""
    from analytic import InputError

    found = {}
    for name in SHOWN:
        try:
            found[name] = (folder / name).read_bytes()
        except OSError as error:
            expected = f"a folder written by rps-bench reproduce ({name}: {error.strerror})"
            raise InputError("latest", str(folder), expected) from None
    return found


def unlike(folder: Path, simulators: Collection[str]) -> str:
    """Return in what the run that made `folder` is less than the main job, "" if in nothing.

    `simulators`: those whose figures are accepted. Raises `InputError` where the folder does not
    say what made it.
    """
    from harness.report.page import COMMAND, load
    from harness.studies import STUDIES

    kept = load(folder)
    if kept["command"] != COMMAND:
        return f"made by {kept['command']}"
    studies = [one.name for one in STUDIES if getattr(one.load(), "jobs", STUDIES) is not None]
    for what, wanted, made in (("models", simulators, "references"), ("studies", studies, "made")):
        if lacking := sorted({*wanted} - {*kept.get(made, ())}):
            return f"made without the {what} {', '.join(lacking)}"
    return ""
