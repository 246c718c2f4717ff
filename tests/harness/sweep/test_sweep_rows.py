"""`rps-bench sweep`: rows, what is computed again, failures, and journals that are damaged."""

import pickle
import re
import sqlite3
import subprocess
import sys
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd
import pytest

from analytic import Continuum, Mechanism, Modes, Pose, Substructure
from analytic.model import Info
from harness.history.duck import connect
from harness.history.provenance import provenance
from harness.history.store import open_history
from harness.output import OutputError
from harness.rows import mechanism_hash
from harness.sweep import jobs as jobs_module
from harness.sweep import pose_set, solve
from harness.sweep import rows as rows_module
from harness.sweep.jobs import BATCH
from reference_models import Named


def read(file: Path) -> pd.DataFrame:
    with connect() as base:
        return base.execute(f"FROM '{file}'").df()


def test_rows_hold_what_the_models_say(
    assert_complete: Callable[[Path, int, int], pd.DataFrame],
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    robot: Mechanism,
) -> None:
    """A row a pose, model and mode, in order, with the frequencies of the one-pose models."""
    models = "timoshenko@exact,euler-bernoulli@3"
    given = ("--poses", "random:40:2", "--models", models, "--against", "timoshenko@exact")
    answer = rps_bench("sweep", *given, "--modes", "2-4", "--output", str(tmp_path))
    assert answer.status == 0, answer.err
    rows = assert_complete(tmp_path, 2 * 40, 3)
    poses = pose_set("random:40:2", robot)
    assert rows["pose"].to_list() == 2 * [i for i in range(1, 41) for _ in range(3)]
    assert rows["mode"].to_list() == 80 * [2, 3, 4]
    np.testing.assert_array_equal(rows["tilt_rad"].to_numpy()[: 3 * 40 : 3], poses.tilt)
    found = rows["frequency_hz"].to_numpy().reshape(2, 40, 3)
    models_alone = (Continuum("timoshenko"), Substructure(3))
    for k, model in enumerate(models_alone):
        for i in (0, 17, 39):
            alone = model.modes(robot, poses[i], 4).frequencies[1:]
            np.testing.assert_allclose(found[k, i], alone, rtol=1e-9)
    shown = answer.out.split()
    assert "Frequencies of the first 3 of 40 poses" in answer.out
    for frequency in found[:, :3].ravel():
        assert f"{frequency:.3f}" in shown

    errors = read(tmp_path / "error-map.parquet")
    expected = 100 * (found[1] / found[0] - 1)
    np.testing.assert_array_equal(errors["error_percent"].to_numpy(), expected.ravel())
    table = pd.read_csv(tmp_path / "errors.csv")
    for column, values in (
        ("Largest (%)", np.abs(expected).max(axis=0)),
        ("rms (%)", np.sqrt((expected**2).mean(axis=0))),
        ("Mean (%)", expected.mean(axis=0)),
    ):
        np.testing.assert_allclose(table[column].to_numpy(), values, atol=1e-10)


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_a_sweep_is_in_the_history_once(
    rps_bench: Callable[..., Any], tmp_path: Path, robot: Mechanism, form: str
) -> None:
    """All its rows with what a row of the history holds; a run that computed nothing adds none."""
    out, history = tmp_path / "out", tmp_path / "history"
    given = ("sweep", "--models", "euler-bernoulli@3,timoshenko@exact", "--shear", "0.9")
    given += ("--modes", "2-3", "--format", form, "--output", str(out), "--history", str(history))
    for poses in ("random:20:1", "random:20:1", "random:30:1"):
        answer = rps_bench(*given, "--poses", poses)
        assert answer.status == 0, answer.err
    past = open_history(history)
    runs = past.query("SELECT run, command, count(*) AS n FROM rows GROUP BY ALL ORDER BY run")
    runs = runs.rows()
    assert [row["n"] for row in runs] == [2 * 20 * 2, 2 * 30 * 2]
    said = set(runs[0]["command"].split(" --"))
    assert said == {
        "rps-bench sweep", "poses random:20:1", "models euler-bernoulli@3,timoshenko@exact",
        "modes 2-3", "shear 0.9", f"format {form}",
    }  # fmt: skip
    asked = "SELECT * FROM rows WHERE run = ? ORDER BY model, z_m, mode"
    rows = past.query(asked, [runs[1]["run"]]).to_frame()
    assert set(rows["case"]) == {"sweep"}
    assert set(rows["mechanism"]) == {mechanism_hash(robot)}
    assert dict(zip(rows["model"], rows["settings"], strict=True)) == {
        "euler-bernoulli@3": '{"count": 3}',
        "timoshenko@exact[shear=0.9]": '{"count": 3, "shear": 0.9}',
    }
    assert (rows["solve_s"] > 0).all()
    poses = pose_set("random:30:1", robot)
    place = np.argsort(poses.z)
    np.testing.assert_array_equal(rows["tilt_rad"].to_numpy()[:60:2], poses.tilt[place])
    for model, part in (
        (Named("euler-bernoulli", 3), rows[:60]),
        (Named("timoshenko", None, (("shear", 0.9),)), rows[60:]),
    ):
        assert set(part["model"]) == {model.label}
        alone = model.modes(robot, poses[place[0]], 3).frequencies
        np.testing.assert_allclose(part["frequency_hz"][:2].to_numpy(), alone[1:], rtol=1e-9)


