"""More models of somebody else's: answers that are none, and bad manners, one way each."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from wrong import Honest, scaled, wrong  # type: ignore[import-not-found]

from analytic import InputError, Mechanism, Modes, Pose, Substructure
from analytic.model import Info
from analytic.modes import STATIONS


def field(**changes: Any) -> Callable[[Modes], Modes]:
    """Return what sets fields of an answer behind the back of its class."""

    def spoil(modes: Modes) -> Modes:
        for name, value in changes.items():
            old = getattr(modes, name)
            object.__setattr__(modes, name, value(old) if callable(value) else value)
        return modes

    return spoil


def first(value: float) -> Callable[[Any], Any]:
    """Return what sets the first frequency."""

    def change(frequencies: Any) -> Any:
        return np.concatenate([[value], frequencies[1:]])

    return field(frequencies=change)


def does(*acts: Callable[[], Any]) -> Callable[[Modes], Modes]:
    """Return what does something that is none of its business, and answers right."""

    def spoil(modes: Modes) -> Modes:
        for act in acts:
            act()
        return modes

    return spoil


class Once(Honest):
    """Spoils one mesh and has no other: a process that ends, or hangs, is waited for."""

    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), refinements=None, ladder=(4,))

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Any:
        if self.elements != 4:
            raise InputError("elements", self.elements, "4")
        return self.spoil(mechanism, pose, count)


def once(name: str) -> Callable[[Callable[[Modes], Any]], type[Honest]]:
    """Return a decorator as `wrong` does, of a model with one mesh."""

    def make(function: Callable[[Modes], Any]) -> type[Honest]:
        spoiled = wrong(name)(function)
        return dataclass(frozen=True)(type(name, (Once,), {"spoil": spoiled.spoil}))

    return make


# Answers that are none.
Complex = wrong("Complex")(field(frequencies=lambda f: f.astype(complex)))
Infinite = wrong("Infinite")(first(np.inf))
Negative = wrong("Negative")(field(frequencies=lambda f: -f[::-1]))
NegativeZero = wrong("NegativeZero")(first(-0.0))
Subnormal = wrong("Subnormal")(scaled(1e-313))
Single = wrong("Single")(field(frequencies=lambda f: f.astype(np.float32)))
SingleShapes = wrong("SingleShapes")(field(limbs=lambda x: x.astype(np.float32)))
Whole = wrong("Whole")(field(frequencies=lambda f: f.astype(int)))
Objects = wrong("Objects")(field(frequencies=lambda f: f.astype(object)))
Masked = wrong("Masked")(field(frequencies=lambda f: np.ma.masked_less(f, 200.0)))
Text = wrong("Text")(field(frequencies=lambda f: f.astype(str)))
List = wrong("List")(field(frequencies=lambda f: f.tolist()))
Nothing = wrong("Nothing")(lambda _: None)
Column = wrong("Column")(field(frequencies=lambda f: f[:, None]))
Doubtful = wrong("Doubtful")(field(uncertainty=lambda _: np.array([np.nan])))
Swapped = wrong("Swapped")(
    field(platform=lambda x: x[[2, 1, 0, *range(3, len(x))]],
          limbs=lambda x: x[[2, 1, 0, *range(3, len(x))]])
)  # fmt: skip
Shuffled = wrong("Shuffled")(field(limbs=lambda x: x[:, [1, 2, 0]]))
Limbless = wrong("Limbless")(
    field(limbs=lambda x: x * np.array([1.0, 0.0, 1.0])[None, :, None, None])
)
Backward = wrong("Backward")(field(limbs=lambda x: x[:, :, ::-1]))
Mirrored = wrong("Mirrored")(field(limbs=lambda x: x * [1.0, -1.0, 1.0]))
Theoryless = wrong("Theoryless")(field(theory=3))
Sizeless = wrong("Sizeless")(field(dofs=None))
Timeless = wrong("Timeless")(field(solve_seconds=np.nan))
Spoken = wrong("Spoken")(field(residual="closed"))
Unpicklable = wrong("Unpicklable")(field(model=lambda _: lambda: None))


class Elsewhere(Honest):
    """Of another pose."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return self.right(mechanism, replace(pose, tilt=pose.tilt - 0.2), count)


class LazyModes(Modes):
    @property
    def solve_seconds(self) -> float:  # type: ignore[override]
        raise RuntimeError("not yet")

    @solve_seconds.setter
    def solve_seconds(self, _: float) -> None:
        pass


Lazy = once("Lazy")(lambda modes: LazyModes(**vars(modes)))


class Bomb:
    """What cannot be read at the other end."""

    def __reduce__(self) -> Any:
        return eval, ("1 / 0",)


