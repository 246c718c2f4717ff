"""What is accepted: the gate's figures, and the few tables that README shows, none with seconds."""

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
