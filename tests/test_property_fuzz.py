"""Claim: no case file, however broken, gives a traceback or a hang; exit codes are 0 to 3."""

import random
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
from fuzzing import ALLOWED, MUTATORS, command, mutations
from long_but import long_but
from shipped_cases import CASES

from vibecalc.cli.starters import starter

SEED = 20080319


def hold(text: str, number: int, path: Path, *arguments: str) -> int:
    path.write_text(text, encoding="utf-8")
    outcome = command(*arguments)
    shown = f"mutation {number}: {arguments}\n{text}\n{outcome.out}\n{outcome.err}"
    assert outcome.code in ALLOWED, shown
    assert "Traceback" not in outcome.err, shown
    assert outcome.code == 0 or outcome.err.strip(), shown
    assert "nan" not in outcome.out.lower().split(), shown
    return outcome.code


def checked(texts: Iterable[str], path: Path) -> Counter[int]:
    """How `check` of each text ends."""
    return Counter(hold(text, n, path, "check", str(path)) for n, text in enumerate(texts))


def broken_starters(scene: str, count: int) -> Iterator[str]:
    """A starter case without its comments, changed in one to three places, so many times."""
    draw = random.Random(scene)
    lines = [line for line in starter(scene).splitlines() if not line.lstrip().startswith("#")]
    for _ in range(count):
        broken = "\n".join(lines) + "\n"
        for _ in range(draw.choice((1, 1, 2, 3))):
            broken = draw.choice(MUTATORS)(draw, broken)
        yield broken


def run_many(count: int, path: Path, seed: int) -> int:
    """Only those that pass `check` reach a run; optimisation is left to its own tests."""
    done = 0
    for number, text in enumerate(mutations(seed, 50 * count)):
        if done == count:
            break
        text = text.split("[optimisation]", 1)[0]
        if hold(text, number, path, "check", str(path)) == 0:
            hold(text, number, path, "run", str(path), "-q", "-o", f"{path.parent}/out/")
            done += 1
    return done


#: what mutations ended in a bug, and how it ends now: case, change, exit code, words
FOUND = [
    ("pump_drive", "orders = [12]", "frequencies = []", 2, "has neither orders nor blades"),
    ("generator_mount_design", 'damping = "50 N*s/m"', "damping = [1, 2, 3]", 2,
     "a search wants one number, as machine.mounts.each.damping[0]"),
    ("absorber_rig_b", 'density = "870 kg/m^3"', "density = 1e-300", 2, ">= 100 kg/m^3"),
    ("absorber_curves", "mass_ratio = 0.1", "mass_ratio = 3", 0, ""),
]  # fmt: skip


@pytest.mark.parametrize(("case", "old", "new", "code", "words"), FOUND)
def test_what_mutations_have_found(
    case: str, old: str, new: str, code: int, words: str, tmp_path: Path
) -> None:
    text, path = CASES[case].read_text(encoding="utf-8"), tmp_path / "mutated.toml"
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    outcome = command("run", str(path), "-q", "-o", f"{tmp_path}/out/")
    assert outcome.code == code and words in outcome.err


@pytest.mark.timeout(280)
def test_mutations_through_check(tmp_path: Path) -> None:
    codes = checked(mutations(SEED, 30), tmp_path / "mutated.toml")
    assert set(codes) == {0, 2}
    assert codes[2] > 20 and codes[0] > 0


SCENES = ("absorber", "absorber_rig", "pendulum", "roll", "roll_control", "plate")


@pytest.mark.parametrize("scene", long_but(SCENES, "absorber_rig", "roll", "plate"))
def test_broken_starters_end_in_words(scene: str, tmp_path: Path) -> None:
    codes = checked(broken_starters(scene, 20), tmp_path / "mutated.toml")
    assert set(codes) <= {0, 2}
    assert codes[2] > 4


@pytest.mark.long
@pytest.mark.timeout(14000)
@pytest.mark.parametrize("part", range(20))
def test_hundred_thousand_mutations(part: int, tmp_path: Path) -> None:
    path = tmp_path / "mutated.toml"
    assert checked(mutations(SEED + 100 + part, 4900), path).total() == 4900
    assert run_many(100, path, SEED + 200 + part) == 100