def test_a_sweep_is_one_call_from_python(tmp_path: Path, robot: Mechanism) -> None:
    """Solved and written; once more, nothing is solved and the rows are the same."""
    poses, found = pose_set("random:7:1", robot), []
    for _ in range(2):
        swept = solve(robot, poses, [Named("rayleigh", None)], tmp_path, 4, cores=1)
        assert swept.failures() == {}
        found.append((swept.solved, swept.file.read_bytes()))
    assert [number for number, _ in found] == [1, 0]
    assert found[0][1] == found[1][1]
    assert swept.to_frame()["mode"].to_list() == 7 * [1, 2, 3, 4]


@dataclass(frozen=True)
class Wrong:
    """A model whose numbers are wrong at every pose whose height says so."""

    what: str
    elements: None = None

    def info(self) -> Info:
        return replace(Named("rayleigh", None).info(), isolated=False)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        return Named("rayleigh", None).modes(mechanism, pose, count)

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Any:
        found = Named("rayleigh", None).frequencies(mechanism, poses, count)
        match self.what:
            case "nan" | "inf" | "-1":
                found[1, 2] = float(self.what)
            case "unsorted":
                found = found[:, ::-1]
            case "shape":
                found = found[:, :-1]
            case "complex":
                found = found + 0j
            case "text":
                return "a word"
        return found


@pytest.mark.parametrize(
    ("what", "why"),
    [
        ("nan", "its frequencies hold nan"),
        ("inf", "its frequencies hold inf"),
        ("-1", "it gave a frequency below zero, -1 Hz"),
        ("unsorted", "its frequencies do not ascend"),
        ("shape", "its frequencies have shape (5, 3) and type float64, not (5, 4) numbers"),
        ("complex", "its frequencies have shape (5, 4) and type complex128, not (5, 4) numbers"),
        ("text", "its frequencies have shape () and type <U6, not (5, 4) numbers"),
    ],
)
def test_numbers_that_are_none_are_failures(
    tmp_path: Path, robot: Mechanism, what: str, why: str
) -> None:
    """And the other models' rows stand."""
    models = [Wrong(what), Named("rayleigh", None)]
    swept = solve(robot, pose_set("random:5:1", robot), models, tmp_path, 4, cores=1)
    assert list(swept.failures().values()) == [why]
    assert set(swept.to_frame()["model"]) == {"rayleigh@exact"}


