"""The process that runs in MuJoCo 3.17.0's environment: pickled questions in, answers out."""

import os
import pickle
import sys

from reference_models.mujoco.cable import MujocoCable


def main() -> None:
    """Answer (elements, mechanism, pose, count) with modes, or with what was raised."""
    # Whatever MuJoCo prints must not get between the answers.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    while True:
        try:
            elements, *question = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            found: object = MujocoCable(elements).modes(*question)
        except Exception as error:
            found = error
        pickle.dump(found, answers)
        answers.flush()


if __name__ == "__main__":
    main()
