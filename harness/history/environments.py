"""The same study in two environments that differ in one requirement, and what changes."""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import polars as pl

from analytic import InputError
from analytic.pairing import TRUSTED
from harness.history.store import open_history
from harness.models import parse
from harness.tables import Cell, Number, Table
from reference_models import UnavailableError, catalogue

_BENCH = "from harness.cli import main; main()"
_OURS = "rps-bench: "
_EXAMPLE = "as in mujoco==3.17.0,mujoco==4.0.0"
_KEY = ["model", "case", "mode"]


@dataclass(frozen=True)
class Environment:
    """What the study gave with one `requirement`: tidy `rows`, and why models have none."""

    requirement: str
    rows: pl.DataFrame
    reasons: dict[str, str]

    def values(self, column: str, model: str | None = None) -> str:
        """Return the different values of a column, of one model's rows if named."""
        rows = self.rows if model is None else self.rows.filter(model=model)
        return ", ".join(sorted(rows[column].drop_nulls().unique()))


def compare(
    before: str,
    after: str,
    labels: Sequence[str],
    options: Sequence[str] = (),
    done: Callable[[str], None] = lambda _: None,
) -> Table:
    """Run `rps-bench table` with each requirement (as in mujoco==3.17.0) and return what changed.

    `labels` of models as of `study`; `options` go to both commands. The environments lie over this
    one, which is left as it is. `done` hears of each model in each. Raises `UnavailableError`
    without uv or where it cannot make an environment.
    """
    first, second = (_solve(text, labels, options, done) for text in (before, after))
    return _table(first, second, labels)


def requirements(text: str) -> tuple[str, str]:
    """Return the two requirements that --compare names."""
    found = [part.strip() for part in text.split(",")]
    if len(found) != 2 or not all(map(_distribution, found)) or found[0] == found[1]:
        raise InputError("--compare", text, f"two requirements, {_EXAMPLE}")
    return found[0], found[1]


def study(before: str, after: str, models: Sequence[str] | None = None) -> list[str]:
    """Return labels of what to solve: `models`, by default all that run on the program named.

    A bare name means the same elements in both environments, those it has here.
    """
    if models is None:
        wanted = {_distribution(before), _distribution(after)}
        models = [name for name, info in catalogue() if info.program.lower() in wanted]
        if not models:
            raise InputError("--compare", f"{before},{after}", f"a simulator's package, {_EXAMPLE}")
    return [parse(name, "--models").label for name in models]


def _distribution(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement.strip(), maxsplit=1)[0].lower()


def _solve(
    requirement: str, labels: Sequence[str], options: Sequence[str], done: Callable[[str], None]
) -> Environment:
    reasons: dict[str, str] = {}
    groups = [list(labels)]
    with tempfile.TemporaryDirectory() as folder:
        while groups:
            group = groups.pop(0)
            command = ["table", "--references", ",".join(group), *options, "--history", folder]
            ended = _run(requirement, ["python", "-P", "-c", _BENCH, *command], folder)
            lines = ended.stderr.splitlines()
            if ended.returncode and any(line.startswith("error:") for line in lines):
                raise UnavailableError(f"{requirement}: {_last(ended)}")
            said = [line.removeprefix(_OURS) for line in lines if line.startswith(_OURS)]
            whole = ended.returncode not in (0, 1) or (ended.returncode == 1 and not said)
            if whole and len(group) > 1:
                # One of them is refused, or crashed: it must not cost the others.
                groups = [[label] for label in group]
                continue
            for label in group:
                own = [sentence for sentence in said if sentence.startswith(f"{label} ")]
                if whole:
                    own = said or [_last(ended)]
                if own:
                    reasons[label] = "; ".join(own)
                done(f"{label} with {requirement}")
        rows = open_history(Path(folder)).query(
            "SELECT * FROM rows WHERE list_contains($1, model)", [list(labels)]
        )
    return Environment(requirement, rows, reasons)


