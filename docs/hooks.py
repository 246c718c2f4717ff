"""What the site is made of besides its pages: equations as MathML, and the commands' options.

Equations stand as GitHub reads them, ```math blocks and $`...`$, and become MathML when the site is
built: no script and no network shows them.
"""

import re
from typing import Any

import click
from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$`(.+?)`\$")
COMMANDS = "<!-- commands -->"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return a page with its equations as MathML and the list of commands in its place."""
    text = BLOCK.sub(lambda m: f"<p>{convert(m[1].strip(), display='block')}</p>", markdown)
    text = INLINE.sub(lambda m: f"<span>{convert(m[1])}</span>", text)
    return text.replace(COMMANDS, commands()) if COMMANDS in text else text


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
