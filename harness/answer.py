"""What an answer must satisfy before it is a number: else it is a failure with a reason."""

import numpy as np

from analytic import STATIONS, Mechanism, Modes, Pose, limbs_at
from analytic.model import Info
from analytic.pairing import mass_vectors
from reference_models import ModelError

CLOSED = 1e-9
"""Largest gap of a joint, relative to the mean limb length (and at least in metres)."""
TOGETHER = 1e-3
"""Largest distance of a limb's end from the platform's point or its base, relative to the shape."""
HEAVIEST = 1.02
"""Largest modal mass of centre lines and platform; rotary inertia only takes from it."""
LIGHTEST = 0.2
"""Smallest modal mass of a mode that moves centre lines or platform at all."""
STILL = 1e-3
"""Below this root of a modal mass a mode moves neither: a limb that twists alone."""


def checked(answer: object, info: Info, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
    """Return `answer` with `count` modes if it is one to be believed; else raise `ModelError`.

    Frequencies are finite, not negative and ascend; shapes have the right form, are finite and of
    unit modal mass; limbs end at their bases and at the platform; joints are closed.
    """
    if not isinstance(answer, Modes):
        raise ModelError(f"it answered {type(answer).__name__}, where Modes were expected")
    frequencies = _frequencies(answer, count)
    _form(answer, mechanism)
    modes = answer.first(count)
    if (np.diff(frequencies[:count]) < 0).any():
        raise ModelError("its frequencies do not ascend")
    _joints(modes, mechanism, pose)
    _masses(modes, info, mechanism, pose)
    return modes


def _frequencies(modes: Modes, count: int) -> np.ndarray:
    f = np.asarray(modes.frequencies)
    if f.ndim != 1 or f.dtype.kind not in "fiu":
        raise ModelError(f"its frequencies have shape {f.shape} and type {f.dtype}, not ({count},)")
    if len(f) < count:
        raise ModelError(f"it gave {len(f)} modes of the {count} asked for")
    bad = f[~np.isfinite(f)]
    if bad.size:
        raise ModelError(f"its frequencies hold {bad[0]}")
    if (f < 0).any():
        raise ModelError(f"it gave a frequency below zero, {f[f < 0][0]:.6g} Hz")
    uncertainty = modes.uncertainty
    if uncertainty is not None and (
        np.shape(uncertainty) != f.shape
        or not (np.isfinite(uncertainty) & (uncertainty >= 0)).all()
    ):
        raise ModelError("its uncertainties are not one finite number of hertz a mode")
    return f


def _form(modes: Modes, mechanism: Mechanism) -> None:
    number, limbs = len(modes.frequencies), len(mechanism.limbs)
    for name, values, shape in (
        ("platform", modes.platform, (number, 6)),
        ("limbs", modes.limbs, (number, limbs, len(STATIONS), 3)),
    ):
        if np.shape(values) != shape:
            raise ModelError(f"its shapes of the {name} are {np.shape(values)}, not {shape}")
        if not np.isfinite(values).all():
            raise ModelError(f"its shapes of the {name} are not finite")


def _joints(modes: Modes, mechanism: Mechanism, pose: Pose) -> None:
    limbs = limbs_at(mechanism, pose)
    size = float(limbs.lengths.mean())
    gap = modes.residual
    if gap is not None and not gap <= CLOSED * size:
        raise ModelError(
            f"its joints are open by {gap:.1e} m, more than {CLOSED:.0e} of a limb: its "
            "frequencies are not those of the closed mechanism"
        )
    shift, spin = modes.platform[:, None, :3], modes.platform[:, None, 3:]
    tips = shift + np.cross(spin, limbs.arms[None])
    largest = np.abs(modes.limbs).max(axis=(1, 2, 3), initial=0.0)
    largest = np.maximum(largest, np.abs(tips).max(axis=(1, 2)))
    for what, off in (
        ("limbs leave the platform's points", modes.limbs[:, :, -1] - tips),
        ("limbs leave their bases", modes.limbs[:, :, 0]),
    ):
        far = np.abs(off).max(axis=(1, 2)) > TOGETHER * largest
        if far.any():
            raise ModelError(f"in the shape of mode {int(far.argmax()) + 1} {what}")


def _masses(modes: Modes, info: Info, mechanism: Mechanism, pose: Pose) -> None:
    """Refuse shapes that are not of unit modal mass, as far as centre lines and platform tell."""
    mass = (mass_vectors(modes, mechanism, pose) ** 2).sum(axis=1)
    still = mass < STILL**2
    if still.any() and not info.torsion:
        raise ModelError(f"mode {int(still.argmax()) + 1} moves nothing, and its rods do not twist")
    wrong = ~still & ((mass > HEAVIEST) | (mass < LIGHTEST))
    if wrong.any():
        i = int(wrong.argmax())
        raise ModelError(f"mode {i + 1} has a modal mass of {mass[i]:.3g}, where 1 was expected")
