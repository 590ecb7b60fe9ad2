"""Claim: readings that say nothing, too little or nonsense are refused in words, at their place."""

from pathlib import Path

import pytest
from plate_cases import PLATE, load, problems, replaced, run
from plate_refusals import CASES, ON_A_LINE, M

from vibecalc.core.run.stage import Scene
from vibecalc.errors import CaseError, NumericalFailure

FOLDER = Path(__file__).parent / "bad_cases"


@pytest.mark.parametrize("name", sorted(CASES))
def test_words_and_place(tmp_path: Path, name: str) -> None:
    text, path, words = CASES[name]
    found = problems(tmp_path, text)
    assert found, "nothing found wrong"
    first = found[0]
    said = " ".join([first.message, first.found, first.allowed, first.hint])
    for expected in words:
        assert expected in said
    assert first.path == path


def test_the_plain_case_is_fine(tmp_path: Path) -> None:
    assert problems(tmp_path, PLATE) == []


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
    ("text", "words"),
    [
        (replaced('amplitude = "zero_to_peak"\n', ""), "missing key 'amplitude'"),
        (replaced("zero_to_peak", "peak_to_peak"), "one of 'zero_to_peak', 'rms'"),
        (replaced('at = "a"', 'att = "a"'), "did you mean 'at'?"),
        (replaced("[104.0, 107.3]", '["104 mm", 107.3]'), "wrong dimension"),
        (replaced("[104.0, 107.3]", "[nan, 107.3]"), "not finite"),
        (replaced("1e-5 m/s^2", "0 m/s^2"), "out of range"),
        (replaced("orders = [1, 2]", "orders = [1.5, 2]"), "whole number"),
        (replaced("orders = [1, 2]", "orders = []"), "orders is empty"),
        (
            replaced('{ at = "a",', '{ at = "a", use = "guess",'),
            "one of 'solve', 'choose', 'compare'",
        ),
    ],
)
def test_form(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        load(tmp_path, text)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("content", "path", "words"),
    [
        ("order, x, y\n1, 0, 0\n", (*M, "scan"), "has neither level nor amplitude"),
        (
            "order, x, y, level, amplitude\n1, 0, 0, 90, 1\n",
            (*M, "scan", "amplitude"),
            "amplitude and level exclude each other",
        ),
        ("order, x, y, level\n4, 0, 0, 90\n", (*M, "scan", "order", 0), "of no harmonic"),
        (
            "order, x, y, amplitude, phase\n1, 0, 0, -1, 0\n",
            (*M, "scan", "amplitude", 0),
            "not negative",
        ),
        ("order, x, y, amplitude\n1, 0, 0, 0\n", (*M, "scan", "amplitude", 0), "larger than zero"),
    ],
)
def test_scans(tmp_path: Path, content: str, path: tuple[str, ...], words: str) -> None:
    text = PLATE[: PLATE.index("readings")] + 'scan = "scan.csv"\n'
    (first, *_) = problems(tmp_path, text, scan=content)
    assert words in first.message
    assert first.path == path


def test_a_frequency_nearby_a_speed(tmp_path: Path) -> None:
    """A plate is measured next to a machine too; then the crankshaft tells the frequency."""
    machine = """speed = "900 rpm"
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.2
reciprocating_mass = 1.0
cylinders = [{ name = "1" }]
"""
    text = replaced('kind = "plate"\n', 'kind = "generator"\n' + machine)
    assert problems(tmp_path, text) == []
    record = run(tmp_path, text)
    assert record["measurement/frequency"].values[1] == pytest.approx(2.0 * 94.2477796, rel=1e-8)
    twice = replaced("orders =", 'base_frequency = "15 Hz"\norders =', text)
    (problem,) = problems(tmp_path, twice)
    assert problem.path == (*M, "base_frequency") and "stands twice" in problem.message


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


def test_the_stage_says_what_it_needs() -> None:
    from types import SimpleNamespace

    from vibecalc.measurement import adapter as measurement

    scene: Scene = SimpleNamespace(case=SimpleNamespace(measurement=None))  # type: ignore[assignment]
    with pytest.raises(ValueError, match=r"no \[measurement\]"):
        measurement.run_measurement(scene)
