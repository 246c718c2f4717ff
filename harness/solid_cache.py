"""`SolidLimb` from NGSolve's rods, its tables kept on disk by what they were made from."""

import json
import os
import tempfile
import warnings
import zipfile
from dataclasses import asdict, fields
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from analytic.limb_table import LimbTable
from analytic.solid_limb import SolidLimb
from reference_models import UnavailableError
from reference_models.ngsolve_solid import NgsolveSolid, held_rods
from reference_models.solid_table import FORM, limb_table


class CacheWarning(UserWarning):
    """A table that could not be read or kept; it has been made anew and nothing is lost."""


def solid_limb(
    elements: int = 4, order: int = 2, faces: str = "rigid", folder: Path | None = None
) -> SolidLimb:
    """Return the model on rods meshed as `NgsolveSolid(elements, order, faces)` meshes them.

    A table is made at the first pose that needs it, in seconds, and kept in `folder` (default:
    the user's cache). Raises `InputError` as `NgsolveSolid`, and `UnavailableError` without it.
    """
    model = NgsolveSolid(elements, order, faces)
    info = model.info()
    if info.missing:
        raise UnavailableError(f"solid-limb cannot run here: {info.missing}")
    where = default_folder() if folder is None else folder

    @cache
    def tables(poisson: float, octave: int) -> LimbTable:
        settings = {
            "form": FORM,
            "poisson": repr(float(poisson)),
            "octave": octave,
            **asdict(model),
            **{package: version(package) for package in ("ngsolve", "netgen-mesher", "scipy")},
        }
        key = sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()
        path = where / f"solid-limb-{key[:32]}.npz"
        known = _read(path)
        if known is None:
            known = limb_table(held_rods(poisson, elements, order, faces), octave)
            _write(path, known)
        return known

    name = f"{model.theory}, limbs reduced and interpolated"
    return SolidLimb(tables, name, f"rps-bench on ngsolve {info.version}", elements)


def default_folder() -> Path:
    """Return the user's cache folder, as the XDG base directories name it."""
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "rps-bench"


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
