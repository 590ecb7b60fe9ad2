"""Claim: a [[find]] that cannot be meant is refused at its line before any run, and one that has no
solution ends in exit code 3 with what was seen.
"""

import math
from pathlib import Path

import pytest
from find_samples import (
    ARMS,
    DAMPING,
    FORCE,
    FREQUENCY,
    HEAD,
    INERTIA,
    PHASE,
    RADIUS,
    RIGID,
    ROD,
    STIFFNESS,
    row,
    undamped,
)
from fuzzing import Outcome, command
from refused import changed, refusals

from vibecalc.core.report.text import as_json, render_report
from vibecalc.core.report.verdicts import judge_references, misses
from vibecalc.core.results.store import read_result
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.errors import EXIT_NUMERICAL, EXIT_USAGE

GOOD = row("one", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'target = "10 Hz"')


def checked(folder: Path, *rows: str, head: str = HEAD, verb: str = "check") -> Outcome:
    path = folder / "one.toml"
    path.write_text(head + "".join(rows), encoding="utf-8")
    more = ("-q", "-o", str(folder / "one.h5")) if verb == "run" else ()
    return command(verb, str(path), *more, cap=60)


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("find"))
def test_words(tmp_path: Path, case: str, change: str, place: str, words: list[str]) -> None:
    outcome = checked(tmp_path, changed(GOOD, change))
    assert outcome.code == EXIT_USAGE
    assert words[0] in " ".join(outcome.err.split()), outcome.err
    assert "one.toml:" in outcome.err and "1 error in" in outcome.err, outcome.err


ZERO = row("one", PHASE, "-1 rad", "1 rad", RIGID, f'scaled_with = ["{RADIUS}"]', 'target = "1 N"')
FIRST = PHASE.replace("[1]", "[0]")
BELOW = row("one", FIRST, "-1 rad", "1 rad", RIGID, f'scaled_with = ["{ROD}"]', "target = 1")
LISTED = HEAD.replace('stiffness = "10000 N/m"', "stiffness = [10000, 10000, 10000]")
STUDY = f"""
[optimisation]
variables = [{{ key = "{DAMPING}", min = 1, max = 100 }}]
objective = {{ quantity = "{FORCE}" }}
"""


@pytest.mark.parametrize(
    ("head", "rows", "words"),
    [
        (HEAD, [ZERO], "ratio of one that is zero as written"),
        (HEAD, [BELOW], f"between the bounds {ROD} would take a value outside its range"),
        (LISTED, [GOOD], f"{STIFFNESS} is a list here"),
        (HEAD, [GOOD, GOOD], "two searches are named 'one'"),
        (HEAD, [STUDY, GOOD], "a case with [optimisation] cannot have [[find]], too"),
    ],
    ids=["zero", "below", "a list", "one name", "optimisation"],
)
def test_searches_that_do_not_fit(tmp_path: Path, head: str, rows: list[str], words: str) -> None:
    outcome = checked(tmp_path, *rows, head=head)
    assert outcome.code == EXIT_USAGE and words in " ".join(outcome.err.split())


@pytest.mark.parametrize("what", ["find = 3\n", "find = [1, 2]\n", "find = {}\n", "find = [{}]\n"])
def test_what_is_no_list_of_tables(tmp_path: Path, what: str) -> None:
    outcome = checked(tmp_path, head=what + HEAD)
    assert outcome.code == EXIT_USAGE and "Traceback" not in outcome.err


def test_references_know_what_is_found(tmp_path: Path) -> None:
    reference = '\n[[reference]]\nquantity = "find/{}"\nvalue = "{}"\nsource = "a page"\n'
    assert checked(tmp_path, GOOD, reference.format("one/value", "39 N/mm")).code == 0
    for path, value, words in (
        ("two/value", "39 N/mm", "did you mean 'find/one/value'?"),
        ("one/valeu", "39 N/mm", "did you mean 'find/one/value'?"),
        ("one/value", "39 mm", "does not fit find/one/value"),
    ):
        outcome = checked(tmp_path, GOOD, reference.format(path, value))
        assert outcome.code == EXIT_USAGE and words in outcome.err, outcome.err


