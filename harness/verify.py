"""What a model's author should know before anyone believes it: `rps-bench verify MODEL`.

Nothing is judged here that the bench does not judge anyway: answers as they arrive, and the gate's
properties on a plan of this one model. Beside them: how it describes itself, how it refuses.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from analytic import InputError, Mechanism, Pose
from analytic.pairing import TRUSTED, assurance, mass_vectors
from harness.bench import Bench, label
from harness.cases import PRESETS
from harness.declared import STILL
from harness.gate.equivalents import precision
from harness.gate.figures import Finding
from harness.gate.gate import measure
from harness.gate.plan import MODES, Checked, Plan, solve, standard
from harness.gate.properties import properties
from harness.plugins import Question
from harness.poses import turned as turned_pose
from harness.result import Result
from harness.tables import Table
from harness.workers import Failure
from reference_models import ModelError, Named, parse
from reference_models.catalogue import known

if TYPE_CHECKING:
    from harness.bench import Study

LEVEL, TILTED = PRESETS["case1"], PRESETS["case2"]
HALF = 0.5
"""Orders of elements are whole numbers: an observed one is that of the nearest."""
MANY = 10_000_000
"""More modes than any model has."""


@dataclass(frozen=True)
class Answer:
    """The answer to one question: whether it `holds`, None where it could not be asked."""

    question: str
    holds: bool | None
    found: str


@dataclass(frozen=True)
class Verified(Result):
    """All that was asked of the model called `name`; what was `solved` for it."""

    name: str
    answers: tuple[Answer, ...]
    solved: "tuple[Study, ...]" = ()

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return all(one.holds is not False for one in self.answers)

    @property
    def studies(self) -> "tuple[Study, ...]":
        """What was solved for it."""
        return self.solved

    def failures(self) -> dict[str, str]:
        """Return what fails by its question: what was found instead."""
        return {one.question: one.found for one in self.answers if one.holds is False}

    def records(self) -> list[dict[str, Any]]:
        """Return one row a question."""
        return [{"model": self.name, **vars(one)} for one in self.answers]

    def tables(self) -> dict[str, Table]:
        """Return one row a question."""
        words = {True: "yes", False: "NO", None: "not asked"}
        rows = tuple((one.question, words[one.holds], one.found) for one in self.answers)
        return {"": Table(f"Model {self.name}", ("What must hold", "Holds", "Found"), rows)}

    def sentences(self) -> list[str]:
        """Return the outcome."""
        failed, asked = len(self.failures()), sum(one.holds is not None for one in self.answers)
        outcome = f"{failed} of {asked} do not hold" if failed else f"all {asked} hold"
        return [f"{self.name}: {outcome}."]


def verify(name: str, bench: Bench | None = None) -> Verified:
    """Return what of the model called `name` holds, at the paper's two cases.

    Raises `InputError` for a name that is not in the catalogue.
    """
    known(name, "model")
    if bench is None:
        with Bench() as own:
            return verify(name, own)
    described = [*_described(name)]
    if any(one.holds is False for one in described):
        return Verified(name, tuple(described))
    plan = _plan(name)
    checked = solve(plan, bench)
    answers = [*described, _answered(checked)]
    if answers[-1].holds:
        about = ((one, parse(one.model, "model").name) for one in properties(checked))
        answers += [_property(one) for one, of in about if of == name]
        answers += [_order(checked), *_repeated(checked)]
    answers += _refusals(plan.everywhere[0], bench)
    return Verified(name, tuple(answers), (checked.cases,))


def _described(name: str) -> Iterator[Answer]:
    """What it says of itself."""
    model = Named(name, None)
    info = model.info()
    yield Answer("it can be loaded and runs here", not info.missing, info.missing or "it does")
    if info.missing:
        return
    wrong = [
        f"{what} is empty" for what in ("theory", "program", "version") if not getattr(info, what)
    ]
    if not info.order > 0:
        wrong.append(f"its order is {info.order}")
    if not info.ladder or any(a >= b for a, b in pairwise(info.ladder)):
        wrong.append(f"its ladder {info.ladder} does not ascend")
    if info.refinements and not info.refinements[0] < info.refinements[1]:
        wrong.append(f"its refinements {info.refinements} do not ascend")
    said = f"theory {info.theory}, order {info.order:g}, limit {info.limit or 'none'}"
    yield Answer("its info() makes sense", not wrong, "; ".join(wrong) or said)


def _plan(name: str) -> Plan:
    """Return the gate's plan of one model; its map is one pose, turned from limb to limb."""
    plan = standard((LEVEL, TILTED), [name])
    coarse = plan.ladders[0][0]
    limbs = len(TILTED.mechanism.limbs)
    turned = tuple(
        replace(
            TILTED,
            name=f"{TILTED.name} turned by {360 / limbs * k:g} deg",
            pose=turned_pose(TILTED.pose, 2 * np.pi / limbs * k),
        )
        for k in range(limbs)
    )
    return replace(plan, mapped=(coarse,), poses=turned)


