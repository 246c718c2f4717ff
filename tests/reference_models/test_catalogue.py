"""Models by name: what is asked for is what is made, and what cannot be had says why."""

import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, InputError, Mechanism, Pose, Substructure
from analytic.model import Info, Model
from reference_models import Named, UnavailableError, catalogue, names, parse, reference

ANALYTIC = {"euler-bernoulli", "rayleigh", "timoshenko", "multipliers", "condensed"}
LABELS = [
    "euler-bernoulli@3",
    "timoshenko@exact[shear=0.3]",
    "timoshenko@exact[shear=6/7]",
    "timoshenko@5[shear=cowper]",
    "condensed@exact",
    "multipliers@3[beam=rayleigh]",
    "exudyn-beam@12+24[shear=0.9]",
    "exudyn-cable@8",
    "mujoco-chain@12+24[beam=rayleigh]",
]


def test_all_are_there() -> None:
    simulators = {"exudyn-cable", "exudyn-beam", "exudyn-ffrf", "mujoco-cable", "mujoco-chain",
                  "calculix-solid", "ngsolve-solid", "ngsolve-averaged", "solid-limb"}  # fmt: skip
    assert ANALYTIC | simulators <= set(names())
    assert all(isinstance(info, Info) for _, info in catalogue())


@pytest.mark.parametrize("label", LABELS)
def test_a_label_is_read_back(label: str) -> None:
    model = parse(label, "models")
    assert model.label == label
    assert parse(model.label, "models") == model
    assert isinstance(model, Model)
    assert pickle.loads(pickle.dumps(model)) == model
    assert len({model, parse(label, "models")}) == 1


@pytest.mark.parametrize("name", names())
def test_a_bare_name_is_the_usual_model(name: str) -> None:
    model = parse(name, "models")
    if name in ANALYTIC:
        assert model.elements == 3
    else:
        assert model.elements == (model.info().refinements or 4)
    assert parse(model.label, "models") == model


def test_two_that_differ_in_anything_are_two(robot: Mechanism, case2: Pose) -> None:
    one, other = parse("timoshenko@exact", "m"), parse("timoshenko@exact[shear=0.3]", "m")
    assert one != other
    for model, exact in (
        (one, Continuum("timoshenko")),
        (other, Continuum("timoshenko", 0.3)),
        (reference("euler-bernoulli", 3), Substructure(3)),
    ):
        mine, theirs = (m.modes(robot, case2).frequencies for m in (model, exact))
        np.testing.assert_array_equal(mine, theirs)


def test_settings_go_to_the_models_that_have_them() -> None:
    assert parse("timoshenko", "m", shear=0.3).settings == (("shear", 0.3),)
    assert parse("exudyn-cable", "m", shear=0.3).settings == ()
    assert parse("timoshenko@3[shear=0.5]", "m", shear=0.3).settings == (("shear", 0.5),)


@pytest.mark.parametrize("name", sorted(set(names()) - ANALYTIC))
def test_the_limit_is_an_exact_model(name: str) -> None:
    model = Named(name, 8)
    limit, info = model.limit(), model.info()
    assert (limit is None) == (not info.limit)
    if limit is not None:
        assert limit.elements is None
        assert limit.info().theory == info.theory
    assert list(info.ladder) == sorted(info.ladder)
    if info.relaxed:
        assert info.relaxed in names() and info.assumption


def test_the_limit_keeps_the_shear_coefficient() -> None:
    beam = Named("exudyn-beam", 12, (("shear", 0.3),))
    assert beam.limit() == Named("timoshenko", None, (("shear", 0.3),))
    assert Named("mujoco-chain", 12, (("beam", "rayleigh"),)).limit() == Named("rayleigh", None)


