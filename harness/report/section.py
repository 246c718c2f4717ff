"""A section of the page as JSON can keep it, what it is made from, and where its numbers come from.

Every number has a record: one a source, shared by its numbers.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cache, cached_property
from itertools import chain
from typing import Any, TypeVar

import numpy as np

from analytic import Modes
from analytic.model import Model
from harness.bench import SPARE, Study, label
from harness.case import Case
from harness.history.provenance import provenance
from harness.poses import COLUMNS, words
from harness.reproduce import Part
from harness.request import Plan
from harness.result import Result
from harness.rows import mode_rows, settings
from harness.studies import find
from harness.tables import Number, Table
from reference_models import Named

Json = dict[str, Any]
Fields = dict[str, str]
PHRASES = {"way": "{}", "timed": "timed by {}", "poses": "batches of {} poses", "table": "{}",
           "case": "{}"}  # fmt: skip
"""Settings of a row that their name and value do not say in words."""
USUAL_SHEAR = "cowper"
"""The shear coefficient that a row need not mention."""
R = TypeVar("R", bound=Result)
FEWEST = 3
"""Numbers of elements that make a curve."""


@dataclass(frozen=True)
class Section:
    """One part of the page.

    Attributes: `context` for its template; `data` for its script; `missing`, why there is nothing
    to show; `key`, its anchor and the name of its templates; `title`; `menu`, its title in the
    navigation; `command`, what makes it.
    """

    context: Json = field(default_factory=dict)
    data: Any = None
    missing: str = ""
    key: str = ""
    title: str = ""
    menu: str = ""
    command: str = ""


def number(text: str, full: str, what: str, record: int | None) -> Json | str:
    """Return a number that can be asked: as shown, with all digits, what it is, and its record."""
    if record is None:
        return text
    return {"text": text, "full": full, "what": what, "record": record}


def digits(value: Any, count: int = 12) -> Any:
    """Return numbers, in lists or not, to `count` significant digits; None for what is none."""
    if isinstance(value, (list, tuple, np.ndarray)):
        return [digits(one, count) for one in value]
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{count}g}")


def shown(table: Table, record: int | None = None) -> Json:
    """Return a table as the page shows it; its numbers come from `record`."""
    rows: list[list[Any]] = []
    for row in table.rows:
        rows.append([str(cell) for cell in row])
        for k, cell in enumerate(row):
            if isinstance(cell, Number):
                words = ", ".join(str(w) for w in row[:k] if isinstance(w, (str, int)) and w)
                what = f"{table.columns[k]}: {words}"
                rows[-1][k] = number(str(cell), repr(float(cell.value)), what, record)
    return {
        "title": table.title,
        "columns": list(table.columns),
        "numeric": [
            any(isinstance(row[k], (int, Number)) for row in table.rows)
            for k in range(len(table.columns))
        ],
        "rows": rows,
        "notes": list(table.notes),
    }


class Ledger:
    """Records by number: a title, what is known in words, and the records it was made from."""

    def __init__(self, records: Sequence[dict[str, Any]] = ()) -> None:
        self.records = list(records)
        self._places = {json.dumps(one): k for k, one in enumerate(self.records)}

    def add(self, title: str, fields: Fields, parts: Sequence[int | None] = ()) -> int:
        """Return the number of a record, kept once; `parts` are the records it was made from.

        Empty fields are left out.
        """
        known = {name: text for name, text in fields.items() if text}
        one = {"title": title, "fields": known, "parts": [p for p in parts if p is not None]}
        place = self._places.setdefault(json.dumps(one), len(self.records))
        if place == len(self.records):
            self.records.append(one)
        return place


def at(row: Mapping[str, Any]) -> str:
    """Return the pose of a tidy row in words."""
    return words(*(row.get(column) for column in COLUMNS)).replace(" deg", "°")


def answer(rows: Sequence[Mapping[str, Any]]) -> Fields:
    """Return in words what the tidy rows of a model at a case say beside its frequencies."""
    row = rows[0]
    gap = row["closure_m"]
    own = [f"f{one['mode']} ±{one['uncertainty_hz']:.2g}" for one in rows if one["uncertainty_hz"]]
    return {
        "Pose": at(row),
        "Mechanism": row["mechanism"],
        "Model": row["model"],
        "Theory": row["theory"],
        "Version": row["version"],
        "Settings": in_words(row["settings"]),
        "Uncertainty": f"{', '.join(own)} Hz, by extrapolation" if own else "not estimated",
        "Coordinates": str(row["dofs"] or ""),
        "Joint gap": "none can open" if gap is None else f"{gap:.1e} m",
        "Time": f"{1000 * row['build_s']:.3g} ms to build, {1000 * row['solve_s']:.3g} to solve",
    }


def in_words(settings: str | None) -> str:
    """Return a row's settings, JSON, in words."""
    return _words(_settings(settings))


@cache
def variant(settings: str | None) -> str:
    """Return in words what sets a row apart from its model's usual ones; "" for those."""
    known = _settings(settings)
    known.pop("count", None)
    if known.get("shear") == USUAL_SHEAR:
        del known["shear"]
    return _words(known)


