"""Parameters of a test of which some run in CI and the rest with the long tests."""

from collections.abc import Iterable
from typing import Any

import pytest


def long_but(every: Iterable[Any], *kept: Any) -> list[Any]:
    """All values of one parameter; those that are not kept are marked long."""
    return [one if one in kept else pytest.param(one, marks=pytest.mark.long) for one in every]
