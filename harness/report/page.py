"""The page: sections in order, one template each, and the plotting library, in one file.

What a run gave is kept as page.json beside it: the page can be made anew, with the newest history
and the gate's last answer, without solving anything.
"""

import json
from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from gzip import compress
from hashlib import sha256
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, UndefinedError
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from analytic import InputError, __version__
from harness.report import first, history, maps, sections
from harness.report.section import Json, Ledger, Material, Section
from harness.reproduce import Part
from harness.request import Plan
from harness.studies import find

PAGE, FILE, CHECK = "index.html", "page.json", "check.json"
FORMAT, VERSION = "rps-bench page", 2
COMMAND = "rps-bench reproduce"
OTHERS = {
    "refine": "Limits", "slenderness": "Slenderness", "stiffness": "Stiffness", "cost": "Cost",
    "identify": "Identification",
}  # fmt: skip
"""Studies without a picture of their own, and what the navigation calls them."""
SECTIONS: dict[str, tuple[str, str, str, Callable[[Material], Section | None] | None]] = {
    "result": ("The result", "Result", "", first.first),
    "claims": ("The paper's claims, one by one", "Claims", "claims", sections.claims),
    "table1": ("Table I: natural frequencies", "Table I", "table", sections.table_one),
    "fig3": ("Fig. 3: error against the number of elements", "Fig. 3", "convergence,table",
             sections.fig3),
    "budget": ("Error budget", "Budget", "budget", sections.budget),
    "work-precision": ("Work and precision", "Precision", "work-precision", sections.precision),
    "workspace": ("Workspace: frequencies over the poses", "Workspace", "workspace", None),
    "shapes": ("Mode shapes", "Shapes", "table,convergence,shapes", sections.shapes),
    **{name: (find(name).title, menu, name, partial(sections.other, name=name))
       for name, menu in OTHERS.items()},
    "history": ("History: what moved between runs", "History", "", None),
    "provenance": ("Provenance: where the numbers come from", "Provenance", "",
                   sections.provenance),
}  # fmt: skip
"""Title, name in the navigation, studies that make it ("": all of the run), and what makes it of
the run alone."""


def page_files(
    plan: Plan,
    parts: Sequence[Part],
    history: Path | None,
    command: str = COMMAND,
    check: Json | None = None,
) -> dict[str, bytes]:
    """Return the page of a run and page.json, as files to write.

    `history`: the folder of the history, None for none; `command` that made the run; `check`: the
    gate's last answer.
    """
    text = json.dumps(content(plan, parts, command), separators=(",", ":"), allow_nan=False)
    return {PAGE: _rendered(json.loads(text), history, check), FILE: text.encode()}


def renewed(results: Path, history: Path | None) -> dict[str, bytes]:
    """Return the page of the run in `results` with the gate's last answer; {} if there is none."""
    if not (results / FILE).is_file():
        return {}
    return {PAGE: render(load(results), history, load_check(results))}


def content(plan: Plan, parts: Sequence[Part], command: str = COMMAND) -> Json:
    """Return what the page says of a run, in the form of page.json."""
    run = Material(plan, tuple(parts), command)
    made = {key: make(run) for key, (*_, make) in SECTIONS.items() if make}
    return {
        "format": FORMAT, "version": VERSION, "release": __version__, "command": command,
        "references": [one.name for one in plan.references],
        "made": [part.entry.name for part in parts if not part.why],
        "sections": {key: vars(_headed(key, one, command)) for key, one in made.items() if one},
        "maps": maps.own(run), "ledger": run.ledger.records,
    }  # fmt: skip


def _headed(key: str, one: Section, command: str) -> Section:
    """Return a section with its title and the command that makes it, where `command` makes all."""
    title, menu, studies, _ = SECTIONS[key]
    only = f"{command} --only {studies}" if studies else command
    return replace(one, key=key, title=title, menu=menu, command=only)


