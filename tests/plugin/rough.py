"""Models that misbehave before they are asked for a number: in `info()`, or while imported.

`import_ACT.py` of a test's folder imports `act`, and does ACT first of all.
"""

import ctypes
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from wrong import Honest  # type: ignore[import-not-found]

from analytic.model import Info


def loud() -> None:
    os.write(1, b"noise\n" * 100_000)
    os.write(2, b"noise\n" * 100_000)
    print("noise")


ACTS: dict[str, Callable[[], Any]] = {
    "crash": lambda: ctypes.string_at(0),
    "hang": lambda: time.sleep(600),
    "quit": lambda: os._exit(0),
    "exit": lambda: sys.exit(0),
    "fill": lambda: np.empty(1 << 50),
    "shout": loud,
}


class Foreign(Info):
    """Of a class that only its maker has."""


def asked(act: str) -> type[Honest]:
    """Return a model that does `act` when it is asked what it is."""

    class Rough(Honest):
        @classmethod
        def info(cls) -> Info:
            ACTS[act]()
            return Foreign(**vars(Honest.info()))

    return Rough


Crash, Hang, Quit, Exit, Fill, Shout = map(asked, ACTS)
