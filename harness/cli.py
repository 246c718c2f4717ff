"""The command line: each command is loaded when it is called, and only that one."""

import atexit
import gc
import sys
from importlib import import_module

import click

from harness.threads import one_thread

COMMANDS = {
    "table": "study_commands:table",
    "convergence": "study_commands:convergence",
    "refine": "study_commands:refine",
    "budget": "study_commands:budget",
    "slenderness": "study_commands:slenderness",
    "shapes": "study_commands:shapes",
    "cost": "precision.cost_command:cost",
    "work-precision": "precision.command:precision",
    "workspace": "workspace.command:workspace",
    "sweep": "sweep.command:sweep",
    "claims": "claims.command:claims",
    "identify": "identification.command:identify",
    "reproduce": "reproduce_command:reproduce",
    "check": "gate.command:check",
    "history": "history.command:history",
    "dashboard": "dashboard_command:dashboard",
    "models": "list_commands:models",
    "cases": "list_commands:list_cases",
}
"""Where each command is: module of this package, and its name there."""

# Libraries are no garbage: to search them for some is a fifth of the time to load them, and a tenth
# of a second at the end.
gc.set_threshold(100_000)
atexit.register(gc.freeze)


class Commands(click.Group):
    """The commands above."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of `COMMANDS`."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, loaded now, or None where there is none of that name."""
        if cmd_name not in COMMANDS:
            return None
        module, _, name = COMMANDS[cmd_name].partition(":")
        command: click.Command = getattr(import_module(f"harness.{module}"), name)
        return command


def main() -> None:
    """Run the command line; bad input ends with one sentence and exit status 2."""
    try:
        with one_thread():
            ended = cli(standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("rps-bench: interrupted", err=True)
        sys.exit(130)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        sys.exit(2)
    except click.ClickException as error:
        click.echo(f"rps-bench: {error.format_message()}", err=True)
        sys.exit(2)
    except Exception as error:
        if not _is_sentence(error):
            raise
        click.echo(f"rps-bench: {error}", err=True)
        sys.exit(2)
    sys.exit(ended if isinstance(ended, int) else 0)


def _is_sentence(error: Exception) -> bool:
    """Whether `error` says to the user what is wrong; loading what it might be takes a while."""
    from analytic import InputError
    from harness.files import OutputError
    from reference_models import UnavailableError

    return isinstance(error, (InputError, UnavailableError, OutputError))


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rps-bench", prog_name="rps-bench")
def cli() -> None:
    """Check the published model of the 3-RPS manipulator against independent simulators."""
