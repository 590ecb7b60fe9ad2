"""Claim: readings that say nothing, too little or nonsense are refused in words, at their place."""

from pathlib import Path

import pytest
from plate_cases import ON_A_LINE, PLATE, problems, replaced, run
from refused import changed, refusals, said_of

from vibecalc.errors import NumericalFailure

CASES = {"plate": PLATE, "line": ON_A_LINE}


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("plate"))
def test_words_and_place(
    case: str, change: str, place: str, words: list[str], tmp_path: Path
) -> None:
    found = problems(tmp_path, changed(CASES[case], change))
    assert found, "nothing found wrong"
    for expected in words:
        assert expected in said_of(found[0])
    assert place in ("-", ".".join(map(str, found[0].path)))


@pytest.mark.parametrize("direction", ["x = 0.2", "oblique"])
def test_which_motion_a_line_of_points_hides(tmp_path: Path, direction: str) -> None:
    if direction == "oblique":
        points, words = [(0.0, 0.1), (0.3, 0.4), (0.5, 0.6)], "0.707 of roll with 0.707 of pitch"
    else:
        points, words = [(0.2, -0.4), (0.2, 0.1), (0.2, 0.3)], "pitch about the line x = 0.2 m"
    text = ON_A_LINE
    for name, (x, y) in zip("abc", points, strict=True):
        start = text.index(f'{{ name = "{name}"')
        end = text.index("}", start) + 1
        text = f'{text[:start]}{{ name = "{name}", x = {x}, y = {y} }}{text[end:]}'
    (problem,) = problems(tmp_path, text)
    assert words in problem.message


def test_a_reading_of_the_roll_mends_the_line(tmp_path: Path) -> None:
    text = replaced(
        "readings = [",
        'angular_step = 0.01\nreadings = [\n  { about = "x", angular_amplitude = [2.0], '
        'phase = ["30 deg"] },',
        ON_A_LINE,
    )
    record = run(tmp_path, text)
    assert abs(record["measurement/roll"].values[0]) == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize(
    ("content", "path", "words"),
    [
        ("order, x, y\n1, 0, 0\n", "scan", "has neither level nor amplitude"),
        (
            "order, x, y, level, amplitude\n1, 0, 0, 90, 1\n",
            "scan.amplitude",
            "amplitude and level are mutually exclusive",
        ),
        ("order, x, y, level\n4, 0, 0, 90\n", "scan.order.0", "of no harmonic"),
        (
            "order, x, y, amplitude, phase\n1, 0, 0, -1, 0\n",
            "scan.amplitude.0",
            "not negative",
        ),
        ("order, x, y, amplitude\n1, 0, 0, 0\n", "scan.amplitude.0", "larger than zero"),
    ],
)
def test_scans(tmp_path: Path, content: str, path: str, words: str) -> None:
    text = PLATE[: PLATE.index("readings")] + 'scan = "scan.csv"\n'
    (first, *_) = problems(tmp_path, text, scan=content)
    assert words in first.message
    assert ".".join(map(str, first.path)) == f"measurement.{path}"


def test_a_frequency_nearby_a_speed(tmp_path: Path) -> None:
    """A plate is measured next to a machine too; then the crankshaft tells the frequency."""
    machine = """speed = "900 rpm"
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.2
reciprocating_mass = 1.0
cylinders = [{ name = "1" }]
"""
    text = replaced('kind = "plate"\n', 'kind = "machine"\n' + machine)
    assert problems(tmp_path, text) == []
    record = run(tmp_path, text)
    assert record["measurement/frequency"].values[1] == pytest.approx(2.0 * 94.2477796, rel=1e-8)
    twice = replaced("orders =", 'base_frequency = "15 Hz"\norders =', text)
    (problem,) = problems(tmp_path, twice)
    assert problem.path == ("measurement", "base_frequency") and "is given twice" in problem.message


def test_contradicting_levels_are_a_failure_with_their_size(tmp_path: Path) -> None:
    text = replaced("[108.7, 104.2]", "[118.7, 104.2]")
    with pytest.raises(NumericalFailure, match=r"harmonic 1: .*off by \d+\.?\d* dB or more"):
        run(tmp_path, text)


def test_a_phase_against_a_point_that_stands_still(tmp_path: Path) -> None:
    text = replaced("phase_step", 'reference_position = "b"\nphase_step', ON_A_LINE)
    text = replaced('"b", amplitude = [1.1]', '"b", amplitude = [0.0]', text)
    text = replaced('[1.0], phase = ["0', '[0.6], phase = ["180', text)
    text = replaced('amplitude = [1.2], phase = ["9', 'amplitude = [0.4], phase = ["0', text)
    fourth = '{ at = "d", amplitude = [1.0], phase = [0.0] },'
    text = replaced("readings = [", f"readings = [\n  {fourth}", text)
    with pytest.raises(NumericalFailure, match="the signal that phases refer to is zero"):
        run(tmp_path, text)
