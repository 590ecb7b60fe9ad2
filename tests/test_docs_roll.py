"""Claim: docs/validation_roll.md shows what the source prints and what is right, to each digit."""

import re
from collections import Counter

import numpy as np
import pytest
from herold_simulation import open_tables, simulate
from pages import assert_named_exist
from published.test_published_roll import LEVELS, disturbance, prints, reduced
from published.test_published_roll import best_estimate as program
from roll_machines import source_drive, source_machine
from roll_page import RIGHT_LOAD, SECTIONS, best_estimate, changed, running_numbers
from shipped_cases import ROOT
from test_docs import rows, shows

from vibecalc.roll.turn import level

PAGE = (ROOT / "docs" / "validation_roll.md").read_text(encoding="utf-8")
#: running words without the line breaks
WORDS = " ".join(PAGE.split())
VERDICTS = ("reproduced", "with the slip", "misprint", "compatible", "not reproducible")
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?: \S+)*$")
#: columns whose numbers are ours; those with printed ones
OURS = ("computed", "as the source", "double precision", "needed", "change", "printed less")
PRINTED = ("printed", "lag", "equal forces", "harmonic 1", "harmonic 2", "speed")
#: numbers of rows that are said in words, or follow from a test in tests/published/
WORDED = {
    "6.3, steps for 1 % of the period",
    "6.3, levels with a period 1 % off",
    "6.5, drift of the momentum",
}


def tables(number: int) -> list[list[list[str]]]:
    """All tables of a section."""
    body = PAGE.split(f"\n## {number}. ")[1].split("\n## ")[0]
    return [found for block in body.split("\n\n") if (found := rows(block))]


def first(cell: str) -> str:
    """The number of a cell, which a unit may follow."""
    return cell.split(" ")[0].lower()


@pytest.mark.parametrize("number", SECTIONS)
def test_numbers(number: int) -> None:
    values = SECTIONS[number]()
    seen = set()
    for head, _, *cells in tables(number):
        label = head.index("quantity") if "quantity" in head else 0
        ours = [i for i, name in enumerate(head) if i and name.startswith(OURS)]
        for row in cells:
            shown = [row[i] for i in ours if NUMBER.match(row[i])]
            key = row[label] or row[0]
            if not shown or key in WORDED:
                continue
            seen.add(key)
            for cell, value in zip(shown, values[key], strict=True):
                assert shows(first(cell).lstrip("+"), value), f"{key}: {cell}, computed {value!r}"
    assert seen == set(values)


@pytest.mark.parametrize("number", [3, 4, 5, 7])
def test_verdicts(number: int) -> None:
    """Reproduced where the right number rounds to what is printed, else with the slip."""
    for head, _, *cells in tables(number):
        for place in (i for i, name in enumerate(head) if name == "verdict"):
            before = head[:place]
            start = max((i for i, name in enumerate(before) if name in PRINTED), default=None)
            assert start is not None
            right = max(i for i, name in enumerate(before) if name.startswith("computed"))
            by_source = [i for i in range(start, place) if head[i] == "as the source"]
            for row in cells:
                verdict, printed, own = row[place], first(row[start]), first(row[right])
                if by_source and verdict == "with the slip":
                    assert prints(printed, float(first(row[by_source[0]]))), row
                elif verdict == "reproduced" and NUMBER.match(row[right]):
                    assert prints(printed, float(own)), row
                elif verdict in ("with the slip", "not reproducible"):
                    assert not prints(printed, float(own)), row


def test_summary_counts_the_verdicts() -> None:
    summary = rows(PAGE)[2 : 2 + len(SECTIONS)]
    for number, (title, printed, *counts) in enumerate(summary, start=1):
        found: Counter[str] = Counter()
        for head, _, *cells in tables(number):
            places = [i for i, name in enumerate(head) if name == "verdict"]
            found += Counter(row[i] for row in cells for i in places if row[i])
        assert title.startswith(f"{number}. ") and set(found) <= set(VERDICTS)
        assert int(printed) == found.total()
        assert [int(cell or 0) for cell in counts] == [found[verdict] for verdict in VERDICTS]


def test_words() -> None:
    apart = LEVELS - level(best_estimate())
    linear = LEVELS - reduced(203.4)
    single = program(single=True).level[7]
    for words, value in (
        (r"off by up to (\S+) dB \(order 7\)", np.max(np.abs(apart))),
        (r"order 8, is (\S+) and lacks", single),
        (r"and lacks (\S+) dB", -20.05 - single),
        (r"by up to (\S+) n rad", 2.0 * np.pi * 0.0005 * running_numbers()["frequency"]),
        (r"harmonics 3 and 7 are (\S+) and", linear[2]),
        (r"harmonics 3 and 7 are \S+ and (\S+) dB low", linear[6]),
        (r"that do not close (\S+) ", disturbance(92.76)[0].real),
        (r"with 0.3 kg m\^2 it is (\S+) and", changed(1, rotor_inertia=[0.3])),
        (r"and order 2 is (\S+) dB", changed(2, rotor_inertia=[0.3])),
        (r'"computed" with (\S+) and', RIGHT_LOAD[0]),
    ):
        found = re.search(words, WORDS)
        assert found is not None, words
        assert shows(found[1], float(value)), words
    for harmonic, load in enumerate(RIGHT_LOAD, start=1):
        assert running_numbers()[f"d, harmonic {harmonic}"] == pytest.approx(load, abs=1e-3)


@pytest.mark.long
def test_shorter_steps_lead_to_the_computed_levels() -> None:
    """Two thousandths of his step: what remains is mostly the first interval of the gas tables."""
    fine = simulate(source_machine(), open_tables(source_drive()), step=1e-5)
    assert "comes within 0.08 dB" in WORDS
    assert np.max(np.abs(fine.level - level(best_estimate()))) < 0.08


def test_the_tests_that_are_named_exist() -> None:
    assert_named_exist(PAGE, least=15)
