"""Solves cases by models: each answer once, checked where it arrives, failures in words."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from analytic import InputError, Mechanism, Modes, Pose, limbs_at
from analytic.model import Model
from analytic.pairing import Pairing, pair
from harness import plugins  # noqa: F401  models of other packages stay out of this process
from harness.answer import NotTakenError, believed
from harness.case import Case
from harness.declared import available
from harness.listener import Listener
from harness.rows import mode_rows, settings
from harness.workers import LIMIT, Children, Failure, Task, attempt
from reference_models import ModelError

if TYPE_CHECKING:
    import pandas as pd

SPARE = 2
"""Modes solved for beyond those asked for, so that a mode that changes places is still found."""

Key = tuple[Case, Model]


def refuse_others(cases: Iterable[object], models: Iterable[object]) -> None:
    """Raise `InputError` naming what is no case, or no model."""
    for one in cases:
        if not isinstance(one, Case):
            raise InputError("cases", one, "a Case, such as Case(name, mechanism, pose, note)")
    for model in models:
        if not callable(getattr(model, "modes", None)) or not hasattr(model, "info"):
            expected = "a model, such as reference_models.parse(text, 'models') makes of a text"
            raise InputError("models", model, expected)


def label(model: Model) -> str:
    """Return what tables call a model: its label in the catalogue, or its parameters."""
    return str(getattr(model, "label", None) or repr(model))


@dataclass(frozen=True)
class Study:
    """Modes of every model at every case, by case and model themselves; failures in words.

    Attributes: `cases`; `models`; `count` of modes asked for (answers hold `SPARE` more);
    `answers` and `failures` by (case, model): each is in one of the two; `refused`, which of the
    failures are of models that cannot take such a mechanism at all.
    """

    cases: tuple[Case, ...]
    models: tuple[Model, ...]
    count: int
    answers: Mapping[Key, Modes]
    failures: Mapping[Key, str]
    refused: frozenset[Key] = frozenset()

    def get(self, case: Case, model: Model) -> Modes | None:
        """Return the modes, or None where the model failed."""
        return self.answers.get((case, model))

    def first(self, case: Case, model: Model) -> Modes | None:
        """Return the modes asked for, or None where the model failed."""
        found = self.get(case, model)
        return None if found is None else found.first(self.count)

    def pairing(self, case: Case, theory: Model, reference: Model) -> Pairing | None:
        """Return the partner in `reference` of each of the first `count` modes of `theory`."""
        first, second = self.first(case, theory), self.get(case, reference)
        if first is None or second is None:
            return None
        return pair(first, second, case.mechanism, case.pose)

    def complete(self, *models: Model) -> tuple[Case, ...]:
        """Return the cases at which all `models` have an answer."""
        return tuple(c for c in self.cases if all((c, model) in self.answers for model in models))

    def rows(self) -> list[dict[str, Any]]:
        """Return one tidy row a case, model and mode, each with its provenance; SI units.

        `assurance` is that of each mode with its partner in the case's first model with an answer;
        None for that model itself.
        """
        result = []
        for case in self.cases:
            answered = [model for model in self.models if (case, model) in self.answers]
            for model in answered:
                chosen = settings(model, self.count + SPARE)
                modes = self.answers[case, model]
                found = mode_rows(case, label(model), chosen, modes, self.count)
                if model != answered[0]:
                    pairing = self.pairing(case, model, answered[0])
                    assert pairing is not None, "both have an answer"
                    for row, assurance in zip(found, pairing.assurance.tolist(), strict=True):
                        row["assurance"] = assurance
                result += found
        return result

    def to_frame(self) -> "pd.DataFrame":
        """Return `rows` as a pandas frame, units in the names of its columns."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def _repr_html_(self) -> str:
        shown = ["case", "model", "mode", "frequency_hz", "uncertainty_hz", "assurance", "theory"]
        frame = self.to_frame()
        return str(frame[shown].to_html(index=False)) if len(frame) else "no answers"