NONE = row("thirty", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'target = "30 Hz"')
RESONANT = undamped().replace('"500 rad/s"', repr((ARMS * 1e4 / INERTIA) ** 0.5))


@pytest.mark.parametrize(
    ("head", "rows", "words"),
    [
        (
            HEAD,
            [
                NONE,
                row("bound", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'sense = "min"'),
                row("same", DAMPING, "1", "100", FREQUENCY, 'target = "10 Hz"'),
            ],
            (
                "find 'thirty': no machine.mounts.each.stiffness between 1000 N/m and 100000 N/m",
                "= 188.496 rad/s: minimum 10.0",
                "nearest at 100000 N/m with 100.3",
                "find 'bound': no minimum of isolation/pitch/natural_frequency",
                "is at the bound 1000 N/m",
                "find 'same': isolation/pitch/natural_frequency does not change between",
            ),
        ),
        (
            HEAD,
            [row("rod", ROD, "10 mm", "59 mm", RIGID, 'target = "1 kN"')],
            ("none of 33 points could be computed", "connecting rod must be longer than the crank"),
        ),
        (
            HEAD,
            [row("rod", ROD, "10 mm", "100 mm", RIGID, 'target = "1 N"')],
            ("points could not be computed, between 0.01 m and 0.0", "rod must be longer"),
        ),
        (
            RESONANT,
            [row("k", STIFFNESS, "5000", "50000", FORCE, 'change = "-10 N"')],
            ("undamped natural frequency",),
        ),
    ],
    ids=["nothing found", "no machine", "few machines", "fails as written"],
)
def test_searches_without_a_solution(
    tmp_path: Path, head: str, rows: list[str], words: tuple[str, ...]
) -> None:
    """All searches that fail are reported at once, and no file is written."""
    outcome = checked(tmp_path, *rows, head=head, verb="run")
    assert outcome.code == EXIT_NUMERICAL and not (tmp_path / "one.h5").exists()
    text = " ".join(outcome.err.split())
    for expected in words:
        assert expected in text


REFERENCE = '\n[[reference]]\nquantity = "find/{}/value"\nvalue = "{}"\nsource = "here"\n'
LIMIT = '\n[[limit]]\nquantity = "find/thirty/value"\nmax = "1 N/mm"\nsource = "here"\n'


def test_what_the_others_found_is_kept_and_the_rest_missed(tmp_path: Path) -> None:
    rows = REFERENCE.format("one", "37.3 N/mm") + REFERENCE.format("thirty", "400 N/mm")
    more = rows + LIMIT + LIMIT + 'expect = "broken"\n'
    outcome = checked(tmp_path, GOOD, NONE, more, verb="run")
    assert outcome.code == 0, outcome.err
    result = read_result(tmp_path / "one.h5")
    exact = INERTIA * (20.0 * math.pi) ** 2 / ARMS
    assert float(result.record["find/one/value"].values) == pytest.approx(exact, rel=1e-5)
    assert not any(path.startswith("find/thirty/") for path in result.record)
    (words,) = [text for text in result.record.warnings if "find 'thirty'" in text]
    assert "nearest at 100000 N/m" in words
    references, limits = judge_references(result), verdicts_of(result)
    assert [row.within for row in references][1:] == [False]
    assert [limit.satisfied for limit in limits if "thirty" in limit.quantity] == [False, False]
    reported = [line for line in misses(references, limits) if "thirty" in line]
    assert len(reported) == 3 and all("nothing found" in line for line in reported)
    assert "no solution for thirty: see the warnings" in render_report(result)
    assert as_json(result)["references"][1]["computed"] is None
    outcome = checked(tmp_path, GOOD, NONE, rows, verb="verify")
    assert outcome.code == 1 and "find/thirty/value" in outcome.err + outcome.out
