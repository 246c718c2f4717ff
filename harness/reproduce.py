"""The main job: every table and figure of the paper that this bench has, part by part."""

import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from analytic import InputError
from harness.cases import Case
from harness.models import Spec
from harness.run import Study, keeping
from reference_models import ModelError, UnavailableError

SUMMARY = "summary.md"
TOP = """# Summary

Written by `rps-bench reproduce`; `--only NAME,NAME` makes single parts anew. Parts that hold
seconds say so; all other files depend on the programs alone.
"""


@dataclass(frozen=True)
class Plan:
    """What is asked for; Table I and Fig. 3 are drawn against the first of `references`."""

    cases: tuple[Case, ...]
    theory: Spec
    references: tuple[Spec, ...]
    steps: tuple[int, ...]
    shown: tuple[int, ...]

    @property
    def count(self) -> int:
        """Modes solved for."""
        return max(6, *self.shown)

    @property
    def names(self) -> list[str]:
        """The reference models' names, each once."""
        return list(dict.fromkeys(spec.name for spec in self.references))


@dataclass(frozen=True)
class Part:
    """What a section makes: `files` by name, what they say in `sentences`, and what failed.

    `rows` for the history beside those of `studies`.
    """

    files: dict[str, bytes]
    sentences: Sequence[str]
    studies: tuple[Study, ...] = ()
    failures: Mapping[tuple[str, str], str] | None = None
    rows: Sequence[Mapping[str, Any]] = ()


Done = Callable[[str], None]


@dataclass(frozen=True)
class Section:
    """One part of the job: `name` for --only, `title` in the summary, `command` that it is.

    `steps` that `make` reports; `timed`: whether its files hold seconds.
    """

    name: str
    title: str
    command: str
    steps: Callable[[Plan], int]
    make: Callable[[Plan, Done], Part]
    timed: bool = False


def chosen(sections: Sequence[Section], names: Sequence[str] | None) -> list[Section]:
    """Return the sections called `names`, or all of them, in their own order."""
    known = [section.name for section in sections]
    for name in names or []:
        if name not in known:
            raise InputError("--only", name, f"some of {', '.join(known)}")
    return [section for section in sections if names is None or section.name in names]


def reproduce(
    sections: Sequence[Section], plan: Plan, done: Done = lambda _: None
) -> Iterator[tuple[Section, Part]]:
    """Yield every section's part; one that cannot be made says why and costs no other."""
    with keeping():
        for section in sections:
            try:
                yield section, section.make(plan, done)
            except (ModelError, UnavailableError) as error:
                failures = {(section.title, section.name): str(error)}
                yield section, Part({}, [f"Not made: {error}."], failures=failures)


def page(sections: Sequence[Section], known: str, section: Section, part: Part) -> str:
    """Return the summary `known` with what `section` says now, in the order of `sections`."""
    chapters = dict(re.findall(r"^## (.*)\n((?:(?!## ).*\n)*)", known, flags=re.MULTILINE))
    chapters[section.title] = _chapter(section, part)
    body = [f"## {s.title}\n{chapters[s.title]}" for s in sections if s.title in chapters]
    return "\n".join([TOP, *(chapter.rstrip("\n") + "\n" for chapter in body)])


def _chapter(section: Section, part: Part) -> str:
    stems = [name.removesuffix(".md") for name in part.files if name.endswith(".md")]
    tables = [f"[{stem}]({stem}.md)" for stem in stems]
    others = [f"[{name}]({name})" for name in part.files if name.endswith((".json", ".csv"))
              and name.rpartition(".")[0] not in stems]  # fmt: skip
    pictures = [name for name in part.files if name.endswith(".svg")]
    pictures += [name for name in part.files
                 if name.endswith(".png") and f"{name[:-4]}.svg" not in pictures]  # fmt: skip
    lines = ["", *(f"- {line}" for line in part.sentences), ""]
    seconds = " It holds seconds, which differ from run to run." if section.timed else ""
    lines += [f"This part alone: `{section.command}`.{seconds}", ""]
    if tables or others:
        lines += [f"Tables (each also as CSV and LaTeX): {', '.join(tables + others)}.", ""]
    lines += [f"![{Path(name).stem}]({name})" for name in pictures]
    return "\n".join(lines) + "\n"


def tidy(records: list[dict[str, Any]]) -> bytes:
    """Return tidy rows as CSV."""
    text = io.BytesIO()
    pl.DataFrame(records, infer_schema_length=None).write_csv(text)
    return text.getvalue()