def _run(requirement: str, command: list[str], folder: str) -> subprocess.CompletedProcess[str]:
    """Run a command in this environment with the requirement laid over it by uv."""
    # What a simulator brings along must not change the arithmetic as well.
    kept = [] if _distribution(requirement) == "numpy" else [f"--with=numpy=={np.__version__}"]
    overlay = [_uv(), "run", "--quiet", "--no-project", "--python", sys.executable]
    return subprocess.run(
        [*overlay, *kept, f"--with={requirement}", *command],
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip


def _uv() -> str:
    beside = Path(sys.executable).with_name("uv")
    found = shutil.which("uv") or (str(beside) if beside.exists() else None)
    if found is None:
        raise UnavailableError("environments are made by uv, which is not here; pip install uv")
    return found


def _last(ended: subprocess.CompletedProcess[str]) -> str:
    """Return what uv said at last, without its drawing of where."""
    lines = [line.strip() for line in ended.stderr.splitlines()]
    told = [line for line in lines if line.startswith(("error:", "cause:"))]
    told = told or [line for line in lines if line]
    return told[-1] if told else f"ended with status {ended.returncode} and did not say why"


def _table(before: Environment, after: Environment, labels: Sequence[str]) -> Table:
    both = before.rows.join(after.rows, on=[*_KEY, "mechanism"], suffix="_after")
    order = {label: k for k, label in enumerate(labels)}
    both = both.sort(pl.col("model").replace_strict(order), "case", "mode")
    rows: list[tuple[Cell, ...]] = []
    for row in both.iter_rows(named=True):
        f, g = row["frequency_hz"], row["frequency_hz_after"]
        own = [row[name] for name in ("uncertainty_hz", "uncertainty_hz_after")]
        known = [value for value in own if value is not None]
        rows.append(
            (row["model"], row["case"], row["mode"], Number(f, 4), Number(g, 4),
             Number(100 * (g / f - 1), 6, signed=True),
             Number(100 * max(known) / f, 4) if known else "not known")
        )  # fmt: skip
    columns = (
        "Model", "Case", "Mode", f"{before.requirement} [Hz]", f"{after.requirement} [Hz]",
        "Difference (%)", "Own uncertainty (%)",
    )  # fmt: skip
    notes = [
        *_versions(before, after),
        *_theories(before, after, labels),
        *_doubts(both, before, after),
        *_one_sided(before, after, labels),
        "modes are paired by order; own uncertainty is the simulator's estimate, the larger of two",
    ]
    return Table(
        f"{before.requirement} against {after.requirement}", columns, tuple(rows), tuple(notes)
    )


def _versions(before: Environment, after: Environment) -> Iterable[str]:
    """Say what ran, and what differs although nobody asked for it."""
    for one in (before, after):
        yield f"{one.requirement}: {one.values('version') or 'nothing ran'}"
    for name in ("commit", "release", "machine", "python", "numpy", "scipy", "blas"):
        was, now = before.values(name), after.values(name)
        if was and now and was != now:
            yield f"{name} differs as well: {was} and {now}"


def _theories(before: Environment, after: Environment, labels: Sequence[str]) -> Iterable[str]:
    for label in labels:
        was, now = before.values("theory", label), after.values("theory", label)
        if was and now and was != now:
            yield (
                f"{label}: its theory is {was} with {before.requirement} and {now} with "
                f"{after.requirement}, so its differences are of the model, not of one version's "
                "numerics"
            )


def _doubts(both: pl.DataFrame, before: Environment, after: Environment) -> Iterable[str]:
    for row, (suffix, one) in product(
        both.iter_rows(named=True), (("", before), ("_after", after))
    ):
        assurance = row[f"assurance{suffix}"]
        if assurance is not None and assurance < TRUSTED:
            yield (
                f"{row['model']} at {row['case']}: with {one.requirement} mode {row['mode']} looks "
                f"like no mode of the theory (assurance {assurance:.3f})"
            )


def _one_sided(before: Environment, after: Environment, labels: Sequence[str]) -> Iterable[str]:
    for label, (one, other) in product(labels, ((before, after), (after, before))):
        if label in one.reasons:
            runs = "with neither" if label in other.reasons else f"with {other.requirement} only"
            yield f"{label} runs {runs}: {one.requirement}: {one.reasons[label]}"