class Bench:
    """Where studies solve: models that may crash or hang run in a process of their own.

    Every answer is kept while the bench lasts: no model solves the same case twice. `limit`:
    seconds that such a model may take for one pose. Use as a context, or `close` it.
    """

    def __init__(self, limit: float = LIMIT, listener: Listener | None = None) -> None:
        self.limit = limit
        self.listener = listener or Listener()
        self._children = Children()
        self._kept: dict[Hashable, Modes | Failure] = {}

    def run(self, cases: Iterable[Case], models: Iterable[Model], count: int = 6) -> Study:
        """Solve every case by every model.

        Raises `InputError` for a pose out of reach; a model that fails costs its own answers only.
        """
        cases, models = tuple(dict.fromkeys(cases)), tuple(dict.fromkeys(models))
        for case in cases:
            limbs_at(case.mechanism, case.pose)  # refuses a pose out of reach
        self.listener.expect(len(cases) * len(models))
        answers, failures, refused = {}, {}, set[Key]()
        for model in models:
            for case in cases:
                step = f"{label(model)} at {case.name}"
                self.listener.begin(step)
                most = available(case.mechanism, count + SPARE)
                found = self.solve(model, case.mechanism, case.pose, most)
                if isinstance(found, Failure):
                    failures[case, model] = found.reason
                    if found.refused:
                        refused.add((case, model))
                else:
                    answers[case, model] = found
                self.listener.done(step)
        return Study(cases, models, count, answers, failures, frozenset(refused))

    def solve(self, model: Model, mechanism: Mechanism, pose: Pose, count: int) -> Modes | Failure:
        """Return the checked modes of one model at one pose, or why there are none."""
        key = (model, mechanism, pose, count)
        if key not in self._kept:
            self._kept[key] = self._solve(model, mechanism, pose, count)
        return self._kept[key]

    def _solve(self, model: Model, mechanism: Mechanism, pose: Pose, count: int) -> Modes | Failure:
        if missing := model.info().missing:
            return Failure(f"cannot run here: {missing}")

        def call(one: Model, number: int) -> object:
            task = ModesTask(one, mechanism, pose, number)
            return _unless_failed(self.call(task, one.info().isolated))

        def known(other: Model, number: int) -> Modes:
            found: Modes = _unless_failed(self.solve(other, mechanism, pose, number))
            if other == model.limit():  # the same whoever asks: `run` takes it from here
                self._kept.setdefault((other, mechanism, pose, count), found.first(count))
            return found

        try:
            return believed(model, mechanism, pose, count, call, known)
        except ModelError as error:
            return Failure(str(error), refused=isinstance(error, NotTakenError))

    def call(self, task: Task, isolated: bool) -> object:
        """Return what a task answers, or a `Failure`; in a process of its own if `isolated`."""
        return self._children.attempt(task, self.limit) if isolated else attempt(task)

    def close(self) -> None:
        """End the processes."""
        self._children.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def _unless_failed(found: Any) -> Any:
    if isinstance(found, Failure):
        raise (NotTakenError if found.refused else ModelError)(found.reason)
    return found


@dataclass(frozen=True)
class ModesTask:
    """The `count` lowest modes of one model at one pose, as a worker solves it."""

    model: Model
    mechanism: Mechanism
    pose: Pose
    count: int

    def solve(self) -> object:
        """Return what the model answers."""
        return self.model.modes(self.mechanism, self.pose, self.count)


def run(
    cases: Iterable[Case] | Case,
    models: Iterable[Model] | Model,
    count: int = 6,
    *,
    limit: float = LIMIT,
    listener: Listener | None = None,
) -> Study:
    """Solve every case by every model on a bench of their own: `Bench.run`."""
    some = tuple(cases) if isinstance(cases, (list, tuple)) else (cases,)
    by = tuple(models) if isinstance(models, (list, tuple)) else (models,)
    refuse_others(some, by)
    with Bench(limit, listener) as bench:
        return bench.run(some, by, count)
