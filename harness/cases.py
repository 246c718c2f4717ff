"""The named cases: those of the paper that is checked."""

from analytic.errors import unknown
from harness.case import Case
from harness.case_file import presets

PRESETS = presets()


def select(names: list[str], extra: dict[str, Case]) -> list[Case]:
    """Return the cases called `names` among the presets and `extra`, or raise `InputError`."""
    known = PRESETS | extra
    for name in names:
        if name not in known:
            raise unknown("cases", name, known)
    return [known[name] for name in dict.fromkeys(names)]
