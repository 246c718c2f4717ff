"""Commented templates that run as they are: what `rps-bench new` writes."""

import re
from importlib.resources import files

from analytic import InputError

FILES = {
    "case": {"NAME.toml": "case.toml"},
    "mechanism": {"NAME.toml": "mechanism.toml"},
    "model": {
        "MODULE.py": "model.py",
        "pyproject.toml": "model-pyproject.toml",
        "test_MODULE.py": "model-test.py",
    },
    "study": {"MODULE.py": "study.py"},
    "paper": {
        f"NAME/{name}": f"paper-{name}"
        for name in ("paper.toml", "cases.toml", "table.csv", "claims.toml")
    },
}
"""By kind: the files that are written, and the template of each."""
NEXT = {
    "case": "rps-bench table --case-file NAME.toml",
    "mechanism": "rps-bench table --case-file NAME.toml",
    "model": "pip install . && rps-bench verify NAME",
    "study": "python MODULE.py",
    "paper": "rps-bench table --case-file NAME",
}
"""By kind: what to run then."""
_NAME = re.compile(r"[a-z][a-z0-9-]*")


def written(kind: str, name: str) -> tuple[dict[str, str], str]:
    """Return the files of a template of `kind` called `name`, and what to run then.

    Raises `InputError` for another kind, or a name that is not lower-case letters, digits, hyphens.
    """
    if kind not in FILES:
        raise InputError("kind", kind, f"one of {', '.join(FILES)}")
    if not _NAME.fullmatch(name):
        raise InputError("name", name, "lower-case letters, digits and hyphens, as in my-robot")
    words = {
        "NAME": name,
        "MODULE": name.replace("-", "_"),
        "Lumped": "".join(word.capitalize() for word in name.split("-")),
    }
    if kind == "model":
        words |= {'"lumped"': f'"{name}"', "lumped =": f"{name} =", "lumped": words["MODULE"]}
    folder = files("harness") / "new"
    made = {
        _filled(file, words): _filled((folder / f"{source}.txt").read_text("utf-8"), words)
        for file, source in FILES[kind].items()
    }
    return made, _filled(NEXT[kind], words)


def _filled(text: str, words: dict[str, str]) -> str:
    for word, value in words.items():
        text = text.replace(word, value)
    return text
