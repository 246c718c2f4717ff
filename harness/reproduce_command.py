"""`rps-bench reproduce`: the main job, or some of its parts."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from harness.files import write_all
from harness.options import Request, available, split, takes_request
from harness.run import Study
from harness.terminal import finish, progress, status


@click.command()
@click.option("--only", metavar="PART,PART", help="Make only these parts; the others stay.")
@takes_request
def reproduce(request: Request, only: str | None) -> int:
    """The main job: every table and figure, into --output (default results/).

    Fig. 3 and Table I are drawn against the first of --references. A part is written as soon as it
    is done; one that fails costs no other, and makes the exit status 1.
    """
    from harness.reproduce import SUMMARY, Plan, chosen, page
    from harness.reproduce import reproduce as make
    from harness.sections import SECTIONS

    sections = chosen(SECTIONS, None if only is None else split("--only", only))
    plan = Plan(
        tuple(request.chosen),
        request.theory("euler-bernoulli@3"),
        tuple(request.against(available())),
        tuple(request.steps("1-8")),
        tuple(request.shown),
    )
    folder = request.folder or Path("results")
    written = 0
    studies: list[Study] = []
    timed: list[Mapping[str, Any]] = []
    failures: dict[tuple[str, str], str] = {}
    with progress(sum(section.steps(plan) for section in sections)) as done:
        for section, part in make(sections, plan, done):
            summary = folder / SUMMARY
            known = summary.read_text() if summary.is_file() else ""
            text = page(SECTIONS, known, section, part)
            written += len(write_all(folder, part.files | {SUMMARY: text.encode()}))
            studies += part.studies
            timed += part.rows
            failures |= part.failures or {}
            click.echo(f"{section.title}:")
            for line in part.sentences:
                click.echo(f"  - {line}")
    click.echo(f"{written} files in {folder}/; start with {folder / SUMMARY}")
    # Sections share models: what a study says failed is said once, by `finish`.
    said = {key for study in studies for key in study.failures}
    ended = status({key: why for key, why in failures.items() if key not in said})
    return max(ended, finish(request.history, *studies, more=timed))
