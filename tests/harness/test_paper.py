"""A paper is a folder: what others printed is met, in every study, and what is wrong is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, InputError
from harness import study
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.paper import CHECKED, folder, names

WRONG = {
    ("thomson-beams", "held"): {11},
    ("nafems-fv-crosses", "fv1"): {2, 3, 6, 7},
    ("nafems-fv-crosses", "fv2"): {2, 3, 10, 11},
    ("code-aster-sdll", "sdll01"): {7, 12, 15, 19},
    ("code-aster-sdll", "sdll15"): {1, 2, 8},
    ("code-aster-sdll", "sdll15-beside"): {3, 7},
    ("stewart-simscape", "home"): {6},
}
"""Modes that are printed otherwise than they are, by paper and case: each is in its errata."""
DIGITS = 5e-8
"""Two programs with the same elements differ by so much, relative: more digits are rounding."""
MINE = """
[mechanisms.mine]
base_radius_mm = 300
platform_radius_mm = 200
platform_thickness_mm = 20
rod_diameter_mm = 60
young_GPa = 200
shear_GPa = 77
density_kg_m3 = 7820
[cases.low]
mechanism = "mine"
z_mm = 400
tilt_deg = 5
[cases.high]
mechanism = "mine"
z_mm = 500
"""
ABOUT = 'authors = "A. N. Other"\ntitle = "On rods"\nsource = "Letters"\nyear = 2020\n'
CLAIMS = """
[[claim]]
id = "ours"
section = "3"
quoted = "theory and this bench are the same"
how = "by the same theory"
check = "printed"
case = "low"
method = "Theory"
model = "euler-bernoulli@exact"
within_percent = {within}
[[claim]]
id = "fea"
section = "3"
quoted = "finite elements differ by less than 2 %"
how = "one row over the other"
check = "difference"
case = "low"
method = "Theory"
against = "FEA"
at_most_percent = 2
"""
ERRATA = '[[erratum]]\nid = "z"\nstatement = "z = 4 m"\nreading = "z = 0.4 m"\n'


def write(folder: Path, *, off: float = 1.0, within: float = 0.01, fea: float = 1.01) -> Path:
    """A paper that prints the exact frequencies, `off` by a factor."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cases.toml").write_text(MINE)
    lines = ["case,method,mode,frequency_hz,where"]
    for name, case in load_cases(folder / "cases.toml").items():
        for i, f in enumerate(Continuum().modes(case.mechanism, case.pose, 6).frequencies, 1):
            lines += [f"{name},Theory,{i},{off * f:.3f},Table 2", f"{name},FEA,{i},{f / fea:.2f},T"]
    (folder / "table.csv").write_text("\n".join(lines))
    (folder / "paper.toml").write_text(ABOUT)
    (folder / "claims.toml").write_text(CLAIMS.format(within=within))
    (folder / "errata.toml").write_text(ERRATA)
    (folder / "fig3.csv").write_text("case,elements,mode,error_percent\nlow,1,1,0.18\n")
    return folder


@pytest.mark.parametrize("name", sorted({*filter(folder, names())} - {CHECKED}))
def test_what_others_printed_is_met(name: str) -> None:
    """By the case's own model, to the last digit: none of these numbers is ours."""
    count = 0
    for key, case in load_cases(Path(name)).items():
        assert case.paper is not None and case.paper.citation.count(",") >= 3
        most = max(one.mode for one in case.printed)
        f = case.theory.modes(case.mechanism, case.pose, most).frequencies
        for one in case.printed:
            near = max(1.02 * one.half, DIGITS * one.frequency)
            right = abs(f[one.mode - 1] - one.frequency) <= near
            assert right != (one.mode in WRONG.get((name, key), ())), (key, one, f[one.mode - 1])
            count += 1
    assert count >= 3
    found = study("claims", case_file=name)
    kinds = found.to_frame().set_index("id")["kind"]
    assert not found.failures()
    assert set(kinds.index[kinds != "holds"]) == (
        {"simply-supported"} if "thomson" in name else set()
    )


def test_the_paper_that_is_checked_is_a_folder_like_others() -> None:
    """Its name gives the named cases; its claims are those asked for without it."""
    assert load_cases(Path(CHECKED)) == PRESETS
    assert load_cases(folder(CHECKED) or Path()) == PRESETS
    only = "eq2-plane,table1-case1-error-f2"
    given = study("claims", case_file=CHECKED, only=only).to_frame()
    assert given.equals(study("claims", only=only).to_frame()) and len(given) == 2
    for case in PRESETS.values():
        assert case.paper is not None and case.prints_errors
        assert case.printed == PRESETS[case.published].printed
        assert {*case.errata} <= {one.id for one in case.paper.errata}


