"""Phases of an answer: each second belongs to the innermost one, and all of them add up."""

import pytest

from reference_models import spent
from reference_models.spent import PHASES, phase, recorded


def test_every_second_has_one_phase(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(spent.time, "perf_counter", lambda: now[0])
    with recorded() as record:
        now[0] += 1
        with phase("projection"):
            now[0] += 2
            with phase("simulator"):
                now[0] += 4
            now[0] += 8
        with pytest.raises(ZeroDivisionError), phase("shapes"):
            now[0] += 16
            1 / 0  # noqa: B018
        now[0] += 32
    found = {k: v for k, v in record.seconds.items() if v}
    assert found == {"": 33, "projection": 10, "simulator": 4, "shapes": 16}


def test_nothing_is_kept_unless_recorded() -> None:
    with phase("simulator"):
        pass
    with recorded() as record, recorded(), phase("simulator"):
        pass
    assert record.seconds["simulator"] == 0 and set(record.seconds) == {"", *PHASES}
