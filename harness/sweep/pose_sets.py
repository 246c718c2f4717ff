"""Sets of poses as people write them, in degrees and millimetres, or as files.

pose:490,10,-12                 one pose: z [mm], azimuth, tilt [deg]; 0.49m,0.17rad,-0.2rad too
random:1000:7                   1000 poses by seed 7; z 350-700 mm, any azimuth, tilt to 20 deg
random:1000:z=400..500,tilt=5   the same in other ranges
grid:z=350..700x8,azimuth=0..360x12,tilt=0..20x5
workspace:1000:7                1000 poses by seed 7 in the regular workspace of the mechanism
FILE.csv, FILE.parquet          columns z_mm, azimuth_deg, tilt_deg, or z_m, azimuth_rad, tilt_rad
"""

import math
from glob import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Mechanism, Pose, position
from analytic.errors import number
from analytic.regular_workspace import regular_workspace
from analytic.workspace import Limits, heights

OPTION = "poses"
FORMS = (
    "pose:Z,AZIMUTH,TILT, random:N[:SEED][:RANGES], grid:RANGES, workspace:N[:SEED], FILE.csv or "
    "FILE.parquet"
)
RANGES = {"z": (350.0, 700.0), "azimuth": (0.0, 360.0), "tilt": (0.0, 20.0)}  # mm, deg
MOST = 1_000_000_000
BLOCK = 10_000
"""Poses drawn and checked at a time, so that memory holds little more than the set."""
LAYERS = 41
"""Layers of the regular workspace; in between its radius is linear."""

_UNITS = {"z": ("m", 1e-3), "azimuth": ("rad", math.pi / 180), "tilt": ("rad", math.pi / 180)}
_COLUMNS = (("z_mm", "azimuth_deg", "tilt_deg"), ("z_m", "azimuth_rad", "tilt_rad"))
Floats = NDArray[np.float64]


def pose_set(text: str, mechanism: Mechanism) -> Pose:
    """Return the poses that `text` names, each of which `mechanism` can take; arrays.

    Raises `InputError` for what cannot be read or reached.
    """
    kind, _, rest = text.partition(":")
    if kind == "pose":
        poses = _one(text, rest)
    elif kind == "random":
        poses = _random(text, rest)
    elif kind == "grid":
        poses = _grid(text, rest)
    elif kind == "workspace":
        count, seed, _ = _drawn(text, rest, ranges=False)
        limits = Limits()
        layers = np.linspace(*heights(mechanism, limits), LAYERS)
        poses = regular_workspace(mechanism, layers, limits).random(count, seed)
    elif Path(text).suffix.lower() in (".csv", ".parquet"):
        poses = _file(Path(text))
    else:
        raise InputError(OPTION, text, FORMS)
    for start in range(0, len(poses), BLOCK):
        position(mechanism, poses[start : start + BLOCK])
    return poses


def written(pose: Pose) -> str:
    """Return the text that `pose_set` reads back as this very pose, to the last bit."""
    return f"pose:{float(pose.z)!r}m,{float(pose.azimuth)!r}rad,{float(pose.tilt)!r}rad"


def _one(text: str, rest: str) -> Pose:
    expected = "pose:Z,AZIMUTH,TILT in mm and degrees, as in pose:490,10,-12"
    parts = rest.split(",")
    if len(parts) != 3:
        raise InputError(OPTION, text, expected)
    values = []
    for part, (unit, scale) in zip(parts, _UNITS.values(), strict=True):
        plain = part.removesuffix(unit)
        values.append(_float(text, plain, expected) * (scale if plain == part else 1.0))
    return Pose(*(np.array([value]) for value in values))


def _random(text: str, rest: str) -> Pose:
    count, seed, ranges = _drawn(text, rest, ranges=True)
    low, high = (np.array([limits[k] for limits in ranges.values()]) for k in (0, 1))
    # A pose's numbers are drawn together: a longer set begins with the shorter one.
    generator, drawn = np.random.default_rng(seed), np.empty((3, count))
    for start in range(0, count, BLOCK):
        some = drawn[:, start : start + BLOCK]
        some[:] = (low + (high - low) * generator.random((some.shape[1], 3))).T
    drawn[0] /= 1000
    np.radians(drawn[1:], out=drawn[1:])
    return Pose(*drawn)


def _drawn(text: str, rest: str, ranges: bool) -> tuple[int, int, dict[str, tuple[float, float]]]:
    """Return how many poses, the seed and the ranges in N[:SEED][:RANGES]."""
    expected = f"{text.partition(':')[0]}:N[:SEED]{'[:RANGES]' if ranges else ''} with N above 0"
    number_of, *more = rest.split(":")
    seed, chosen = 0, dict(RANGES)
    if more and more[0].isdecimal():
        seed = int(more.pop(0))
    if more and ranges:
        for name, (low, high, steps) in _ranges(text, more.pop(0)).items():
            if steps is not None:
                without = "ranges such as z=350..700, without a number of steps"
                raise InputError(OPTION, text, without)
            chosen[name] = (low, high)
    if more or not number_of.isdecimal() or not 0 < int(number_of) <= MOST:
        raise InputError(OPTION, text, expected)
    return int(number_of), seed, chosen


