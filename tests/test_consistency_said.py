"""Claim: what is said of every golden result changes only on purpose.

Reports, what `check --json` prints and the words of pictures are held against `tests/snapshots/`;
`make accept-snapshots` renews them.
"""

import pytest
from snapshots.said import GOLDEN, HERE, NAMES, PARTS

#: of the rest the pictures are drawn by `make test-long`
DRAWN = ("absorber", "compressor_impact", "engine_damped", "generator", "roll_mounted")


def _held(name: str, ending: str) -> None:
    kept = (HERE / f"{name}{ending}").read_text(encoding="utf-8")
    assert PARTS[ending](name) == kept


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("ending", [".txt", ".check.json"])
def test_reports_and_checks_are_as_before(name: str, ending: str) -> None:
    _held(name, ending)


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=() if one in DRAWN else pytest.mark.long) for one in NAMES]
)
def test_words_of_pictures_are_as_before(name: str) -> None:
    _held(name, ".pictures.txt")


def test_every_golden_file_has_its_snapshots_and_nothing_else_has() -> None:
    found = {path.name for path in HERE.iterdir() if path.suffix in (".txt", ".json")}
    assert found == {f"{name}{ending}" for name in NAMES for ending in PARTS}
    assert GOLDEN.is_dir()
    said = (HERE / "generator.pictures.txt").read_text(encoding="utf-8")
    assert "speed" in said and "run_up" in said
