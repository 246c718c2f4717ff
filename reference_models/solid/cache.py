"""`solid-limb`: limbs known by tables from NGSolve's rods, kept on disk by what made them."""

import json
import os
import tempfile
import warnings
import zipfile
from dataclasses import asdict, dataclass, fields, replace
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.folder import default_folder
from reference_models.solid.limb import SolidLimb
from reference_models.solid.ngsolve import NgsolveSolid, held_rods
from reference_models.solid.table import LimbTable
from reference_models.solid.table_maker import FORM, limb_table

Array = NDArray[np.float64]


class CacheWarning(UserWarning):
    """A table that could not be read or kept; it has been made anew and nothing is lost."""


@dataclass(frozen=True)
class TabledLimb:
    """`solid-limb`: the mechanism on limbs known by tables over their length.

    The tables are made from rods meshed as `NgsolveSolid(elements, order, faces)` meshes them, at
    the first pose that needs one, in seconds, and kept in the user's cache. Raises `InputError` as
    `NgsolveSolid`.
    """

    elements: int = 4
    order: int = 2
    faces: str = "rigid"

    def __post_init__(self) -> None:
        NgsolveSolid(self.elements, self.order, self.faces)

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        made_from = NgsolveSolid.info()
        return replace(
            made_from,
            program=f"rps-bench on {made_from.program}",
            refinements=None,
            ladder=(2, 4),
            remark="limbs reduced and interpolated over their length; uncertainty of interpolation "
            "only: its mesh is ngsolve-solid's",
            slow=False,
            isolated=False,
        )

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Array:
        """Return the `count` lowest frequencies [Hz] at every pose, (len(poses), count)."""
        return self.limb().frequencies(mechanism, poses, count)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `SolidLimb.frequencies`."""
        return self.limb().modes(mechanism, pose, count)

    def limb(self, folder: Path | None = None) -> SolidLimb:
        """Return the limb's tables as a model; `folder`: where they are kept instead."""
        return _limb(self, default_folder() if folder is None else folder)


@cache
def _limb(model: TabledLimb, where: Path) -> SolidLimb:
    rods = NgsolveSolid(model.elements, model.order, model.faces)

    @cache
    def tables(poisson: float, octave: int) -> LimbTable:
        settings = {
            "form": FORM,
            "poisson": repr(float(poisson)),
            "octave": octave,
            **asdict(rods),
            **{package: version(package) for package in ("ngsolve", "netgen-mesher", "scipy")},
        }
        key = sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()
        path = where / f"solid-limb-{key[:32]}.npz"
        known = _read(path)
        if known is None:
            held = held_rods(poisson, model.elements, model.order, model.faces)
            known = limb_table(held, octave)
            _write(path, known)
        return known

    return SolidLimb(tables, rods.theory, f"ngsolve {version('ngsolve')}", model.elements)


def _read(path: Path) -> LimbTable | None:
    """Return the table in `path`; None, with a warning, if the file is damaged."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        _warn(f"{path} cannot be read ({error.strerror}); its table is made anew")
        return None
    try:
        # The last bytes are the checksum of all before: a cut or altered file is never half used.
        if sha256(content[:-32]).digest() != content[-32:]:
            raise ValueError("its checksum does not fit")
        with np.load(BytesIO(content[:-32]), allow_pickle=False) as stored:
            values: dict[str, Any] = {field.name: stored[field.name] for field in fields(LimbTable)}
    except (ValueError, KeyError, OSError, zipfile.BadZipFile) as error:
        _warn(f"{path} is damaged ({error}); its table is made anew")
        return None
    return LimbTable(**values | {"octave": int(values["octave"])})


def _write(path: Path, table: LimbTable) -> None:
    """Keep `table` in `path`, whole or not at all."""
    buffer = BytesIO()
    np.savez(buffer, **{field.name: getattr(table, field.name) for field in fields(LimbTable)})
    content = buffer.getvalue()
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(content + sha256(content).digest())
        Path(temporary).replace(path)
    except OSError as error:
        _warn(f"{path} cannot be written ({error.strerror}); its table will not be kept")
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)


def _warn(message: str) -> None:
    warnings.warn(message, CacheWarning, stacklevel=3)
