"""The fixture `verify_model` for the tests of anybody's model; pytest finds it by itself."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from harness.verify import Verified


@pytest.fixture(scope="session")
def verify_model() -> Iterator[Callable[[str], "Verified"]]:
    """Yield a function: `verify_model("mine")` fails the test with a sentence for each fault."""
    from harness.bench import Bench
    from harness.verify import verify

    with Bench() as bench:

        def check(name: str) -> "Verified":
            found = verify(name, bench)
            said = "\n".join(f"- {what}: {why}" for what, why in found.failures().items())
            if said:
                pytest.fail(f"{found.sentences()[0]}\n{said}", pytrace=False)
            return found

        yield check
