"""The command line: each command is loaded when it is called, and only that one."""

import atexit
import difflib
import errno
import gc
import io
import os
import sys
import warnings
from importlib import import_module

import click

from harness.cli.flags import dashed
from harness.plain import plain
from harness.studies import STUDIES
from harness.threads import one_thread

OTHERS = {
    "reproduce": ("study", "Run every study and write the page, into results/latest."),
    "accept": ("check", "Take results/latest as what README shows and the gate expects."),
    "sweep": ("sweep", "Solve any poses by any models, on all cores or a cluster; resumable."),
    "check": ("check", "Check what moved since the accepted figures, and what must hold."),
    "history": ("history", "List, filter, query and export the runs so far."),
    "dashboard": ("commands", "Make the page anew from the last run and the history."),
    "new": ("commands", "Write a commented template: case, mechanism, model, study or paper."),
    "export": ("commands", "Write a case as input files for a simulator of your own."),
    "verify": ("commands", "Tell a model's author what of it fails, and how."),
    "models": ("commands", "List every model: its theory, version, and whether it can run."),
    "cases": ("commands", "List every case: its pose, and what of it was read or fitted."),
}
"""Commands that are no study: the module of this package that has each, and what it does."""
HELP = {entry.name: entry.help for entry in STUDIES} | {k: v[1] for k, v in OTHERS.items()}
FIRST = """\
rps-bench checks a published model of the 3-RPS manipulator against independent simulators.

Three things to start with:
  rps-bench table               Table I of the paper, beside what it prints
  rps-bench reproduce           every table and figure, and a page, into results/latest
  rps-bench table --case-file mine.toml    your own mechanism

All commands: rps-bench --help
"""

# Libraries are no garbage: to search them for some is a fifth of the time to load them, and a tenth
# of a second at the end.
gc.set_threshold(100_000)
atexit.register(gc.freeze)


class Commands(click.Group):
    """The studies, and the commands above; one is loaded when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in their own order."""
        return list(HELP)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, loaded now, or None where there is none of that name."""
        if cmd_name not in HELP:
            return None
        module, _ = OTHERS.get(cmd_name, ("study", ""))
        found = import_module(f"harness.cli.{module}")
        command: click.Command = (
            getattr(found, cmd_name) if cmd_name in OTHERS else found.study_command(cmd_name)
        )
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; of an unknown one say which was meant."""
        if args and args[0] not in HELP:
            near = difflib.get_close_matches(args[0], HELP, 1)
            meant = f"did you mean {near[0]}?" if near else "`rps-bench --help` lists them"
            raise click.UsageError(f"there is no command {args[0]!r}; {meant}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands with their first sentences, loading none of them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(HELP.items()))


def main() -> None:
    """Run the command line; bad input ends with one sentence and exit status 2."""
    warnings.showwarning = _warn
    _streams()
    out = sys.stdout
    try:
        with one_thread():
            ended = cli(standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read has enough: everything is written before it is shown
        _hush()
        sys.exit(0)
    except SystemExit:
        if sys.stdout is not out:  # click met such a pipe, puts a wrapper there and says 1
            sys.stdout = out
            _hush()
            sys.exit(0)
        raise
    except (click.exceptions.Abort, KeyboardInterrupt):
        _say("interrupted")
        sys.exit(130)
    except click.ClickException as error:
        _say(error.format_message())
        sys.exit(2)
    except OSError as error:
        if error.filename is not None or error.errno not in (errno.ENOSPC, errno.EIO, errno.EBADF):
            raise
        _hush()  # files are written before anything is shown
        _say(f"cannot show more: the standard output takes nothing ({error.strerror})")
        sys.exit(1)
    except Exception as error:
        from analytic import InputError  # to load what it might be takes a while
        from harness.output import OutputError
        from reference_models import UnavailableError

        if not isinstance(error, (InputError, UnavailableError, OutputError)):
            raise
        _say(dashed(str(error)))
        sys.exit(2)
    sys.exit(ended if isinstance(ended, int) else 0)


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    _say(f"warning: {message}")


def _streams() -> None:
    """Open what is closed, lest a file take its place; show letters that a terminal has not."""
    while (opened := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(opened)
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _hush() -> None:
    """Let what is left of the standard output go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _say(sentence: str) -> None:
    click.echo(f"rps-bench: {plain(sentence)}", err=True)


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="rps-bench", prog_name="rps-bench")
@click.pass_context
def cli(context: click.Context) -> None:
    """Check the published model of the 3-RPS manipulator against independent simulators."""
    if context.invoked_subcommand is None:
        click.echo(FIRST)
