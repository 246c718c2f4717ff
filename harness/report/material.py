"""What the sections are made from: the results of one run, and every answer in them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property
from itertools import chain
from typing import Any, TypeVar

from analytic import Modes
from analytic.model import Model
from harness.bench import SPARE, Study, label
from harness.case import Case
from harness.report.section import Fields, Ledger, answer, environment
from harness.reproduce import Part
from harness.request import Plan
from harness.result import Result
from harness.rows import mode_rows, settings
from harness.studies import find
from reference_models import Named

R = TypeVar("R", bound=Result)
FEWEST = 3
"""Numbers of elements that make a curve."""


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
        from harness.history.provenance import provenance

        about: dict[str, Any] = {"time": datetime.now(UTC), **provenance()}
        return self.ledger.add("This run", {**environment(about), "Command": self.command})
