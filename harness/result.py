"""What every study returns: numbers as a frame, tables, figures and sentences."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from harness.bench import Study, label
from harness.signatures import Figure
from harness.tables import Table

if TYPE_CHECKING:
    import pandas as pd


class Result:
    """The answer of a study; it knows no file, no command line and no page.

    A subclass is a frozen dataclass, its field `study` what was solved for it. It gives `records`,
    `tables`, and where a picture makes sense `figures`; keys of the last two are endings of file
    names, the first of them "".
    """

    def records(self) -> Iterable[Mapping[str, Any]]:
        """Return the numbers as tidy rows: SI, units in the names of their columns."""
        raise NotImplementedError

    def to_frame(self) -> "pd.DataFrame":
        """Return `records` as a pandas frame."""
        import pandas as pd

        return pd.DataFrame(list(self.records()))

    def tables(self) -> Mapping[str, Table]:
        """Return the tables by the ending of their files' names."""
        raise NotImplementedError

    def figures(self) -> Mapping[str, Figure]:
        """Return the figures by the ending of their files' names."""
        return {}

    def sentences(self) -> Sequence[str]:
        """Return what the numbers say, in plain words, the most important first."""
        return ()

    @property
    def studies(self) -> tuple[Study, ...]:
        """All that was solved for it: history and failures are read from here."""
        own = getattr(self, "study", None)
        return () if own is None else (own,)

    def rows(self) -> list[dict[str, Any]]:
        """Return the tidy rows that the history keeps of it."""
        return [row for study in self.studies for row in study.rows()]

    def failures(self) -> dict[str, str]:
        """Return what has no answer ("MODEL at CASE"), and why."""
        return {
            f"{label(model)} at {case.name}": why
            for study in self.studies
            for (case, model), why in study.failures.items()
            if (case, model) not in study.refused
        }

    def refusals(self) -> dict[str, str]:
        """Return which models cannot take a mechanism ("MODEL at CASE", no meshes), and why."""
        return {
            f"{getattr(model, 'name', label(model))} at {case.name}": study.failures[case, model]
            for study in self.studies
            for case, model in study.failures
            if (case, model) in study.refused
        }

    def table(self) -> Table:
        """Return the first of `tables`."""
        return next(iter(self.tables().values()))

    def plot(self) -> Figure | None:
        """Return the first of `figures`, or None where there is none."""
        from harness.figures import own_style

        with own_style():
            return next(iter(self.figures().values()), None)

    def _repr_html_(self) -> str:
        return str(self.table().to_frame().to_html(index=False))
