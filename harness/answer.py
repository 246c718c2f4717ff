"""What an answer must satisfy before it is a number: else it is a failure with a reason."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from numbers import Integral, Real
from time import perf_counter

import numpy as np

from analytic import STATIONS, Mechanism, Modes, Pose, limbs_at
from analytic.errors import NotCertifiedError
from analytic.model import Info, Model
from analytic.pairing import mass_vectors
from analytic.placed import place
from harness.causes import RICHEST
from harness.declared import COARSE, SAME, STILL, alone, asked, available, keeps
from harness.signatures import Array
from reference_models import ModelError
from reference_models.richardson import SPARE as CROSSING
from reference_models.richardson import extrapolated

CLOSED = 1e-9
"""Largest gap of a joint, relative to the mean limb length (and at least in metres)."""
TOGETHER = 1e-2
"""Largest distance of a limb's end from the platform's point or its base, relative to the shape:
the middle of a face that is joined on average leaves it by 0.4 % in the eighth mode."""
HEAVIEST = 1.5
"""Largest modal mass of centre lines and platform: a coarse mesh has another between stations."""
LIGHTEST = 0.2
"""Smallest modal mass of a low mode that moves centre lines or platform at all."""
SOFT, STIFF = 4.0, 10.0
"""Factors by which the lowest frequency may be above or below that of exact beams."""
LOWEST = 6
"""Lowest modes that move: ten parts of a limb show no more bends than theirs."""
SAID = {"theory": str, "model": str, "version": str, "dofs": Integral, "build_seconds": Real,
        "solve_seconds": Real, "residual": Real}  # fmt: skip
"""What an answer says beside its arrays; no number is below zero, and `residual` may be None."""


class NotTakenError(ModelError):
    """A mechanism that the model says it cannot take."""


def checked(
    answer: object,
    info: Info,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    exact: Modes | None = None,
) -> Modes:
    """Return `answer` with `count` modes if it is one to be believed; else raise `ModelError`.

    Frequencies are finite, not negative and ascend; shapes have the right form, are finite and of
    unit modal mass; limbs end at their bases and at the platform; joints are closed; frequencies
    are of the size of the `exact` ones, if there are some.
    """
    if type(answer) is not Modes:  # of another class anything may happen where it is read
        raise ModelError(f"it answered {type(answer).__name__}, where Modes were expected")
    _form(answer, count, len(mechanism.limbs))
    # Its own arrays, whatever the model does with its memory next; a -0.0 is 0.
    modes = replace(answer, frequencies=answer.frequencies + 0.0)
    _joints(modes, mechanism, pose)
    if exact is not None:
        _near(modes, exact)
    _masses(modes, info, mechanism, pose)
    return modes


def flaw(f: object, shape: tuple[int, ...], uncertainty: object = None) -> str:
    """Return why frequencies of this `shape` (..., modes) [Hz] are none to be believed, or their
    uncertainties; "" if they may be."""
    if not isinstance(f, np.ndarray):
        return f"its frequencies are a {type(f).__name__}, not an array"
    if f.shape != shape or f.dtype.kind != "f":
        return f"its frequencies have shape {f.shape} and type {f.dtype}, not {shape} numbers"
    if not np.isfinite(f).all():
        return f"its frequencies hold {f[~np.isfinite(f)][0]}"
    if (f < 0).any():
        return f"it gave a frequency below zero, {f[f < 0][0]:.6g} Hz"
    if (np.diff(f) < 0).any():
        return "its frequencies do not ascend"
    if uncertainty is not None:
        own = np.asarray(uncertainty)
        if own.shape != shape or not (np.isfinite(own) & (own >= 0)).all():
            return "its uncertainties are not one finite number of hertz a mode"
    return ""


def believed(
    model: Model,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    call: Callable[[Model, int], object],
    known: Callable[[Model, int], Modes],
) -> Modes:
    """Return the `count` lowest modes of `model` if they are to be believed.

    `call` asks a model with one mesh, or none, for so many modes; `known` gives what is believed of
    others: of the two meshes that are extrapolated, and of the exact limit that `model` declares.
    Raises `ModelError` for what is not to be believed, and whatever `call` raises.
    """
    info, found = model.info(), object()
    if isinstance(model.elements, tuple):
        meshes = []
        for number, spare in zip(model.elements, (2 * CROSSING, CROSSING), strict=True):
            mesh: Model = replace(model, elements=number)  # type: ignore[type-var]
            try:
                meshes.append(known(mesh, available(mechanism, count + spare)))
            except NotTakenError:
                raise
            except ModelError as error:
                raise ModelError(f"with {number} elements {error}") from None
        found = extrapolated(
            meshes[0], meshes[1], model.elements, info.order, mechanism, pose, count
        )
    else:
        found = call(model, count)
    exact, truth = None, _truth(model)
    with suppress(ModelError):  # it cannot be certified here: that is no fault of the model's
        exact = None if truth == model else known(truth, asked(mechanism, count))
    modes = checked(found, info, mechanism, pose, count, exact)
    if exact is not None and truth == model.limit():
        keeps(modes, info, model.elements, exact, mechanism, pose)
    return modes


def _truth(model: Model) -> Model:
    """Return the exact limit that a model declares; of what has none but itself, sheared beams."""
    limit = model.limit()
    return RICHEST if limit is None or limit == model else limit


def solved(model: Model, mechanism: Mechanism, pose: Pose, count: int) -> tuple[Modes, float]:
    """Return `believed` modes, solved in this process, and the seconds that `model` itself took."""
    truth, exact, seconds = _truth(model), list[Modes](), list[float]()

    def call(one: Model, number: int) -> object:
        began = perf_counter()
        answer = one.modes(mechanism, pose, number)
        seconds.append(perf_counter() - began)
        return answer

    def known(other: Model, number: int) -> Modes:
        if other != truth:
            return believed(other, mechanism, pose, number, call, known)
        if not exact or len(exact[0].frequencies) < number:
            try:
                exact[:] = [other.modes(mechanism, pose, number)]
            except NotCertifiedError as error:
                raise ModelError(str(error)) from None
        return exact[0].first(number)

    return believed(model, mechanism, pose, count, call, known), sum(seconds)


@dataclass(frozen=True)
class Batch:
    """The `table` (poses, modes) [Hz] that a model gave for many poses in one call of `seconds`."""

    table: Array
    seconds: float


@dataclass(frozen=True)
class BatchTask:
    """The `count` lowest frequencies of one model at `poses` (arrays) in one call."""

    model: Model
    mechanism: Mechanism
    poses: Pose
    count: int

    def solve(self) -> Batch:
        """Return them; raise `ModelError` where they are none to be believed."""
        began = perf_counter()
        table = np.asarray(self.model.frequencies(self.mechanism, self.poses, self.count))
        seconds = perf_counter() - began
        if why := flaw(table, (len(self.poses), self.count)):
            raise ModelError(why)
        return Batch(table, seconds)


def _form(modes: Modes, count: int, limbs: int) -> None:
    """Refuse an answer whose arrays are no plain, finite arrays of their shape, or whose words and
    numbers are none.

    Single precision has seven digits, a whole number of hertz three; a masked value is none.
    """
    shapes = {"frequencies": (count,), "uncertainty": (count,), "platform": (count, 6),
              "limbs": (count, limbs, len(STATIONS), 3)}  # fmt: skip
    for name, shape in shapes.items():
        value = getattr(modes, name)
        if value is None and name == "uncertainty":
            continue
        if type(value) is not np.ndarray:
            raise ModelError(f"its {name} are a {type(value).__name__}, not an array")
        if value.dtype != np.float64:
            raise ModelError(f"its {name} have type {value.dtype}, not float64")
        if name == "frequencies" and value.ndim == 1 and len(value) != count:
            raise ModelError(f"it gave {len(value)} modes, where {count} were asked for")
        if len(shape) > 1 and value.shape != shape:
            raise ModelError(f"its shapes of the {name} are {value.shape}, not {shape}")
        if len(shape) > 1 and not np.isfinite(value).all():
            raise ModelError(f"its shapes of the {name} are not finite")
    if why := flaw(modes.frequencies, (count,), modes.uncertainty):
        raise ModelError(why)
    for name, kind in SAID.items():
        value, number = getattr(modes, name), kind is not str
        if value is None and name == "residual":
            continue
        good = isinstance(value, kind) and not isinstance(value, bool)
        if not good or (number and not float(value) >= 0):
            expected = "number" if number else "text"
            raise ModelError(f"its {name} is {value!r}, where a {expected} was expected")


def _joints(modes: Modes, mechanism: Mechanism, pose: Pose) -> None:
    limbs = limbs_at(mechanism, pose)
    gap, size = modes.residual, float(limbs.lengths.mean())
    if gap is not None and gap > CLOSED * size:
        raise ModelError(
            f"its joints are open by {gap:.1e} m, more than {CLOSED:.0e} of a limb: its "
            "frequencies are not those of the closed mechanism"
        )
    tips = modes.platform[:, None, :3] + np.cross(modes.platform[:, None, 3:], limbs.arms[None])
    ends = np.concatenate([modes.limbs, tips[:, :, None]], axis=2)
    largest = np.abs(ends).max(axis=(1, 2, 3))
    largest = np.maximum(largest, STILL * largest.max())  # of one that moves neither: rounding
    base, tip = _held(mechanism, pose)
    for what, off, held in (
        ("limbs leave the platform's points", modes.limbs[:, :, -1] - tips, tip),
        ("limbs leave their bases", modes.limbs[:, :, 0], base),
    ):
        far = np.abs(np.einsum("nij,mnj->mni", held, off)).max(axis=(1, 2)) > TOGETHER * largest
        if far.any():
            raise ModelError(f"in the shape of mode {int(far.argmax()) + 1} {what}")


def _held(mechanism: Mechanism, pose: Pose) -> tuple[Array, Array]:
    """Return projectors on where the joints before the first and after the last rod of every limb
    (or link, of one without rods) let its line move by nothing, at the base and at A_i, each
    (n, 3, 3).
    """
    found = np.empty((2, len(mechanism.limbs), 3, 3))
    for group in place(mechanism, pose):
        links = [k for k, kind in enumerate(group.alike.kind) if kind[0] == "link"]
        rods = group.alike.rods or links or [0]
        for end, at, joints in (
            (0, 0, [k for k in group.alike.freedoms if k < rods[0]]),
            (1, -1, [k for k in group.alike.freedoms if k > rods[-1]]),
        ):
            ways = [np.zeros((len(group.alike.limbs), 3, 0))]
            for k in joints:
                twists, arm = group.twists(k), group.starts[:, at] - group.starts[:, k]
                ways.append(twists[:, :3] + np.cross(twists[:, 3:], arm[..., None], axis=1))
            free = np.concatenate(ways, axis=-1)
            found[end][group.alike.limbs] = np.eye(3) - free @ np.linalg.pinv(free, rcond=SAME)
    return found[0], found[1]


def _masses(modes: Modes, info: Info, mechanism: Mechanism, pose: Pose) -> None:
    """Refuse modes whose mass, of centre lines and platform, is not scaled to one.

    A mode that moves neither is of a limb alone, which twists or turns a body, and none does below
    its first own frequency.
    """
    mass = (mass_vectors(modes, mechanism, pose) ** 2).sum(axis=1)
    still = mass < STILL**2
    turn = np.linalg.norm(modes.platform[:, 3:], axis=1)
    if not mechanism.simple:  # a platform of next to no inertia turns with a rod that twists
        still &= turn <= STILL * turn.max()
    wrong = still
    if still.any() and info.torsion:
        highest = COARSE * float(modes.frequencies.max())
        wrong = still & (modes.frequencies <= alone(mechanism, pose, highest) / COARSE)
    if wrong.any():
        number = int(wrong.argmax()) + 1
        raise ModelError(f"mode {number} moves nothing, and no rod twists or body turns there")
    # Far up, sections may turn and lines hardly move.
    low = ~still & (np.cumsum(~still) <= LOWEST)
    light = low & (mass < LIGHTEST)
    if not mechanism.simple and (low & ~light).any():
        light[:] = False  # limbs between springs may twist, and move their lines a little
    wrong = (~still & (mass > HEAVIEST)) | light
    if wrong.any():
        i = int(wrong.argmax())
        raise ModelError(f"mode {i + 1} has a modal mass of {mass[i]:.3g}, where 1 was expected")


def _near(modes: Modes, exact: Modes) -> None:
    """Refuse frequencies far from those of exact beams: a wrong unit is a factor of six or more."""
    first = int((exact.frequencies == 0).sum())
    own, beams = modes.frequencies[first:], exact.frequencies[first:]
    if len(own) and not 1 / STIFF <= own[0] / beams[0] <= SOFT:
        unit = ": is it in hertz?" if own[0] else ""
        raise ModelError(
            f"its f{first + 1} is {own[0]:.4g} Hz, where exact beams have {beams[0]:.4g} Hz{unit}"
        )