def _grid(text: str, rest: str) -> Pose:
    axes = {"azimuth": np.zeros(1), "tilt": np.zeros(1)}
    for name, (low, high, steps) in _ranges(text, rest).items():
        if steps is None and low != high:
            raise InputError(OPTION, text, f"a number of steps, as in {name}={low:g}..{high:g}x8")
        # A full turn ends where it began: no pose twice.
        round_trip = name == "azimuth" and high - low == 360
        axes[name] = np.linspace(low, high, steps or 1, endpoint=not round_trip)
    if "z" not in axes:
        raise InputError(OPTION, text, "a grid with heights, as in grid:z=350..700x8")
    if math.prod(map(len, axes.values())) > MOST:
        raise InputError(OPTION, text, f"at most {MOST} poses")
    mesh = np.meshgrid(axes["z"], axes["azimuth"], axes["tilt"], indexing="ij")
    return _scaled(*(axis.ravel() for axis in mesh))


def _ranges(text: str, rest: str) -> dict[str, tuple[float, float, int | None]]:
    """Return low, high and number of steps of NAME=LOW[..HIGH[xSTEPS]] by name."""
    expected = "z, azimuth and tilt each at most once, as in z=350..700x8,azimuth=0..360x12,tilt=5"
    found: dict[str, tuple[float, float, int | None]] = {}
    for part in rest.split(","):
        name, equals, span = part.partition("=")
        span, x, steps = span.partition("x")
        ends = span.split("..")
        if name not in RANGES or name in found or not equals or len(ends) > 2:
            raise InputError(OPTION, text, expected)
        if x and (not steps.isdecimal() or not 0 < int(steps) <= MOST):
            raise InputError(OPTION, text, expected)
        low, high = (_float(text, end, expected) for end in (ends[0], ends[-1]))
        if low > high:
            raise InputError(OPTION, text, f"ranges from low to high, not {span}")
        found[name] = (low, high, int(steps) if x else None)
    return found


def _float(text: str, part: str, expected: str) -> float:
    try:
        return number(OPTION, float(part), expected)
    except ValueError:
        raise InputError(OPTION, text, expected) from None


def _scaled(z: Floats, azimuth: Floats, tilt: Floats) -> Pose:
    return Pose(z / 1000, np.radians(azimuth), np.radians(tilt))


def _file(path: Path) -> Pose:
    import duckdb

    from harness.history.duck import connect, quoted, reason

    if not path.is_file() or not path.stat().st_size:  # a pipe or a device might never end
        why = "no regular file, or empty" if path.exists() else "No such file or directory"
        raise InputError(OPTION, str(path), f"a readable file of poses ({why})")
    name = quoted(escape(str(path)))
    source = f"read_parquet({name})"
    if path.suffix.lower() == ".csv":
        source = f"read_csv({name}, delim = ',', header = true, all_varchar = true)"
    try:
        with connect() as base:
            found = base.sql(f"FROM {source}").columns
            columns = next((c for c in _COLUMNS if set(c) == set(found)), None)
            if columns is None:
                expected = " or ".join(", ".join(c) for c in _COLUMNS)
                raise InputError(f"{OPTION} {path}", found, expected)
            # First as they are: DuckDB would read them as numbers, and refuse what is none.
            base.execute(f"CREATE TABLE given AS SELECT {', '.join(columns)} FROM {source}")
            asked = ", ".join(f"TRY_CAST({c} AS DOUBLE) AS {c}" for c in columns)
            values = base.execute(f"SELECT {asked} FROM given").fetchnumpy()
            arrays = [np.ma.filled(values[name], np.nan) for name in columns]
            for name, value in zip(columns, arrays, strict=True):
                bad = np.flatnonzero(~np.isfinite(value))
                if bad.size:
                    asked = f"SELECT {name} FROM given LIMIT 1 OFFSET {bad[0]}"
                    ((word,),) = base.execute(asked).fetchall()
                    where = f"{OPTION} {path}, {name}, row {bad[0] + 1}"
                    raise InputError(where, word, "a finite number")
    except duckdb.Error as error:
        why = reason(error)
        raise InputError(OPTION, str(path), f"a readable file of poses ({why})") from None
    if not len(arrays[0]):
        raise InputError(OPTION, str(path), "a file of at least one pose")
    return _scaled(*arrays) if columns == _COLUMNS[0] else Pose(*arrays)
