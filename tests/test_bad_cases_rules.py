"""Claim: rules are read as written, and all that is wrong with a rules file is said at once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sample_results import MODE, ORDER, quantity, result_of

from vibecalc.core.results.compare import compare
from vibecalc.core.results.compare_rules import (
    CURVE_RTOL,
    DEFAULT,
    KINDS,
    Rule,
    Rules,
    completed,
    read_rules,
)
from vibecalc.errors import UsageError


def write(folder: Path, text: str) -> Path:
    path = folder / "rules.toml"
    path.write_text(text, encoding="utf-8")
    return path


def problems(folder: Path, text: str) -> list[str]:
    with pytest.raises(UsageError) as caught:
        read_rules(write(folder, text))
    return str(caught.value).splitlines()


def test_later_rules_win_key_by_key(tmp_path: Path) -> None:
    rules = read_rules(
        write(
            tmp_path,
            "[default]\nrtol = 1e-5\nnan_equal = true\n"
            '[[rule]]\nquantity = "isolation/*"\nrtol = 1e-3\natol = "1 mm"\n'
            '[[rule]]\nquantity = "isolation/sag"\natol = 0.5\ncompare = "vector"\n',
        )
    )
    assert rules.given("excitation/force").rtol == 1e-5
    assert rules.given("isolation/pitch/angle") == Rule(
        quantity="isolation/pitch/angle", rtol=1e-3, atol="1 mm", nan_equal=True
    )
    assert rules.given("isolation/sag") == Rule(
        quantity="isolation/sag", rtol=1e-3, atol=0.5, nan_equal=True, compare="vector"
    )


def test_defaults_are_filled_in_by_kind() -> None:
    silent = Rules().given("a/b")
    assert completed(silent, "value").rtol == DEFAULT.rtol == 1e-7
    assert completed(silent, "curve").rtol == CURVE_RTOL == 1e-4
    spoken = Rules(default=Rule(rtol=1e-3)).given("a/b")
    assert completed(spoken, "curve").rtol == completed(spoken, "value").rtol == 1e-3


def test_a_tolerance_with_a_unit_counts_in_the_unit_of_the_quantity(tmp_path: Path) -> None:
    rules = read_rules(write(tmp_path, '[[rule]]\nquantity = "a/b"\natol = "2 mm"\n'))
    one = replace(quantity("a/b"), values=np.array(1.0), unit="m", error_estimate=0.0)
    for step, same in ((0.0019, True), (0.0021, False)):
        other = replace(one, values=np.array(1.0 + step))
        assert compare(result_of(one), result_of(other), rules).same == same
    force = replace(one, unit="N")
    with pytest.raises(UsageError, match="atol = '2 mm' does not fit a/b"):
        compare(result_of(force), result_of(force), rules)


def test_all_problems_are_shown_at_once(tmp_path: Path) -> None:
    lines = problems(
        tmp_path,
        "[defaults]\n"
        "[default]\nrotl = 1e-3\ncompare = 'value'\n"
        "[[rule]]\nrtol = -1.0\natol = 'about 1 N'\n"
        "[[rule]]\nquantity = 3\ncompare = 'mode_shapes'\nnan_equal = 1\n"
        "[[rule]]\nquantity = 'a'\nrtol = nan\nrelative_to = 'hole'\nfloor = true\natol = '-1 N'\n",
    )
    assert lines[0] == f"13 problems in the rules file {tmp_path / 'rules.toml'}:"
    for line, words in zip(
        lines[1:],
        (
            "unknown table [defaults]; known are default, rule",
            "[default]: unknown key `rotl`; known are rtol, atol",
            "[default]: unknown key `compare`; known are",
            '[[rule]] 1: `quantity` is missing, as in quantity = "isolation/*"',
            "[[rule]] 1: rtol = -1.0: has to be a number, zero or more",
            "[[rule]] 1: atol = 'about 1 N': has to be a number, zero or more, also with a unit",
            "[[rule]] 2: quantity = 3: has to be a path or pattern",
            "[[rule]] 2: compare = 'mode_shapes': has to be one of value, vector",
            "[[rule]] 2: nan_equal = 1: has to be true or false",
            "[[rule]] 3: rtol = nan: has to be a number, zero or more",
            "[[rule]] 3: relative_to = 'hole': has to be one of whole",
            "[[rule]] 3: floor = True: has to be a number, zero or more",
            "[[rule]] 3: atol = '-1 N': has to be a number, zero or more",
        ),
        strict=True,
    ):
        assert line.strip().startswith(words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("rule = 3\n", "`rule` has to be a list of tables: write [[rule]]"),
        ("[rule]\nquantity = 'a'\n", "`rule` has to be a list of tables: write [[rule]]"),
        ("default = 3\n", "`default` has to be a table: write [default]"),
    ],
)
def test_tables_of_the_wrong_form(tmp_path: Path, text: str, words: str) -> None:
    assert [line.strip() for line in problems(tmp_path, text)[1:]] == [words]


def test_files_that_are_no_rules(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is not a TOML file"):
        read_rules(write(tmp_path, "rtol = = 3"))
    with pytest.raises(UsageError, match=r"the rules file .* does not exist"):
        read_rules(tmp_path / "absent.toml")
    with pytest.raises(UsageError, match=r"the rules file .* is a folder"):
        read_rules(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\x89HDF\xff")
    with pytest.raises(UsageError, match=r"not text in UTF-8 \(line 1\)"):
        read_rules(tmp_path / "binary.toml")


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_kind_compares_or_says_why_not(kind: str) -> None:
    rules = Rules(rules=(Rule(quantity="*", compare=kind),))
    for axes in ((), (ORDER,), (MODE, ORDER)):
        one = result_of(quantity("a/b", axes, is_complex=True))
        if kind in ("spectrum", "mode_shape") and axes != (MODE, ORDER):
            with pytest.raises(UsageError, match=r"does not fit a/b: it needs an axis `mode`"):
                compare(one, one, rules)
        elif kind == "curve" and not axes:
            with pytest.raises(UsageError, match=r"does not fit a/b: it needs a numeric axis"):
                compare(one, one, rules)
        else:
            comparison = compare(one, one, rules)
            assert comparison.same
            assert len(comparison.rows) == (kind != "ignore")