def _answered(checked: Checked) -> Answer:
    """What fails as an answer arrives: units, shapes, joints, modal mass, mode counts."""
    question = "its answers can be believed: hertz, modes, joints, shapes, modal mass"
    said = {
        f"{label(model)} at {case.name}: {why}": why
        for study in checked.studies
        for (case, model), why in study.failures.items()
    }
    said |= {f"many poses a call: {x.reason}": x.reason for x in checked.batches.values()
             if isinstance(x, Failure)}  # fmt: skip
    if said:
        first = {why: where for where, why in reversed(said.items())}  # each reason once
        return Answer(question, False, "; ".join(reversed(first.values())))
    number = sum(len(study.answers) for study in checked.studies)
    return Answer(question, True, f"{number} answers on {len(checked.plan.everywhere)} meshes")


def _property(one: Finding) -> Answer:
    where = f"{one.case}, mode {one.mode}"
    said = f"off by {one.after:.1e} at {where}; allowed {one.tolerance:.1e} ({one.cause})"
    return Answer(f"{one.quantity}: {one.model}", not one.fails, said)


def _order(checked: Checked) -> Answer:
    """Its frequencies converge at the order that it declares."""
    question = "its order of convergence is as declared"
    orders = measure(checked).orders.values()
    if not orders:
        return Answer(question, None, "no three meshes whose differences are more than rounding")
    formal = checked.plan.ladders[0][0].info().order
    seen = float(np.median([one.p for one in orders]))
    steps = ", ".join(str(model.elements) for model in checked.plan.ladders[0])
    said = f"observed {seen:.2f} on {steps} elements, declared {formal:g}"
    return Answer(question, bool(abs(seen - formal) < HALF), said)


def _repeated(checked: Checked) -> Iterator[Answer]:
    """Level on equal limbs f1 = f2, and no two modes are one."""
    off, bound, alike = 0.0, 0.0, ""
    for (case, model), modes in checked.cases.answers.items():
        if case == LEVEL:
            f, own = modes.frequencies, precision(model, case)
            off, bound = max((off, bound), (abs(f[1] / f[0] - 1), float(own[:2].sum())))
        v = mass_vectors(modes.first(MODES), case.mechanism, case.pose)
        matrix = np.triu(assurance(v, v, np.arange(1.0, MODES + 1)), 1)
        moving = np.linalg.norm(v, axis=1) > STILL
        matrix *= np.outer(moving, moving)
        if matrix.max() > TRUSTED:
            i, j = np.unravel_index(matrix.argmax(), matrix.shape)
            alike = f"modes {i + 1} and {j + 1} of {label(model)} at {case.name} are one shape"
    said = f"f2/f1 - 1 is {off:.1e}, allowed {bound:.1e} (rounding)"
    yield Answer("f1 = f2 of the level platform on three equal limbs", bool(off <= bound), said)
    yield Answer("no two modes are one", not alike, alike or "all shapes differ")


def _refused(mechanism: Mechanism, pose: Pose, count: int, model: Named) -> str:
    """Return "" where a call that cannot be answered is refused in a sentence, or what happened."""
    try:
        answer = model.build().modes(mechanism, pose, count)
    except (InputError, ModelError) as error:
        return "" if str(error).strip() else "the error says nothing"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return f"it answered with {type(answer).__name__}"


def _refusals(model: Named, bench: Bench) -> Iterator[Answer]:
    """What cannot be answered is refused by an `InputError`, not by chance."""
    several = Pose(np.array([0.48, 0.49]))
    for what, one, at, count in (
        ("no modes (count=0)", model, TILTED.pose, 0),
        ("more modes than it has", model, TILTED.pose, MANY),
        ("no elements (elements=0)", replace(model, elements=0), TILTED.pose, MODES),
        ("several poses at once", model, several, MODES),
    ):
        said = bench.call(
            Question(one, partial(_refused, TILTED.mechanism, at, count)), isolated=True
        )
        why = said.reason if isinstance(said, Failure) else str(said)
        yield Answer(
            f"refused in a sentence: {what}", not why,
            f"{why}; raise analytic.InputError(name, value, expected)" if why else "it is",
        )  # fmt: skip
