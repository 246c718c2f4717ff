"""A study pairs by shape beyond the modes that are shown."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from analytic import Mechanism, Modes, Pose, Substructure
from harness.cases import PRESETS
from harness.compare import reference_table, table_one
from harness.models import Spec
from harness.run import rows, run


@dataclass(frozen=True)
class Crossed:
    """A reference whose third and fourth modes changed places."""

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        modes = Substructure(3).modes(mechanism, pose, count)
        order = [0, 1, 3, 2, *range(4, count)]
        return replace(modes, platform=modes.platform[order], limbs=modes.limbs[order])


@pytest.mark.parametrize("shown", [[1, 2, 3, 4], [1, 2, 3]])
def test_a_crossing_is_paired_and_said(monkeypatch: pytest.MonkeyPatch, shown: list[int]) -> None:
    """Also where the partner lies beyond the modes shown."""
    theory, reference = Spec("euler-bernoulli", 3), Spec("exudyn-beam", 7)
    build = Spec.build
    monkeypatch.setattr(Spec, "build", lambda s: Crossed() if s == reference else build(s))
    case = PRESETS["case2"]
    study = run([case], [theory, reference], max(shown))
    table = table_one(study, [theory], [reference], shown)
    error = next(row for row in table.rows if row[1] == "Error (%)")
    f = Substructure(3).modes(case.mechanism, case.pose).frequencies
    assert float(str(error[4])) == pytest.approx(100 * (f[2] / f[3] - 1), abs=0.01)
    said = "case2: mode 3 of euler-bernoulli@3 looks like mode 4 of exudyn-beam@7"
    assert any(note.startswith(said) and "paired by shape" in note for note in table.notes)
    marked = reference_table(study, theory, [reference], shown)
    assert [str(row[3]).endswith("*") for row in marked.rows] == [i in (3, 4) for i in shown]


def test_rows_say_where_they_come_from() -> None:
    study = run([PRESETS["case1"]], [Spec("rayleigh", 2), Spec("exudyn-cable", 2)], 3)
    found = rows(study)
    assert [row["mode"] for row in found] == [1, 2, 3] * 2
    assert {row["model"] for row in found} == {"rayleigh@2", "exudyn-cable@2"}
    for row in found:
        assert row["theory"] and row["version"] and row["dofs"] > 0
        assert row["mechanism"] == found[0]["mechanism"]
        assert np.isfinite([row["frequency_hz"], row["build_s"], row["solve_s"]]).all()


def test_mechanisms_are_told_apart() -> None:
    names = ("case1", "case1-printed-inertia", "case1-z-r1-fitted")
    study = run([PRESETS[name] for name in names], [Spec("rayleigh", 1)], 1)
    assert len({row["mechanism"] for row in rows(study)}) == 3


def test_rows_say_their_settings_and_assurance() -> None:
    """Assurance is with the first model that has an answer; kappa is said where it matters."""
    specs = [
        Spec("exudyn-beam", 1, 0.9),
        Spec("euler-bernoulli", 3),
        Spec("timoshenko", None, 0.9),
        Spec("exudyn-beam", 4, 0.9),
    ]
    study = run([PRESETS["case2"]], specs, 6)
    failed = replace(study, modes={k: m for k, m in study.modes.items() if k[1] != specs[0].label})
    by_model: dict[str, list[dict[str, Any]]] = {}
    for row in rows(failed):
        by_model.setdefault(row["model"], []).append(row)
    first, exact, beam = by_model.values()
    assert {row["assurance"] for row in first} == {None}
    for found, spec in ((exact, specs[2]), (beam, specs[3])):
        pairing = study.pairing(PRESETS["case2"], spec, specs[1])
        assert pairing is not None
        assert [row["assurance"] for row in found] == pairing.assurance.tolist()
        assert min(row["assurance"] for row in found) > 0.9
    assert {row["settings"] for row in first} == {'{"count": 8}'}
    for found in (exact, beam):
        assert {row["settings"] for row in found} == {'{"count": 8, "shear": 0.9}'}