@pytest.mark.parametrize("poison", ["nan", "shape", "foreign", "flipped"])
def test_a_poisoned_journal_is_solved_anew(tmp_path: Path, robot: Mechanism, poison: str) -> None:
    given = (robot, pose_set("random:5:1", robot), [Named("rayleigh", None)], tmp_path, 4)
    first = solve(*given, cores=1).file.read_bytes()
    base = sqlite3.connect(tmp_path / "journal.sqlite", isolation_level=None)
    ((content, checksum),) = base.execute("SELECT answer, checksum FROM jobs").fetchall()
    answer = pickle.loads(content)
    if poison == "nan":
        answer.frequencies[1, 2] = np.nan
    elif poison == "shape":
        answer = replace(answer, frequencies=answer.frequencies[:, :3])
    elif poison == "foreign":
        answer = {"frequencies": [1.0]}
    spoilt = pickle.dumps(answer, protocol=5)
    sound = checksum + 1 if poison == "flipped" else zlib.crc32(spoilt)
    base.execute("UPDATE jobs SET answer = ?, checksum = ?", (spoilt, sound))
    base.close()
    swept = solve(*given, cores=1)
    assert swept.solved == 1
    assert swept.file.read_bytes() == first


@pytest.mark.slow
def test_the_same_again_computes_nothing_and_more_only_what_is_missing(
    assert_complete: Callable[[Path, int, int], pd.DataFrame],
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    log: Path,
    plugin: None,
) -> None:
    given = ("sweep", "--models", "trial@1", "--output", str(tmp_path / "out"))
    assert rps_bench(*given, "--poses", "random:20:1").status == 0
    first = (tmp_path / "out" / "frequencies.parquet").read_bytes()
    dry = rps_bench(*given, "--poses", "random:25:1", "--dry-run")
    assert re.search(r"trial@1\s+25\s+20\s+5\s", dry.out)
    log.unlink()
    assert rps_bench(*given, "--poses", "random:20:1").status == 0
    assert not log.exists()
    assert (tmp_path / "out" / "frequencies.parquet").read_bytes() == first
    assert rps_bench(*given, "--poses", "random:25:1").status == 0
    assert log.read_text().count("\n") == 5
    assert_complete(tmp_path / "out", 25, 6)


@pytest.mark.slow
def test_failures_are_listed_by_reason_with_status_1(
    rps_bench: Callable[..., Any], tmp_path: Path, plugin: None
) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text("z_mm,azimuth_deg,tilt_deg\n400,0,1\n410,0,-1\n420,0,1\n430,0,-1\n")
    given = ("--poses", str(poses), "--models", "trial@1,trial@5", "--output", str(tmp_path))
    answer = rps_bench("sweep", *given, "--against", "euler-bernoulli@exact", "--modes", "1-2")
    assert answer.status == 1
    table = pd.read_csv(tmp_path / "failures.csv")
    assert table.to_numpy().tolist() == [["trial@5", 2, "2, 4", "trial: will not"]]
    assert "trial: will not" in answer.out
    rows = read(tmp_path / "frequencies.parquet")
    assert set(rows[rows["model"] == "trial@5"]["pose"]) == {1, 3}
    assert [*rows["model"].value_counts().sort_index()] == [8, 8, 4]