def _settings(text: str | None) -> dict[str, Any]:
    try:
        known = json.loads(text or "{}")
    except ValueError:
        known = text
    return known if isinstance(known, dict) else {"settings": known}


def _words(known: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} ({_words(value)})"
        if isinstance(value, dict)
        else PHRASES.get(name, name + " {}").format(value)
        for name, value in known.items()
    )


def environment(run: Mapping[str, Any]) -> Fields:
    """Return when, from which commit and on what a run ran."""
    own = f", run {run['run']}" if run.get("run") else ""
    return {
        "Run": f"{run['time']:%Y-%m-%d %H:%M} UTC{own}",
        "Commit": f"{run['commit'] or 'none'} (rps-bench {run['release']})",
        "Machine": run["machine"],
        "Python": f"{run['python']}, numpy {run['numpy']}, scipy {run['scipy']}, {run['blas']}",
    }


@dataclass(frozen=True)
class Material:
    """The results of one run.

    Attributes: `plan`, what was asked for; `parts`, what the studies made of it; `command` that ran
    them; `ledger`, where numbers come from.
    """

    plan: Plan
    parts: tuple[Part, ...]
    command: str
    ledger: Ledger = field(default_factory=Ledger)

    @property
    def results(self) -> list[Result]:
        """All results of the run."""
        return [result for part in self.parts for result in part.results.values()]

    def of(self, kind: type[R]) -> list[R]:
        """Return the results of one type."""
        return [result for result in self.results if isinstance(result, kind)]

    def one(self, kind: type[R]) -> R | None:
        """Return the first result of one type, or None."""
        return next(iter(self.of(kind)), None)

    def only(self, name: str) -> str:
        """Return the command that makes the study called `name` of this run again."""
        return f"{self.command} --only {name}"

    def part(self, name: str) -> Part:
        """Return what the study called `name` made: nothing where it was not asked."""
        known = (part for part in self.parts if part.entry.name == name)
        return next(known, Part(find(name), {}))

    def note(self, title: str, fields: Fields, *parts: int | None) -> int:
        """Return the record of what was made of the records `parts`, by default of this run's."""
        return self.ledger.add(title, fields, parts or [self.run])

    @property
    def answers(self) -> Mapping[tuple[Case, Model], Modes]:
        """Every answer of the run at the plan's cases."""
        return self.study.answers

    @cached_property
    def study(self) -> Study:
        """All that was solved at the plan's cases; of two answers of a model that of more modes."""
        found: dict[tuple[Case, Model], Modes] = {}
        solved = (study.answers for result in self.results for study in result.studies)
        for key, modes in chain.from_iterable(answers.items() for answers in solved):
            fewer = key not in found or len(found[key].frequencies) < len(modes.frequencies)
            if fewer and key[0] in self.plan.cases:
                found[key] = modes
        return Study(self.plan.cases, (), self.plan.count, found, {})

    def models(self, case: Case) -> list[Model]:
        """Return the models with an answer at `case`."""
        return [model for at, model in self.answers if at == case]

    def references(self, case: Case) -> list[Model]:
        """Return what a theory can be held against at `case`: references, and exact theories."""
        known = self.models(case)
        asked = (*self.plan.references, self.plan.solid)
        exact = [model for model in known if model.elements is None and model.limit() == model]
        return list(dict.fromkeys([model for model in asked if model and model in known] + exact))

    def families(self, case: Case) -> dict[str, dict[int, Model]]:
        """Return models with some of the plan's elements, by name and elements; the theory first.

        A family differs in elements alone, and has at least `FEWEST` of them.
        """
        found: dict[Named, dict[int, Model]] = {}
        for model in self.models(case):
            if isinstance(model, Named) and model.elements in self.plan.elements:
                assert isinstance(model.elements, int), "the plan's elements are"
                found.setdefault(replace(model, elements=None), {})[model.elements] = model
        least = min(FEWEST, len(self.plan.elements))
        own = replace(self.plan.theory, elements=None)
        named = {
            ", ".join([one.name, *(f"{name} {value}" for name, value in one.settings)]): meshes
            for one, meshes in sorted(found.items(), key=lambda item: item[0] != own)
            if len(meshes) >= least or one == own
        }
        return {name: dict(sorted(meshes.items())) for name, meshes in named.items()}

    def record(self, case: Case, model: Model | None) -> int | None:
        """Return the record of a model's answer at a case, or None where there is none."""
        modes = self.answers.get((case, model)) if model else None
        if modes is None or model is None:
            return None
        count = min(self.plan.count, len(modes.frequencies))
        rows = mode_rows(case, label(model), settings(model, count + SPARE), modes, count)
        file = "--case-file FILE " if self.plan.case_file else ""
        fields = {
            "Case": f"{case.name}: {case.note}" if case.note else case.name,
            **answer(rows),
            "Command": f"rps-bench table {file}--cases {case.name} --references '{label(model)}'",
        }
        return self.note(f"{label(model)} at {case.name}", fields)

    @cached_property
    def run(self) -> int:
        """The record of this run: when, from which commit, on what."""
        about: dict[str, Any] = {"time": datetime.now(UTC), **provenance()}
        return self.ledger.add("This run", {**environment(about), "Command": self.command})