def load(results: Path) -> Json:
    """Return page.json of the folder `results`; raises `InputError` where it is none of ours."""
    expected = f"a folder with a {FILE} that `{COMMAND}` of this release has written"
    try:
        kept = json.loads((results / FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is damaged"
        raise InputError("results", str(results), f"{expected} ({FILE}: {reason})") from None
    known = isinstance(kept, dict) and kept.get("format") == FORMAT
    version = kept.get("version") if known else "none"
    if version != VERSION:
        raise InputError("results", str(results), f"{expected} (version {VERSION}, not {version})")
    return dict(kept)


def load_check(results: Path) -> Json | None:
    """Return the gate's last answer in the folder `results`, None where there is none."""
    file = results / CHECK
    if not file.is_file():
        return None
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError("results", str(results), f"a {CHECK} that `rps-bench check` has written")
    return found


def render(kept: Json, folder: Path | None, check: Json | None) -> bytes:
    """Return the page as one HTML file that asks for nothing outside itself.

    `kept`: page.json; `folder` of the history, None for none; `check`: the gate's last answer.
    Raises `InputError` where `kept` lacks what the templates show.
    """
    try:
        return _rendered(kept, folder, check)
    except (KeyError, TypeError, AttributeError, UndefinedError) as error:
        raise InputError("results", FILE, f"a file that is whole (it lacks {error})") from None


def _rendered(kept: Json, folder: Path | None, check: Json | None) -> bytes:
    ledger = Ledger(kept["ledger"])
    own = kept["maps"]["maps"] if kept["maps"] else []
    recorded = history.read_recorded(
        folder, history.MOST_NUMBERS - sum(len(one["rows"]) for one in own)
    )
    shown = {key: Section(**one) for key, one in kept["sections"].items()}
    top = shown["result"]
    shown["result"] = replace(top, context={**top.context, "gate": first.gate(check)})
    if kept["maps"] or recorded.maps:
        made = maps.section(kept["maps"], recorded, ledger, kept["command"])
        shown["workspace"] = _headed("workspace", made, kept["command"])
    if folder is not None:
        shown["history"] = _headed("history", history.section(recorded), "rps-bench history")
    return _html([shown[key] for key in SECTIONS if key in shown], ledger).encode()


def _html(sections: Sequence[Section], ledger: Ledger) -> str:
    loader = PackageLoader("harness.report")
    environment = Environment(
        loader=loader,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters |= {
        "pairs": lambda names: [(name, name) for name in names],
        "numbered": lambda names: list(enumerate(names)),
        "every": lambda ones, key: dict.fromkeys(name for one in ones for name in one[key]),
    }
    known = environment.list_templates()

    def source(name: str) -> str:
        return loader.get_source(environment, name)[0].strip()

    parts = []
    for one in sections:
        template = environment.select_template([f"{one.key}.html", "study.html"])
        body = "" if one.missing else Markup(template.render(data=one.data, **one.context))
        parts.append({"section": one, "body": body})
    files = ["page.js", *(f"{one.key}.js" for one in sections if not one.missing)]
    scripts = [source(name) for name in files if name in known]
    script = "\n".join(["(async () => {", *scripts, "await library();", "watch();", "})();"])
    # Infinities and NaN are no JSON: better no page than one that does not open.
    data = json.dumps(
        {"ledger": ledger.records} | {one.key: one.data for one in sections},
        separators=(",", ":"), allow_nan=False,
    )  # fmt: skip
    start, plotly = source("start.js"), get_plotlyjs()
    return environment.get_template("page.html").render(
        parts=parts,
        version=__version__,
        start=Markup(start),
        script=Markup(script),
        allowed=" ".join(f"'sha256-{_hash(text)}'" for text in (start, script, plotly)),
        data=_packed(data),
        plotly=_packed(plotly),
    )


def _packed(text: str) -> str:
    return b64encode(compress(text.encode(), mtime=0)).decode()


def _hash(script: str) -> str:
    return b64encode(sha256(script.encode()).digest()).decode()