Unreadable = once("Unreadable")(lambda _: Bomb())


# Ends and errors.
def _raise(error: BaseException) -> Any:
    def spoil(_: Modes) -> None:
        raise error

    return spoil


def _deeper(modes: Modes) -> Any:
    return _deeper(modes)


class Custom(BaseException):
    pass


def _stubborn(_: Modes) -> None:
    signal.alarm(0)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(600)


Deep = wrong("Deep")(_deeper)
Vast = wrong("Vast")(lambda _: np.empty(1 << 50))
Silent = wrong("Silent")(_raise(ValueError()))
Verbose = wrong("Verbose")(_raise(ValueError("\x1b[31mred\n" * 100_000)))


Interrupted = once("Interrupted")(_raise(KeyboardInterrupt()))
Base = once("Base")(_raise(Custom()))
Quits = once("Quits")(lambda _: os._exit(7))
Killed = once("Killed")(lambda _: os.kill(os.getpid(), signal.SIGKILL))
Unplugged = once("Unplugged")(lambda _: os.closerange(3, 1000))
Stopped = once("Stopped")(lambda _: os.kill(os.getpid(), signal.SIGSTOP))
Stubborn = once("Stubborn")(_stubborn)


class Unbuilt(Honest):
    def __init__(self, elements: int = 4) -> None:
        raise RuntimeError("no licence")


class OutOfRange(Honest):
    """Its own numbers of elements are none of its own."""

    def __init__(self, elements: int = 4) -> None:
        if elements > 4:
            raise InputError("elements", elements, "at most 4")
        super().__init__(elements)


# What it says of itself.
class OddOrder(Honest):
    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), order="four")


class OddLadder(Honest):
    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), ladder=None)


class OddTheory(Honest):
    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), limit="euler")


class NoInfoAtAll(Honest):
    info = None


# Bad manners: what is answered is right.
def _loud() -> None:
    for fd in (1, 2):
        os.write(fd, b"\x1b[31m" + b"noise\n" * 100_000)
    print("noise " * 100_000, flush=True)
    print("noise " * 100_000, file=sys.stderr, flush=True)


def _leaves_a_child() -> None:
    child = subprocess.Popen(["sleep", "300"], start_new_session=True)
    note = os.environ.get("NASTY_LOG")
    if note:
        with Path(note).open("a") as file:
            file.write(f"{child.pid}\n")


def _patch() -> None:
    def broken(*_: Any, **__: Any) -> Any:
        raise RuntimeError("patched by somebody else")

    for module, name in ((np.linalg, "eigh"), (np.linalg, "svd"), (scipy.linalg, "eigh"),
                         (pickle, "loads"), (np, "einsum"), (Substructure, "modes")):  # fmt: skip
        setattr(module, name, broken)


def _flood() -> None:
    for i in range(10_000):
        warnings.warn(f"beware of {i}", stacklevel=1)


def _thread() -> None:
    threading.Thread(target=time.sleep, args=(600,)).start()


Loud = wrong("Loud")(does(_loud))
Closes = wrong("Closes")(does(lambda: os.closerange(0, 3), sys.stdout.close))
Forks = wrong("Forks")(does(_leaves_a_child))
Moves = wrong("Moves")(does(lambda: os.chdir("/"), lambda: os.umask(0o777)))
Strict = wrong("Strict")(does(lambda: np.seterr(all="raise")))
Seeds = wrong("Seeds")(does(lambda: np.random.seed(1)))  # noqa: NPY002
Warns = wrong("Warns")(does(_flood))
Threads = wrong("Threads")(does(_thread))
Patches = wrong("Patches")(does(_patch))
LastBits = wrong("LastBits")(
    field(**dict.fromkeys(("frequencies", "platform"), lambda x: x * (1 + 1e-15)))
)


def _frozen(modes: Modes) -> Modes:
    for name in ("frequencies", "platform", "limbs"):
        getattr(modes, name).setflags(write=False)
    return modes


ReadOnly = wrong("ReadOnly")(_frozen)
_BUFFER = np.zeros((100, 3, len(STATIONS), 3))


def _shared(modes: Modes) -> Modes:
    _BUFFER[...] = np.nan
    limbs = _BUFFER[: len(modes.limbs)]
    limbs[:] = modes.limbs
    object.__setattr__(modes, "limbs", limbs)
    return modes


Shared = wrong("Shared")(_shared)


@dataclass(frozen=True)
class Limitless(Honest):
    """Its own `limit` is of no use: what its `info` names is asked."""

    def limit(self) -> Any:
        raise RuntimeError("no limit")
