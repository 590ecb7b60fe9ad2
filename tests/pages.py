"""What every page of the documents promises."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Row(NamedTuple):
    """One printed number; None where there is no such value."""

    place: str
    printed: str
    right: float | None
    source: float | None
    verdict: str
    reason: str = ""


def assert_named_exist(page: str, least: int = 20) -> None:
    """The tests and files that `page` names exist; at least so many tests are named."""
    written = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py"))
    named = set(re.findall(r"`(test_\w+)`", page))
    assert len(named) > least
    assert not {name for name in named if f"def {name}(" not in written}
    for path in re.findall(r"`((?:tests|cases)/[\w/.]+)`", page):
        assert (ROOT / path).exists(), path