def test_models_of_equal_theory_say_so_in_equal_words() -> None:
    solids = ("calculix-solid", "ngsolve-solid", "exudyn-ffrf", "solid-limb")
    theories = {info.theory for name, info in catalogue() if name in solids}
    assert theories == {"3-D elasticity, rigid end faces"}
    for label in ("exudyn-beam@8", "exudyn-beam@8[shear=0.9]", "mujoco-chain@8[beam=rayleigh]"):
        model = parse(label, "models")
        limit = model.limit()
        assert limit is not None and limit.info().theory == model.info().theory


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: parse("exudyn-cabel", "models"), "did you mean exudyn-cable?"),
        (lambda: parse("exudyn-cable@", "models"), "models"),
        (lambda: parse("exudyn-cable@0", "models"), "NAME@8+16 to extrapolate"),
        (lambda: parse("exudyn-cable@16+8", "models"), "NAME@8+16 to extrapolate"),
        (lambda: parse("exudyn-cable@exact", "models"), "NAME@8+16 to extrapolate"),
        (lambda: parse("timoshenko@3+6", "models"), "NAME@3 or NAME@exact"),
        (lambda: parse("timoshenko@3[colour=red]", "models"), "settings of timoshenko"),
        (lambda: parse("timoshenko@3[shear=red]", "models"), "shear"),
        (lambda: parse("multipliers@exact", "models"), "multipliers"),
        (lambda: reference("nothing"), "one of"),
        (lambda: reference("exudyn-cable", 8, colour="red"), "settings"),
        (lambda: reference("exudyn-cable", None), "elements"),
        (lambda: reference("exudyn-cable", 2.5), "elements"),
        (lambda: reference("exudyn-cable", (16, 8)), "the smaller first"),
    ],
)
def test_what_is_no_model_is_refused_in_a_sentence(call: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


PLUGIN = """
from analytic.model import Info
class Good:
    def __init__(self, elements=2): self.elements = elements
    @staticmethod
    def info(): return Info("theirs", "theirs", "1", 2)
class NoElements:
    @staticmethod
    def info(): return Info("theirs", "theirs", "1", 2)
class Raises(Good):
    @staticmethod
    def info(): raise KeyError("who knows")
class Exits(Good):
    @staticmethod
    def info(): raise SystemExit(3)
class Other(Good):
    @staticmethod
    def info(): return "a theory"
"""
FAULTS = {
    "no-elements": "takes no elements",
    "raises": "info() raises KeyError",
    "exits": "info() raises SystemExit",
    "other": "gives str, not Info",
    "unimportable": "cannot be imported (ModuleNotFoundError",
    "no-class": "cannot be imported (AttributeError",
}


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install somebody's package of models, all but one of which are no models."""
    (tmp_path / "their_models.py").write_text(PLUGIN)
    meta = tmp_path / "their_models-1.dist-info"
    meta.mkdir()
    (meta / "METADATA").write_text("Metadata-Version: 2.1\nName: their-models\nVersion: 1\n")
    points = {
        "good": "their_models:Good",
        "no-elements": "their_models:NoElements",
        "raises": "their_models:Raises",
        "exits": "their_models:Exits",
        "other": "their_models:Other",
        "unimportable": "no_such_module:Model",
        "no-class": "their_models:Missing",
    }
    lines = [f"{name} = {where}" for name, where in points.items()]
    (meta / "entry_points.txt").write_text("\n".join(["[rps_bench.reference_models]", *lines, ""]))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "their_models", raising=False)


@pytest.mark.usefixtures("plugin")
def test_plug_ins_that_are_broken_say_how_and_break_nothing_else() -> None:
    infos = dict(catalogue())
    assert infos["good"].theory == "theirs" and not infos["good"].missing
    assert reference("good").elements == 2
    for name, why in FAULTS.items():
        assert why in infos[name].missing
        assert "\n" not in infos[name].missing
    assert infos["euler-bernoulli"].missing == ""
    for name in ("no-elements", "raises", "exits", "other", "unimportable", "no-class"):
        with pytest.raises(UnavailableError, match="cannot run here"):
            Named(name, 8).build()
        with pytest.raises(UnavailableError, match="cannot run here"):
            reference(name, 8)
        with pytest.raises(UnavailableError, match="cannot run here"):
            reference(name)
        # A name is a name: that it cannot run is said where it is to run.
        assert parse(f"{name}@8", "models") == Named(name, 8)
