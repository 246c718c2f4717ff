"""Sets of poses as people write them, in degrees and millimetres, or as files.

pose:490,10,-12                 one pose: z [mm], azimuth, tilt [deg]; 0.49m,0.17rad,-0.2rad too
pose:x=60,y=110,z=640,yaw=5     the same by name: z, azimuth, tilt, torsion, x, y; or yaw, pitch and
                                roll for the angles
random:1000:7                   1000 poses by seed 7; z 350-700 mm, any azimuth, tilt to 20 deg
random:1000:z=400..500,tilt=5   the same in other ranges
grid:z=350..700x8,azimuth=0..360x12,tilt=0..20x5
workspace:1000:7                1000 poses by seed 7 in the regular workspace of the mechanism
FILE.csv, FILE.parquet          columns z_mm, azimuth_deg, tilt_deg, or z_m, azimuth_rad, tilt_rad;
                                x_mm, torsion_deg, yaw_deg and so on where they are stated

Where the limbs leave x and y to say, a set says both; what it does not name is then 0.
"""

import math
import re
from collections.abc import Mapping
from glob import escape
from pathlib import Path
from typing import Any

import numpy as np

from analytic import InputError, Mechanism, Pose, position
from analytic.errors import number
from analytic.placed import place
from analytic.regular_workspace import regular_workspace
from analytic.workspace import Limits, heights
from harness.history.duck import connect, quoted, reason
from harness.poses import COLUMNS, LENGTHS, NAMES, TURNS, columns, stated

OPTION = "poses"
FORMS = (
    "pose:Z,AZIMUTH,TILT, pose:NAME=VALUE,..., random:N[:SEED][:RANGES], grid:RANGES, "
    "workspace:N[:SEED], FILE.csv or FILE.parquet"
)
RANGES = {"z": (350.0, 700.0), "azimuth": (0.0, 360.0), "tilt": (0.0, 20.0)}  # mm, deg
MOST = 1_000_000_000
BLOCK = 10_000
"""Poses checked at a time, so that memory holds little more than the set."""
LAYERS = 41
"""Layers of the regular workspace; in between its radius is linear."""

PLAIN = ("z", "azimuth", "tilt")
"""What a pose is stated by where nothing else is named."""
ENOUGH = (PLAIN, ("x", "y"), ("z", *TURNS))
"""Of these columns a file has all of one row at least."""
_UNITS = {name: ("m", 1e-3) if name in LENGTHS else ("rad", math.pi / 180) for name in NAMES}


def pose_set(text: str, mechanism: Mechanism) -> Pose:
    """Return the poses that `text` names, each of which `mechanism` can take; arrays.

    Raises `InputError` for what cannot be read or reached.
    """
    kind, _, rest = text.partition(":")
    if kind == "pose":
        poses = _one(text, rest)
    elif kind == "random":
        poses = _random(*_drawn(text, rest))
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
        some = poses[start : start + BLOCK]
        position(mechanism, some)
        if not mechanism.simple:
            place(mechanism, some)
    return poses


def written(pose: Pose) -> str:
    """Return the text that `pose_set` reads back as this very pose, to the last bit."""
    values = {COLUMNS[column]: value for column, value in columns(pose).items()}
    own = {n: f"{float(v)!r}{_UNITS[n][0]}" for n, v in values.items() if v is not None}
    if pose.x is None and not pose.torsion:
        return f"pose:{','.join(own[name] for name in PLAIN)}"
    return f"pose:{','.join(f'{name}={value}' for name, value in own.items())}"


def _one(text: str, rest: str) -> Pose:
    expected = "pose:Z,AZIMUTH,TILT in mm and degrees, as in pose:490,10,-12, or x=60,y=110,z=640"
    if "=" not in rest and rest.count(",") == 2:
        rest = ",".join(map("=".join, zip(PLAIN, rest.split(","), strict=True)))
    values = {}
    for name, part in _named(text, rest, expected).items():
        unit, scale = _UNITS[name]
        plain = part.removesuffix(unit)
        value = _float(text, plain, expected) * (scale if plain == part else 1.0)
        values[name] = np.array([value])
    return stated(values)


def _random(count: int, seed: int, ranges: Mapping[str, tuple[float, float]]) -> Pose:
    low, high = np.array([*ranges.values()]).T
    # A pose's numbers are drawn together: a longer set begins with the shorter one.
    drawn = np.random.default_rng(seed).random((count, len(ranges)))
    drawn *= high - low
    drawn += low
    return _scaled(dict(zip(ranges, drawn.T, strict=True)))


def _drawn(
    text: str, rest: str, *, ranges: bool = True
) -> tuple[int, int, dict[str, tuple[float, float]]]:
    """Return how many poses, the seed and the ranges in N[:SEED][:RANGES]."""
    found = re.fullmatch(r"(\d+)(?::(\d+))?(?::([^:]*))?", rest)
    if not found or not 0 < int(found[1]) <= MOST or not (ranges or found[3] is None):
        form = f"{text.partition(':')[0]}:N[:SEED]{'[:RANGES]' if ranges else ''}"
        raise InputError(OPTION, text, f"{form} with N above 0")
    chosen = dict(RANGES)
    if found[3] is not None:
        named = _ranges(text, found[3])
        if not {*named} <= {*PLAIN, "torsion"}:
            chosen = {}
        for name, (low, high, steps) in named.items():
            if steps is not None:
                without = "ranges such as z=350..700, without a number of steps"
                raise InputError(OPTION, text, without)
            chosen[name] = (low, high)
    return int(found[1]), int(found[2] or 0), chosen


