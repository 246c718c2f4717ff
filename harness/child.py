"""What a process does that `harness.workers` has started: its parent's tasks, one by one."""

import gc
import math
import os
import signal
import sys
import threading
import time
from contextlib import suppress
from multiprocessing.connection import Connection

from harness.workers import GRACE, LOOK, Failure, attempt, end_all_of


def _end_with(parent: int) -> None:
    """End this process and all it started once `parent` has gone: nobody would wait for it."""
    while os.getppid() == parent:
        time.sleep(LOOK)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)
    end_all_of(os.environ["TMPDIR"])
    os.killpg(0, signal.SIGKILL)


def serve(line: Connection) -> None:
    """Solve the tasks that come down `line`, one after the other, as long as there is a parent."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    gc.set_threshold(100_000)  # libraries are no garbage
    import harness.bench  # noqa: F401  what every task needs: before it is ready
    from reference_models.catalogue import ask

    ask(None)  # this is the process that models are loaded in

    with line, suppress(EOFError, BrokenPipeError):
        line.send("ready")
        while True:
            task, limit = line.recv()
            # A model that holds the interpreter cannot be watched from a thread.
            signal.alarm(math.ceil(limit) + 1)
            reply = attempt(task)
            signal.alarm(0)
            try:
                line.send(reply)
            except (EOFError, BrokenPipeError):
                raise
            except Exception as error:  # an answer that cannot be pickled is none
                line.send(Failure(f"its answer cannot be handed over ({error})"))


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