def test_a_dry_run_leaves_nothing_behind(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    output = tmp_path / "out"
    given = ("--poses", f"random:{BATCH + 1}", "--models", "rayleigh@2", "--dry-run")
    answer = rps_bench("sweep", *given, "--output", str(output))
    assert answer.status == 0
    assert re.search(r"rayleigh@2\s+2\s+0\s+2\s+[\d.]+\s+[\d.e-]+ s", answer.out)
    assert not output.exists()


def test_a_damaged_journal_is_one_sentence(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    given = ("sweep", "--poses", "random:9", "--models", "rayleigh@1", "--output", str(tmp_path))
    assert rps_bench(*given).status == 0
    journal = tmp_path / "journal.sqlite"
    whole = journal.read_bytes()
    damages = (b"not a journal" * 1000, whole[:5000])
    for content in damages:
        journal.write_bytes(content)
        answer = rps_bench(*given)
        assert answer.status == 2
        assert "journal.sqlite is damaged" in answer.err
        assert len(answer.err.splitlines()) == 1
        assert journal.read_bytes() == content


@pytest.mark.slow
def test_memory_does_not_grow_with_the_poses(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
) -> None:
    """The poses themselves are held, 24 bytes each, and copied as they are drawn; rows are not."""
    peak = (  # not ru_maxrss: a new program inherits that of the process that started it
        "import atexit; atexit.register(lambda: print('peak', "
        "open('/proc/self/status').read().split('VmHWM:')[1].split()[0]))"
    )
    used = []
    for count in (240_000, 340_000):  # with fewer DuckDB's own 32 MB fill
        output = str(tmp_path / str(count))
        given = ("--poses", f"random:{count}", "--models", "euler-bernoulli@exact")
        status, out, err = ended(started(*given, "--output", output, before=peak))
        assert status == 0, err
        used.append(1024 * int(out.split()[-1]))
    rows = 6 * 100_000 * (8 * 5 + 8)  # what the additional rows alone would take
    assert used[1] - used[0] < 12e6 < rows


def test_a_history_that_was_not_written_is_written_by_the_next_run(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the last job the history's disk is full: once there is room it has all rows, once."""
    given = ("sweep", "--models", "rayleigh@2", "--poses", "random:9:1", "--modes", "1-2")
    given += ("--output", str(tmp_path / "out"), "--history", str(tmp_path / "past"))

    def full(*_: Any) -> None:
        raise OutputError("history: cannot write there (No space left on device)")

    with monkeypatch.context() as patched:
        patched.setattr(rows_module, "append_table", full)
        assert rps_bench(*given).status == 2
    for _ in range(2):
        assert rps_bench(*given).status == 0
        found = open_history(tmp_path / "past").query("SELECT run, mode FROM rows").rows()
        assert len(found) == 9 * 2 and len({row["run"] for row in found}) == 1


def test_rows_of_the_history_say_what_made_them(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not what resumed the sweep: half of the blocks are of another machine."""
    given = ("sweep", "--models", "rayleigh@2", "--modes", "1", "--output", str(tmp_path / "out"))
    here = provenance()
    with monkeypatch.context() as patched:
        patched.setattr(jobs_module, "provenance", lambda: here | {"commit": "old", "machine": "b"})
        assert rps_bench(*given, "--poses", f"random:{BATCH}:1").status == 0
    more = ("--poses", f"random:{BATCH + 7}:1", "--history", str(tmp_path / "past"))
    assert rps_bench(*given, *more).status == 0
    asked = "SELECT machine, any_value(commit) AS c, count(*) AS n FROM rows GROUP BY 1 ORDER BY n"
    new, old = open_history(tmp_path / "past").query(asked).rows()
    assert (old["machine"], old["c"], old["n"]) == ("b", "old", BATCH)
    assert (new["machine"], new["c"], new["n"]) == (here["machine"], here["commit"], 7)


def test_files_of_an_earlier_sweep_do_not_stay(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    """Without --against, in another form: what is there is of this sweep, or is not a sweep's."""
    given = ("sweep", "--models", "rayleigh@2", "--output", str(tmp_path))
    (tmp_path / "notes.csv").write_text("mine")
    first = rps_bench(*given, "--poses", "random:9:1", "--against", "euler-bernoulli@2")
    assert first.status == 0 and (tmp_path / "error-map.parquet").exists()
    assert rps_bench(*given, "--poses", "random:5:2", "--format", "csv").status == 0
    left = {path.name for path in tmp_path.iterdir()} - {"journal.sqlite"}
    tables = {f"{stem}.{end}" for stem in ("timing", "failures") for end in ("csv", "md", "tex")}
    assert left == {"notes.csv", "frequencies.csv", *tables}


def test_a_patched_model_is_solved_anew(
    tmp_path: Path, robot: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The key of a job holds the source of the model, and of what checks its answers."""
    file = tmp_path / "patched.py"
    file.write_text("")
    module = ModuleType("patched")
    module.__file__ = str(file)
    monkeypatch.setitem(sys.modules, "patched", module)
    monkeypatch.setattr(Wrong, "__module__", "patched")
    keys = set()
    for text in ("", "factor = 1.05", "factor = 1.05"):
        file.write_text(text)
        jobs_module._programs.clear()
        poses, model = pose_set("random:5:1", robot), Wrong("nothing")
        sweep = jobs_module.Sweep(robot, poses, [model], [4], None, None, None)
        (job,) = sweep.jobs(model)
        keys.add(job.key)
    jobs_module._programs.clear()
    assert len(keys) == 2