def test_every_study_takes_the_folder(tmp_path: Path) -> None:
    folder = write(tmp_path / "other")
    table = study("table", case_file=folder, references="rayleigh@exact")
    (line,) = [one for one in table.sentences() if "(Theory)" in one]
    assert line.startswith("12 of the 12 values that other prints (Theory) agree with euler-b")
    printed = table.tables()["-printed"]
    assert len(printed.rows) == 24 and "A. N. Other" in " ".join(table.table().notes)
    assert any("z = 4 m is printed" in note for note in table.table().notes)
    budget = study("budget", case_file=folder, references="timoshenko@exact", elements="1-3")
    assert set(budget.to_frame()["case"]) == {"low", "high"}
    judged = study("claims", case_file=folder)
    assert judged.table().notes == (
        "2 holds; 0 holds only if; 0 cannot be reproduced as printed; 0 fails",
    )
    claims = judged.to_frame().set_index("id")
    assert list(claims["kind"]) == ["holds", "holds"]
    assert "at most +1" in claims.loc["fea", "measured"]


def test_a_wrong_table_is_seen(tmp_path: Path) -> None:
    folder = write(tmp_path / "other", off=1.03)
    (line,) = [one for one in study("table", case_file=folder, references="rayleigh@exact")
               .sentences() if "(Theory)" in one]  # fmt: skip
    assert line.startswith("0 of the 12") and "-2.91 %" in line
    found = study("claims", case_file=folder)
    assert list(found.to_frame()["kind"]) == ["fails", "fails"]


@pytest.mark.slow
def test_the_table_says_which_mechanism_it_is_of(tmp_path: Path) -> None:
    """identify from the folder alone: the height that is wrong in it is found."""
    folder = write(tmp_path / "other")
    text = (folder / "cases.toml").read_text()
    (folder / "cases.toml").write_text(text.replace("z_mm = 400", "z_mm = 415"))
    found = study("identify", case_file=folder, model="euler-bernoulli@8", parameters="low.z_mm",
                  references="rayleigh@3", method="Theory", free="0", starts="2")  # fmt: skip
    frame = found.to_frame()
    assert np.isclose(frame["value"].astype(float), 400, atol=0.01).any(), frame


def spoiled(folder: Path, name: str, old: str, new: str) -> Callable[[], Any]:
    file = write(folder) / name
    file.write_text(file.read_text().replace(old, new))

    def read() -> Any:
        (paper, _) = (case.paper for case in load_cases(folder).values())
        assert paper is not None
        return paper.claims, paper.errors

    return read


@pytest.mark.parametrize(
    ("name", "old", "new", "says"),
    [
        ("table.csv", "where", "page", "table = .*: expected the columns case, method, mode"),
        ("table.csv", "low,FEA", "deep,FEA", "'deep': expected one of the cases low, high"),
        ("table.csv", "Theory,1,", "Theory,0,", "expected a mode from 1, and hertz above zero"),
        ("paper.toml", "year = 2020", "", "expected the key year"),
        ("paper.toml", "year", "doi = 1\nyear", "'doi': expected only the keys"),
        ("paper.toml", "= 2020", "=", "expected a TOML file"),
        ("fig3.csv", "0.18", "much", "fig3.csv = None: expected the columns case, elements"),
        ("claims.toml", '"printed"', '"seems"', "claim ours = 'seems': expected one of printed"),
        ("claims.toml", 'how = "by', 'why = "by', "the key 'how' in every claim"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, name: str, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        spoiled(tmp_path / "other", name, old, new)()


def test_mechanisms_come_along_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert {"hexapod", "tricept"} <= {*load_cases(Path("mechanisms"))}
    Path("mechanisms").write_text("[cases.mine]\nz_mm = 500\n")  # one's own file goes first
    assert [*load_cases(Path("mechanisms"))] == ["mine"]


def test_a_paper_that_is_not_there(rps_bench: Callable[..., Any]) -> None:
    said = rps_bench("table", "--case-file", "nowhere")
    assert said.status == 2 and "or one that comes along: beam-with-tip-mass, code-" in said.err
    said = rps_bench("claims", "--case-file", str(Path(__file__)))
    assert said.status == 2
