"""Answers are kept by the case and the model themselves; a model's failure is its own."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import Continuum, InputError, Multipliers, Pose, Substructure
from harness import bench as spine
from harness.bench import Bench, Study, run
from harness.cases import PRESETS
from harness.studies.table import TableOne
from reference_models import Named

CASE1, CASE2 = PRESETS["case1"], PRESETS["case2"]


def test_two_models_that_differ_in_a_setting_are_two() -> None:
    stiff, soft = Named("timoshenko", None), Named("timoshenko", None, (("shear", 0.3),))
    study = run([CASE1], [stiff, soft])
    assert study.models == (stiff, soft)
    for model, shear in ((stiff, "cowper"), (soft, 0.3)):
        exact = Continuum("timoshenko", shear).modes(CASE1.mechanism, CASE1.pose, 8)
        found = study.get(CASE1, model)
        assert found is not None
        np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=1e-11)
    assert set(study.to_frame()["model"]) == {stiff.label, soft.label}


def test_two_cases_of_one_name_do_not_mix() -> None:
    low, high = (replace(CASE1, pose=Pose(z)) for z in (0.4, 0.6))
    model = Named("euler-bernoulli", 3)
    study = run([low, high], model)
    for case in (low, high):
        found = study.get(case, model)
        assert found is not None
        right = Substructure(3).modes(case.mechanism, case.pose, 8).frequencies
        np.testing.assert_allclose(found.frequencies, right, rtol=1e-12)
    assert study.answers[low, model].frequencies[0] > study.answers[high, model].frequencies[0]


def test_models_need_no_catalogue() -> None:
    """Any object of the protocol is a model: without a label it is called by its parameters."""
    models = [Substructure(3), Multipliers(3)]
    study = run(CASE2, models)
    assert not study.failures
    one, other = (study.answers[CASE2, model].frequencies for model in models)
    np.testing.assert_allclose(one, other, rtol=1e-9)
    result = TableOne(study, (models[0],), (models[1],), (1, 2))
    assert "Multipliers(elements=3" in result.tables()[""].markdown()


def test_an_answer_is_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    with Bench() as bench:
        first = bench.run([CASE1], [Named("euler-bernoulli", 2), Named("euler-bernoulli", None)])

        def never(*_: object) -> object:
            raise AssertionError("it was solved before")

        monkeypatch.setattr(spine, "attempt", never)
        again = bench.run([CASE1], [Named("euler-bernoulli", 2), Named("euler-bernoulli", None)])
    assert first == again


def test_extrapolated_meshes_are_the_two_meshes() -> None:
    """f = f_fine + (f_fine - f_coarse) / (r^p - 1), and the step is the uncertainty."""
    with Bench() as bench:
        names = [Named("exudyn-cable", n) for n in (4, 8, (4, 8))]
        study = bench.run([CASE2], names)
    coarse, fine, limit = (study.answers[CASE2, name] for name in names)
    step = (fine.frequencies - coarse.frequencies)[:6] / (2**4 - 1)
    np.testing.assert_allclose(limit.frequencies[:6], fine.frequencies[:6] + step, rtol=1e-9)
    assert limit.uncertainty is not None
    np.testing.assert_allclose(limit.uncertainty[:6], np.abs(step), rtol=1e-3)


def test_a_pose_out_of_reach_is_refused_before_anything_is_solved() -> None:
    far = replace(CASE1, pose=Pose(float("0.0")), mechanism=CASE1.mechanism.regular(
        0.2, 0.2, CASE1.mechanism.limbs[0].rod, CASE1.mechanism.platform))  # fmt: skip
    with pytest.raises(InputError, match="pose"):
        run([far], Named("euler-bernoulli", 3))


def test_rows_say_where_they_come_from() -> None:
    models = [Named("rayleigh", 2), Named("exudyn-cable", 2)]
    rows = run([CASE1], models, 3).rows()
    assert [row["mode"] for row in rows] == [1, 2, 3] * 2
    assert {row["model"] for row in rows} == {"rayleigh@2", "exudyn-cable@2"}
    for row in rows:
        assert row["theory"] and row["version"] and row["dofs"] > 0
        assert row["mechanism"] == rows[0]["mechanism"]
        assert np.isfinite([row["frequency_hz"], row["build_s"], row["solve_s"]]).all()
    assert [row["assurance"] is None for row in rows] == [True] * 3 + [False] * 3
    assert min(row["assurance"] for row in rows[3:]) > 0.9


def test_mechanisms_are_told_apart() -> None:
    names = ("case1", "case1-printed-inertia", "case1-z-r1-fitted")
    rows = run([PRESETS[name] for name in names], Named("rayleigh", 1), 1).rows()
    assert len({row["mechanism"] for row in rows}) == 3


def crossed(study: Study, case: object, model: Named) -> Study:
    """Return `study` with the shapes of a model's third and fourth modes exchanged."""
    modes = study.answers[case, model]  # type: ignore[index]
    order = [0, 1, 3, 2, *range(4, len(modes.frequencies))]
    turned = replace(modes, platform=modes.platform[order], limbs=modes.limbs[order])
    return replace(study, answers={**study.answers, (case, model): turned})  # type: ignore[dict-item]


@pytest.mark.parametrize("shown", [(1, 2, 3, 4), (1, 2, 3)])
def test_a_crossing_is_paired_and_said(shown: tuple[int, ...]) -> None:
    """Also where the partner lies beyond the modes shown."""
    theory, reference = Named("euler-bernoulli", 3), Named("rayleigh", 3)
    study = crossed(run([CASE2], [theory, reference], max(shown)), CASE2, reference)
    result = TableOne(study, (theory,), (reference,), shown)
    table = result.tables()[""]
    error = next(row for row in table.rows if row[1] == "Error (%)")
    f, against = (study.answers[CASE2, model].frequencies for model in (theory, reference))
    assert float(str(error[4])) == pytest.approx(100 * (f[2] / against[3] - 1), abs=0.01)
    said = "case2: mode 3 of euler-bernoulli@3 looks like mode 4 of rayleigh@3"
    assert any(note.startswith(said) and "paired by shape" in note for note in table.notes)
    marked = result.tables()["-references"]
    assert [str(row[3]).endswith("*") for row in marked.rows] == [i in (3, 4) for i in shown]
