"""Claim: a [[find]] that cannot be meant is refused at its line before any run, and one that has no
solution ends in exit code 3 with what was seen.
"""

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

from vibecalc.errors import EXIT_NUMERICAL, EXIT_USAGE

GOOD = row("one", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'target = "10 Hz"')


def checked(folder: Path, *rows: str, head: str = HEAD, verb: str = "check") -> Outcome:
    path = folder / "one.toml"
    path.write_text(head + "".join(rows), encoding="utf-8")
    more = ("-q", "-o", str(folder / "one.h5")) if verb == "run" else ()
    return command(verb, str(path), *more, cap=60)


def test_a_good_one_is_accepted(tmp_path: Path) -> None:
    outcome = checked(tmp_path, GOOD)
    assert outcome.code == 0, outcome.err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"one"', '"rod length"', "found 'rod length'; allowed: letters, digits and _"),
        ('"one"', '"a/b"', "a name that cannot stand in a result path"),
        ('"one"', '""', "name is empty"),
        ("stiffness", "stifness", "did you mean 'stiffness'?"),
        (STIFFNESS, "machine.mounts.each", "not a continuous number"),
        (STIFFNESS, "machine.kind", "not a continuous number"),
        (STIFFNESS, "limit[0].max", "only keys below machine, excitation, response, isolation"),
        (STIFFNESS, "a key", "not a key"),
        (STIFFNESS, "machine.motor.torque.cosine[0]", "machine has no key 'motor'"),
        (STIFFNESS, "machine.crank_train.cylinders[7].crank_phase", "[0] to [2], so no [7]"),
        ('"1 N/mm"', '"1 kg"', "found '1 kg', a mass"),
        ('"1 N/mm"', '"-1 N/mm"', "lower is a value that machine.mounts.each.stiffness must not"),
        ('"1 N/mm"', '"100 N/mm"', "lower < upper"),
        ('"1 N/mm"', "nan", "lower is not finite"),
        ('"1 N/mm"', '"nan N/mm"', "not finite"),
        ('"100 N/mm"', '"1e400 N/mm"', "too large for a double"),
        (FREQUENCY, "isolation/pitch/natural_freqency", f"did you mean '{FREQUENCY}'?"),
        (FREQUENCY, "excitation/residual", "no table of this case asks for it"),
        (FREQUENCY, "find/one/value", "this case does not compute such a quantity"),
        ('target = "10 Hz"', "", "has neither target nor change nor seek"),
        ('target = "10 Hz"', 'target = "10 N"', "does not fit isolation/pitch/natural_frequency"),
        ('target = "10 Hz"', "target = nan", "target is not finite"),
        ('target = "10 Hz"', 'change = "1 mm"', "found 1 mm"),
        ('target = "10 Hz"', 'target = 1\nchange = "1 Hz"', "change and target exclude each other"),
        ('target = "10 Hz"', 'target = 1\nseek = "minimum"', "seek and target exclude each other"),
        ('target = "10 Hz"', 'seek = "least"', "one of 'minimum', 'maximum'"),
        ('target = "10 Hz"', "target = 1\npoints = 2", "points is out of range"),
        ('target = "10 Hz"', "target = 1\nwhere = { order = 1 }", "has no axis 'order'"),
        ('target = "10 Hz"', "target = 1\nalso = 'x'", "also cannot be a text"),
        ('target = "10 Hz"', f"target = 1\nalso = ['{STIFFNESS}']", "changed twice"),
        ('target = "10 Hz"', f"target = 1\nalso = ['{DAMPING}', '{DAMPING}']", "changed twice"),
        ('target = "10 Hz"', "target = 1\nalso = ['machine.sped']", "did you mean 'speed'?"),
        ('target = "10 Hz"', f"target = 1\nalso = ['{PHASE}']", "zero does not change"),
        ('target = "10 Hz"', "target = 1\nsearch = 3", "unknown key 'search'"),
    ],
)
def test_words(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in GOOD
    outcome = checked(tmp_path, GOOD.replace(old, new, 1))
    assert outcome.code == EXIT_USAGE
    assert words in " ".join(outcome.err.split()), outcome.err
    assert "one.toml:" in outcome.err and "1 error in" in outcome.err, outcome.err


def test_ratios(tmp_path: Path) -> None:
    zero = row("one", PHASE, "-1 rad", "1 rad", RIGID, f'also = ["{RADIUS}"]', 'target = "1 N"')
    assert "ratio of one that is zero as written" in checked(tmp_path, zero).err
    phase = "machine.crank_train.cylinders[0].crank_phase"
    below = row("one", phase, "-1 rad", "1 rad", RIGID, f'also = ["{ROD}"]', "target = 1")
    text = " ".join(checked(tmp_path, below).err.split())
    assert f"between the bounds {ROD} would take a value that it must not have" in text


def test_a_key_that_is_a_list(tmp_path: Path) -> None:
    head = HEAD.replace('stiffness = "10000 N/m"', "stiffness = [10000, 10000, 10000]")
    text = " ".join(checked(tmp_path, GOOD, head=head).err.split())
    assert f"{STIFFNESS} is a list here" in text and f"{STIFFNESS}[0]" in text


def test_two_searches_of_one_name_and_one_nearby_an_optimisation(tmp_path: Path) -> None:
    assert "two searches are named 'one'" in checked(tmp_path, GOOD, GOOD).err
    study = (
        f'\n[optimisation]\nvariables = [{{ key = "{DAMPING}", lower = 1, upper = 100 }}]\n'
        f'objective = {{ quantity = "{FORCE}" }}\n'
    )
    outcome = checked(tmp_path, study, GOOD)
    assert outcome.code == EXIT_USAGE
    assert "a case with [optimisation] cannot have [[find]], too" in outcome.err


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


def test_nothing_between_the_bounds(tmp_path: Path) -> None:
    """All searches that fail are reported at once, and no file is written."""
    none = GOOD.replace('"10 Hz"', '"30 Hz"')
    other = row("bound", STIFFNESS, "1 N/mm", "100 N/mm", FREQUENCY, 'seek = "minimum"')
    constant = row("same", DAMPING, 1, 100, FREQUENCY, 'target = "10 Hz"')
    outcome = checked(tmp_path, none, other, constant, verb="run")
    assert outcome.code == EXIT_NUMERICAL
    text = " ".join(outcome.err.split())
    assert "find 'one': no machine.mounts.each.stiffness between 1000 N/m and 100000 N/m" in text
    assert "to 188.496 rad/s: it goes from 10.0" in text
    assert "nearest at 100000 N/m with 100.3" in text
    assert "find 'bound': no minimum of isolation/pitch/natural_frequency" in text
    assert "is at the bound 1000 N/m" in text
    assert "find 'same': isolation/pitch/natural_frequency does not change between" in text
    assert not (tmp_path / "one.h5").exists()


def test_no_point_is_a_machine(tmp_path: Path) -> None:
    search = row("rod", ROD, "10 mm", "59 mm", RIGID, 'target = "1 kN"')
    outcome = checked(tmp_path, search, verb="run")
    assert outcome.code == EXIT_NUMERICAL
    text = " ".join(outcome.err.split())
    assert "none of 33 points could be computed" in text
    assert "connecting rod must be longer than the crank radius" in text


def test_what_cannot_be_computed_is_said_where_nothing_is_found(tmp_path: Path) -> None:
    search = row("rod", ROD, "10 mm", "100 mm", RIGID, 'target = "1 N"')
    text = " ".join(checked(tmp_path, search, verb="run").err.split())
    assert "points could not be computed, between 0.01 m and 0.0" in text
    assert "connecting rod must be longer" in text


def test_a_case_that_fails_as_written_is_not_searched(tmp_path: Path) -> None:
    resonant = repr((ARMS * 1e4 / INERTIA) ** 0.5)
    head = undamped().replace('"500 rad/s"', resonant)
    assert resonant in head
    search = row("k", STIFFNESS, 5000, 50000, FORCE, 'change = "-10 N"')
    outcome = checked(tmp_path, search, head=head, verb="run")
    assert outcome.code == EXIT_NUMERICAL and "undamped natural frequency" in outcome.err
