"""Tests take programs away and bring them back: what can run is asked anew in every one."""

from collections.abc import Iterator

import pytest

from reference_models import catalogue


@pytest.fixture(autouse=True)
def nothing_known() -> Iterator[None]:
    for known in (catalogue._info, catalogue._built):
        known.cache_clear()
    yield
    for known in (catalogue._info, catalogue._built):
        known.cache_clear()
