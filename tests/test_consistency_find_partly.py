"""Claim: a [[find]] that finds nothing does not take what the others found with it."""

from pathlib import Path

from find_samples import ARMS, FREQUENCY, HEAD, INERTIA, STIFFNESS, row
from fuzzing import Outcome, command

from vibecalc.core.report.text import as_json, render_report
from vibecalc.core.report.verdicts import judge_limits, judge_references, misses
from vibecalc.core.results.store import read_result

GOOD = row("ten", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'target = "10 Hz"')
NONE = row("thirty", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'target = "30 Hz"')
REFERENCE = '\n[[reference]]\nquantity = "find/{}/value"\nvalue = "{}"\nsource = "here"\n'
LIMIT = '\n[[limit]]\nquantity = "find/thirty/value"\nmax = "1 N/mm"\nsource = "here"\n'


def done(folder: Path, text: str, verb: str) -> Outcome:
    path = folder / "one.toml"
    path.write_text(HEAD + GOOD + NONE + text, encoding="utf-8")
    more = ("-q", "-o", str(folder / "one.h5")) if verb == "run" else ()
    return command(verb, str(path), *more, cap=60)


def test_what_was_found_is_kept_and_the_failure_said(tmp_path: Path) -> None:
    outcome = done(tmp_path, "", "run")
    assert outcome.code == 0, outcome.err
    result = read_result(tmp_path / "one.h5")
    exact = INERTIA * (20.0 * 3.141592653589793) ** 2 / ARMS
    assert abs(float(result.record["find/ten/value"].values) - exact) < 1e-5 * exact
    assert not any(path.startswith("find/thirty/") for path in result.record)
    (words,) = [text for text in result.record.warnings if "find 'thirty'" in text]
    assert "between 1000 N/m and 100000 N/m brings" in words and "nearest at 100000 N/m" in words
    text = render_report(result)
    assert "nothing found for thirty: see the warnings" in text


def test_references_and_limits_on_what_is_missing_are_missed(tmp_path: Path) -> None:
    rows = REFERENCE.format("ten", "37.3 N/mm") + REFERENCE.format("thirty", "400 N/mm")
    broken = LIMIT + 'expect = "broken"\n'
    assert done(tmp_path, rows + LIMIT + broken, "run").code == 0
    result = read_result(tmp_path / "one.h5")
    references, limits = judge_references(result), judge_limits(result)
    assert [row.within for row in references][1:] == [False]
    assert [limit.satisfied for limit in limits if "thirty" in limit.quantity] == [False, False]
    reported = [line for line in misses(references, limits) if "thirty" in line]
    assert len(reported) == 3 and all("nothing found" in line for line in reported)
    render_report(result)
    assert as_json(result)["references"][1]["computed"] is None
    outcome = done(tmp_path, rows, "verify")
    assert outcome.code == 1 and "find/thirty/value" in outcome.err + outcome.out
