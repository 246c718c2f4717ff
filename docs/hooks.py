"""What the site is made of besides its pages: equations as MathML, and the commands' options.

Equations stand as GitHub reads them, ```math blocks and $`...`$, and become MathML when the site is
built: no script and no network shows them.
"""

import base64
import io
import re
from pathlib import Path
from typing import Any

import click
from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$`(.+?)`\$")
COMMANDS = "<!-- commands -->"
MECHANISMS = "<!-- mechanisms -->"
FILE = Path(__file__).parents[1] / "results" / "published" / "mechanisms.toml"
MODES = 8


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return a page with equations as MathML, the commands and the mechanisms in their places."""
    text = BLOCK.sub(lambda m: f"<p>{convert(m[1].strip(), display='block')}</p>", markdown)
    text = INLINE.sub(lambda m: f"<span>{convert(m[1])}</span>", text)
    for mark, made in ((COMMANDS, commands), (MECHANISMS, mechanisms)):
        text = text.replace(mark, made()) if mark in text else text
    return text


def mechanisms() -> str:
    """Return every named mechanism: its picture, its exact frequencies and its part of the file."""
    from harness.case_file import load_cases

    cases, source, parts = load_cases(FILE), FILE.read_text("utf-8"), []
    first, *sections = re.split(r"^# -+ (.+)\n", source, flags=re.MULTILINE)
    parts += ["All need these materials and rods:", f"```toml\n{first.strip()}\n```"]
    for title, text in zip(sections[::2], sections[1::2], strict=True):
        parts.append(f"## {title[0].upper()}{title[1:]}")
        parts += [_mechanism(cases[name]) for name in re.findall(r"^\[cases\.(.+)\]", text, re.M)]
        parts.append(f"```toml\n{text.strip()}\n```")
    return "\n\n".join(parts)


def _mechanism(case: Any) -> str:
    from analytic import Continuum
    from harness.figures import own_style
    from harness.studies.shapes import rest_figure

    data = io.BytesIO()
    with own_style():
        rest_figure(case).savefig(data, format="png", dpi=130, metadata={"Software": None})
    picture = base64.b64encode(data.getvalue()).decode()
    found = Continuum("timoshenko").frequencies(case.mechanism, case.pose, MODES)
    chains = " and ".join(dict.fromkeys(limb.described for limb in case.mechanism.limbs))
    names, values = (
        " | ".join(cells)
        for cells in ([f"f{i + 1} [Hz]" for i in range(MODES)], [f"{f:.4f}" for f in found])
    )
    return (
        f'<img alt="{case.name}: limbs {chains}" src="data:image/png;base64,{picture}">\n\n'
        f"Case `{case.name}`, limbs {chains}:\n\n| {names} |\n|{'---|' * MODES}\n| {values} |"
    )


def commands() -> str:
    """Return every command with its help and its options, from click itself."""
    from harness.cli.main import HELP, cli

    parts = []
    for name in HELP:
        command = cli.get_command(None, name)  # type: ignore[arg-type]
        assert command is not None, "it is listed"
        context = click.Context(command, info_name=f"rps-bench {name}")
        usage = " ".join(command.collect_usage_pieces(context))
        rows = [_row(one) for one in command.params if isinstance(one, click.Option)]
        parts += [f"## {name}", f"`rps-bench {name} {usage}`", _escaped(command.help or ""),
                  "\n".join(["| Option | Meaning |", "|---|---|", *rows])]  # fmt: skip
    return "\n\n".join(parts)


def _row(option: click.Option) -> str:
    metavar = "" if option.is_flag else f" {option.metavar or 'VALUE'}"
    shown = f"{option.opts[0]}{metavar}".replace("|", "\\|")
    return f"| `{shown}` | {_escaped(option.help or '')} |"


def _escaped(text: str) -> str:
    return re.sub(r"(?<!\\)([\[\]<>|*_])", r"\\\1", text.strip())
