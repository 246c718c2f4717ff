"""Long runs and many runs: memory that grows with neither."""

import subprocess
import sys
from pathlib import Path

import pytest

PEAK = """
import re
def peak():  # not ru_maxrss: a new program inherits that of the process that started it
    status = open("/proc/self/status").read()
    print(int(re.search(r"VmHWM:\\s+(\\d+)", status)[1]) // 1024)
"""
LONG = """
import sys
from pathlib import Path
from harness.history.duck import connect
from harness.history.store import append_table, open_history
folder, rows = Path(sys.argv[1]), int(sys.argv[2])
base = connect()
base.execute(f"CREATE VIEW t AS SELECT i AS mode, sqrt(i) AS frequency_hz FROM range({rows}) t(i)")
append_table(folder, base, "t", "sweep " + 300 * "x")
past = open_history(folder)
asked = "SELECT command, count(*) AS n, sum(frequency_hz) FROM rows GROUP BY ALL"
assert past.query(asked).rows()[0]["n"] == rows
assert past.query("SELECT * FROM rows").write(folder.parent / "rows.parquet") == rows
peak()
"""
MANY = """
import io, shutil, sys, time
from contextlib import redirect_stdout
from pathlib import Path
from harness.cli.main import main
from harness.history.duck import connect
from harness.history.store import checksum
from harness.history.store import append_table, open_history
folder, runs, rows = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
with connect() as base:
    base.execute(
        "CREATE VIEW t AS SELECT i % 6 AS mode, sqrt(i) AS frequency_hz, 'a' AS model, "
        f"i / 7 AS z_m FROM range({rows}) t(i)"
    )
    first = append_table(folder, base, "t", "check " + 300 * "x")
for k in range(runs - 1):
    shutil.copy(first, folder / first.name.replace(first.name[:15], f"20200101-{k:06}"))
past = open_history(folder)
assert not past.skipped
asked = "SELECT mode, count(*) AS n, avg(frequency_hz) FROM rows GROUP BY ALL"
assert sum(row["n"] for row in past.query(asked).rows()) == runs * rows
assert len(past.query("SELECT * FROM rows").rows(200)) == 200
for question in ((), ("--rows", "--mode", "1"), ("--run", "latest"), ("--model", "a", "--rows"),
                 ("--export", str(folder.parent / "all.csv"))):
    sys.argv = ["rps-bench", "history", "--history", str(folder), *question]
    began = time.perf_counter()
    try:
        with redirect_stdout(io.StringIO()):
            main()
    except SystemExit as ended:
        assert not ended.code, question
    print(*question, f"{time.perf_counter() - began:.2f} s", file=sys.stderr)
peak()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "numbers"),
    [(LONG, (4_000_000,)), (MANY, (365, 15_000)), (MANY, (2_000, 100))],
    ids=["one long run", "a year of checks", "2,000 small runs"],
)
def test_memory_is_flat(tmp_path: Path, script: str, numbers: tuple[int, ...]) -> None:
    """In memory, the texts alone of the rows of the first two are more than 1.2 GB."""
    ended = subprocess.run(
        [sys.executable, "-c", PEAK + script, str(tmp_path / "past"), *map(str, numbers)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert int(ended.stdout) < 500, "MiB"