def _grid(text: str, rest: str) -> Pose:
    axes = {}
    for name, (low, high, steps) in _ranges(text, rest).items():
        if steps is None and low != high:
            raise InputError(OPTION, text, f"a number of steps, as in {name}={low:g}..{high:g}x8")
        # A full turn ends where it began: no pose twice.
        round_trip = name in ("azimuth", "torsion", "yaw") and high - low == 360
        axes[name] = np.linspace(low, high, steps or 1, endpoint=not round_trip)
    if "z" not in axes and not {"x", "y"} <= {*axes}:
        raise InputError(OPTION, text, "a grid with heights, as in grid:z=350..700x8")
    if math.prod(map(len, axes.values())) > MOST:
        raise InputError(OPTION, text, f"at most {MOST} poses")
    order = sorted(axes, key=NAMES.index)
    mesh = np.meshgrid(*(axes[name] for name in order), indexing="ij")
    return _scaled({name: axis.ravel() for name, axis in zip(order, mesh, strict=True)})


def _ranges(text: str, rest: str) -> dict[str, tuple[float, float, int | None]]:
    """Return low, high and number of steps of NAME=LOW[..HIGH[xSTEPS]] by name."""
    expected = f"{', '.join(NAMES)} each at most once, as in z=350..700x8,azimuth=0..360x12,tilt=5"
    found: dict[str, tuple[float, float, int | None]] = {}
    for name, given in _named(text, rest, expected).items():
        span, x, steps = given.partition("x")
        first, dots, last = span.partition("..")
        if x and (not steps.isdecimal() or not 0 < int(steps) <= MOST):
            raise InputError(OPTION, text, expected)
        low, high = (_float(text, end, expected) for end in (first, last if dots else first))
        if low > high:
            raise InputError(OPTION, text, f"ranges from low to high, not {span}")
        found[name] = (low, high, int(steps) if x else None)
    return found


def _named(text: str, rest: str, expected: str) -> dict[str, str]:
    """Return what stands behind each NAME= of some of `NAMES`."""
    found: dict[str, str] = {}
    for part in rest.split(","):
        name, equals, value = part.partition("=")
        if name not in NAMES or name in found or not equals:
            raise InputError(OPTION, text, expected)
        found[name] = value
    return found


def _float(text: str, part: str, expected: str) -> float:
    try:
        return number(OPTION, float(part), expected)
    except ValueError:
        raise InputError(OPTION, text, expected) from None


def _scaled(values: Mapping[str, Any]) -> Pose:
    return stated({n: v / 1000 if n in LENGTHS else np.radians(v) for n, v in values.items()})


def _file(path: Path) -> Pose:
    if not path.is_file() or not path.stat().st_size:  # a pipe or a device might never end
        why = "no regular file, or empty" if path.exists() else "No such file or directory"
        raise InputError(OPTION, str(path), f"a readable file of poses ({why})")
    import duckdb

    name = quoted(escape(str(path)))
    source = f"read_parquet({name})"
    if path.suffix.lower() == ".csv":
        source = f"read_csv({name}, delim = ',', header = true, all_varchar = true)"
    where = f"{OPTION} {path}"
    edge, inside = (
        {f"{name}_{length if name in LENGTHS else angle}": name for name in NAMES}
        for length, angle in (("mm", "deg"), ("m", "rad"))
    )
    try:
        with connect() as base:
            found = base.sql(f"FROM {source}").columns
            names = inside if {*found} <= {*inside} else edge
            own = {names.get(column) for column in found}
            if None in own or not any(own.issuperset(some) for some in ENOUGH):
                expected = "z_mm, azimuth_deg, tilt_deg, or z_m, azimuth_rad, tilt_rad"
                raise InputError(where, found, f"{expected}; torsion, x, y, yaw, pitch, roll too")
            # First as they are: DuckDB would read them as numbers, and refuse what is none.
            base.execute(f"CREATE TABLE given AS FROM {source}")
            for column in sorted(found, key=[*names].index):
                value = f"TRY_CAST({column} AS DOUBLE)"
                bad = base.execute(
                    f"SELECT rowid + 1, {column} FROM given "
                    f"WHERE ifnull(NOT isfinite({value}), true) ORDER BY rowid LIMIT 1"
                ).fetchone()
                if bad is not None:
                    row, word = bad
                    raise InputError(f"{where}, {column}, row {row}", word, "a finite number")
            cast = "TRY_CAST(COLUMNS(*) AS DOUBLE)"
            arrays = base.execute(f"SELECT {cast} FROM given").fetchnumpy()
    except duckdb.Error as error:
        why = f"a readable file of poses ({reason(error)})"
        raise InputError(OPTION, str(path), why) from None
    values = {names[column]: array for column, array in arrays.items()}
    if not len(next(iter(values.values()))):
        raise InputError(OPTION, str(path), "a file of at least one pose")
    return _scaled(values) if names is edge else stated(values)
