"""What a model's author should know before anyone believes it: `rps-bench verify MODEL`.

Nothing is judged here that the bench does not judge anyway: answers as they arrive, and the gate's
properties on a plan of this one model. Beside them: how it describes itself, how it refuses.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from analytic import InputError, Mechanism, Pose
from analytic.pairing import TRUSTED, assurance, mass_vectors
from harness.bench import Bench, label
from harness.cases import PRESETS
from harness.declared import STILL
from harness.gate.equivalents import precision
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


class Answer(NamedTuple):
    """The answer to one question: whether it `holds`, None where it could not be asked."""

    question: str
    holds: bool | None
    found: str


@dataclass(frozen=True)
class Verified(Result):
    """All that was asked of the model called `name`; `studies`: what was solved for it."""

    name: str
    answers: tuple[Answer, ...]
    studies: "tuple[Study, ...]" = ()

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return not self.failures()

    def failures(self) -> dict[str, str]:
        """Return what fails by its question: what was found instead."""
        return {one.question: one.found for one in self.answers if one.holds is False}

    def records(self) -> list[dict[str, Any]]:
        """Return one row a question."""
        return [{"model": self.name, **one._asdict()} for one in self.answers]

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
    answers = [*_described(name)]
    if any(one.holds is False for one in answers):
        return Verified(name, tuple(answers))
    plan = _plan(name)
    checked = solve(plan, bench)
    answers.append(_answered(checked))
    if answers[-1].holds:
        answers += [
            Answer(f"{one.quantity}: {one.model}", not one.fails,
                   f"off by {one.after:.1e} at {one.case}, mode {one.mode}; "
                   f"allowed {one.tolerance:.1e} ({one.cause})")
            for one in properties(checked) if parse(one.model, "model").name == name
        ]  # fmt: skip
        answers += [_order(checked), *_repeated(checked)]
    answers += _refusals(plan.everywhere[0], bench)
    return Verified(name, tuple(answers), (checked.cases,))


def _described(name: str) -> Iterator[Answer]:
    """What it says of itself."""
    info = Named(name, None).info()
    yield Answer("it can be loaded and runs here", not info.missing, info.missing or "it does")
    if info.missing:
        return
    ladder, both = info.ladder, info.refinements
    makes_sense = {f"{x} is empty": getattr(info, x) for x in ("theory", "program", "version")} | {
        f"its order is {info.order}": info.order > 0,
        f"its ladder {ladder} does not ascend": ladder and ladder == (*sorted({*ladder}),),
        f"its refinements {both} do not ascend": not both or both[0] < both[1],
    }
    wrong = "; ".join(fault for fault, good in makes_sense.items() if not good)
    said = f"theory {info.theory}, order {info.order:g}, limit {info.limit or 'none'}"
    yield Answer("its info() makes sense", not wrong, wrong or said)


def _plan(name: str) -> Plan:
    """Return the gate's plan of one model; its map is one pose, turned from limb to limb."""
    plan = standard((LEVEL, TILTED), [name])
    limbs = len(TILTED.mechanism.limbs)
    turned = tuple(
        replace(TILTED, name=f"{TILTED.name} turned by {360 / limbs * k:g} deg",
                pose=turned_pose(TILTED.pose, 2 * np.pi / limbs * k))
        for k in range(limbs)
    )  # fmt: skip
    return replace(plan, mapped=plan.ladders[0][:1], poses=turned)


def _answered(checked: Checked) -> Answer:
    """What fails as an answer arrives: units, shapes, joints, modal mass, mode counts."""
    question = "its answers can be believed: hertz, modes, joints, shapes, modal mass"
    said: dict[str, str] = {}  # each reason once, where it came first
    for study in checked.studies:
        for (case, model), why in study.failures.items():
            said[why] = said.pop(why, f"{label(model)} at {case.name}: {why}")
    for many in checked.batches.values():
        if isinstance(many, Failure):
            said[many.reason] = said.pop(many.reason, f"many poses a call: {many.reason}")
    number = sum(len(study.answers) for study in checked.studies)
    good = f"{number} answers on {len(checked.plan.everywhere)} meshes"
    return Answer(question, not said, "; ".join(said.values()) or good)


def _order(checked: Checked) -> Answer:
    """Its frequencies converge at the order that it declares."""
    question = "its order of convergence is as declared"
    orders = [one.p for one in measure(checked).orders.values()]
    if not orders:
        return Answer(question, None, "no three meshes whose differences are more than rounding")
    ladder = checked.plan.ladders[0]
    formal, seen = ladder[0].info().order, float(np.median(orders))
    steps = ", ".join(str(model.elements) for model in ladder)
    said = f"observed {seen:.2f} on {steps} elements, declared {formal:g}"
    return Answer(question, abs(seen - formal) < HALF, said)


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
    for what, one, at, count in (
        ("no modes (count=0)", model, TILTED.pose, 0),
        ("more modes than it has", model, TILTED.pose, MANY),
        ("no elements (elements=0)", replace(model, elements=0), TILTED.pose, MODES),
        ("several poses at once", model, Pose(np.array([0.48, 0.49])), MODES),
    ):
        asked = Question(one, partial(_refused, TILTED.mechanism, at, count))
        said = bench.call(asked, isolated=True)
        why = said.reason if isinstance(said, Failure) else str(said)
        found = f"{why}; raise analytic.InputError(name, value, expected)" if why else "it is"
        yield Answer(f"refused in a sentence: {what}", not why, found)
