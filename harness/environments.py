"""The same study in two environments that differ in one requirement, and what changes."""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from analytic import InputError, Modes
from harness.answer import checked
from harness.bench import SPARE, ModesTask, label
from harness.case import Case
from harness.listener import Listener
from harness.plugins import Question
from harness.tables import Number, Row, Table
from harness.workers import LIMIT, Children, Failure
from reference_models import ModelError, Named, UnavailableError, catalogue, parse

COUNT = 6
"""Modes that are compared."""
EXAMPLE = "as in mujoco==3.17.0,mujoco==4.0.0"
Answers = dict[tuple[Case, Named], Modes | Failure]


def requirements(text: str) -> tuple[str, str]:
    """Return the two requirements that --compare names."""
    found = [part.strip() for part in text.split(",")]
    if len(found) != 2 or not all(map(_distribution, found)) or found[0] == found[1]:
        raise InputError("compare", text, f"two requirements, {EXAMPLE}")
    return found[0], found[1]


def study(before: str, after: str, names: Sequence[str] | None = None) -> list[Named]:
    """Return what to solve: the models called `names`, by default all on the program named.

    A bare name means the same elements in both environments, those it has here.
    """
    if names is None:
        wanted = {_distribution(before), _distribution(after)}
        names = [name for name, info in catalogue() if info.program.lower() in wanted]
        if not names:
            raise InputError("compare", f"{before},{after}", f"a simulator's package, {EXAMPLE}")
    return [parse(name, "models") for name in names]


def compare(
    before: str,
    after: str,
    cases: Sequence[Case],
    models: Sequence[Named],
    *,
    limit: float = LIMIT,
    listener: Listener | None = None,
) -> Table:
    """Return what changes from one requirement (as in mujoco==3.17.0) to the other.

    The environments lie over this one, which is left as it is. Raises `UnavailableError` without
    uv or where it cannot make an environment.
    """
    tell = listener or Listener()
    tell.expect(2 * len(models))
    both = {one: _solve(one, cases, models, limit, tell) for one in (before, after)}
    rows: list[Row] = []
    notes = [
        f"{one}: {', '.join(sorted(ran)) or 'nothing ran'}"
        for one, found in both.items()
        for ran in [{m.version for m in found.values() if isinstance(m, Modes)}]
    ]
    missing = []
    for model, case in product(models, cases):
        was, now = (found[case, model] for found in both.values())
        if isinstance(was, Modes) and isinstance(now, Modes):
            rows += _rows(model, case, was, now)
            if was.theory != now.theory:
                notes.append(
                    f"{label(model)}: its theory is {was.theory} with {before} and {now.theory} "
                    f"with {after}, so its differences are of the model, not of one version's "
                    "numerics"
                )
            continue
        for one, other, here, there in ((before, after, was, now), (after, before, now, was)):
            if isinstance(here, Failure):
                runs = "neither" if isinstance(there, Failure) else f"{other} only"
                missing.append(f"{label(model)} runs with {runs}: {one}: {here.reason}")
    columns = ("Model", "Case", "Mode", f"{before} [Hz]", f"{after} [Hz]", "Difference [%]",
               "Own uncertainty [%]")  # fmt: skip
    last = (
        "modes are paired by order; own uncertainty is the simulator's estimate, the larger of two"
    )
    notes = list(dict.fromkeys([*notes, *missing, last]))
    return Table(f"{before} against {after}", columns, rows, notes)


def _rows(model: Named, case: Case, was: Modes, now: Modes) -> Iterator[Row]:
    """Yield a row a mode."""
    known = [m.uncertainty for m in (was, now) if m.uncertainty is not None]
    own = np.max(known, axis=0) if known else None
    for i, (f, g) in enumerate(zip(was.frequencies, now.frequencies, strict=True)):
        yield (
            label(model), case.name, i + 1, Number(f, 4), Number(g, 4),
            Number(100 * (g / f - 1), 6, signed=True) if f else "-",
            Number(100 * own[i] / f, 4) if own is not None and f else "not known",
        )  # fmt: skip


def _solve(
    requirement: str,
    cases: Sequence[Case],
    models: Sequence[Named],
    limit: float,
    tell: Listener,
) -> Answers:
    found: Answers = {}
    with closing(Children(_launcher(requirement))) as children:
        for model in models:
            # What it is where it runs: another version may have another theory.
            info: Any = children.attempt(Question(model, Named.info), limit)
            for case in cases:
                task = ModesTask(model, case.mechanism, case.pose, COUNT + SPARE)
                answer: Any = info
                if not isinstance(info, Failure):
                    answer = children.attempt(task, limit)
                if not isinstance(answer, Failure):
                    try:
                        answer = checked(answer, info, case.mechanism, case.pose, task.count)
                        answer = answer.first(COUNT)
                    except ModelError as error:
                        answer = Failure(str(error))
                found[case, model] = answer
            tell.done(f"{label(model)} with {requirement}")
    return found


def _launcher(requirement: str) -> list[str]:
    """Return what runs Python with the requirement laid over this environment by uv."""
    # What a simulator brings along must not change the arithmetic as well.
    kept = [] if _distribution(requirement) == "numpy" else [f"--with=numpy=={np.__version__}"]
    overlay = [_uv(), "run", "--quiet", "--no-project", "--python", sys.executable]
    command = [*overlay, *kept, f"--with={requirement}", "python"]
    ended = subprocess.run([*command, "-c", "pass"], capture_output=True, text=True, check=False)
    if ended.returncode:
        lines = [line.strip() for line in ended.stderr.splitlines() if line.strip()]
        told = [line for line in lines if line.startswith(("error:", "cause:"))] or lines
        why = told[-1] if told else f"ended with status {ended.returncode} and did not say why"
        raise UnavailableError(f"{requirement}: {why}")
    return command


def _uv() -> str:
    beside = Path(sys.executable).with_name("uv")
    found = shutil.which("uv") or (str(beside) if beside.exists() else None)
    if found is None:
        raise UnavailableError("environments are made by uv, which is not here; pip install uv")
    return found


def _distribution(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement.strip(), maxsplit=1)[0].lower()
