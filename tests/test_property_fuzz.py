"""Claim: no case file, however broken, gives a traceback or a hang; exit codes are 0 to 3."""

import random
from pathlib import Path

import pytest
from fuzzing import ALLOWED, MUTATORS, command, mutations
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


def check_many(count: int, path: Path, seed: int = SEED) -> dict[int, int]:
    codes: dict[int, int] = {}
    for number, text in enumerate(mutations(seed, count)):
        code = hold(text, number, path, "check", str(path))
        codes[code] = codes.get(code, 0) + 1
    return codes


def check_broken_starters(scene: str, count: int, path: Path) -> dict[int, int]:
    """`check` of a starter case, changed in one to three places, so many times."""
    draw = random.Random(scene)
    lines = [line for line in starter(scene).splitlines() if not line.lstrip().startswith("#")]
    codes: dict[int, int] = {}
    for number in range(count):
        broken = "\n".join(lines) + "\n"
        for _ in range(draw.choice((1, 1, 2, 3))):
            broken = draw.choice(MUTATORS)(draw, broken)
        code = hold(broken, number, path, "check", str(path))
        codes[code] = codes.get(code, 0) + 1
    return codes


def run_many(count: int, path: Path, seed: int = SEED + 1) -> dict[int, int]:
    """Only those that pass `check` reach a run; optimisation is left to its own tests."""
    codes: dict[int, int] = {}
    outputs = str(path.parent) + "/out/"
    done = 0
    for number, text in enumerate(mutations(seed, 50 * count)):
        if done == count:
            break
        text = text.split("[optimisation]", 1)[0]
        if hold(text, number, path, "check", str(path)) != 0:
            continue
        code = hold(text, number, path, "run", str(path), "-q", "-o", outputs)
        codes[code] = codes.get(code, 0) + 1
        done += 1
    return codes


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
    codes = check_many(30, tmp_path / "mutated.toml")
    assert set(codes) == {0, 2}
    assert codes[2] > 20 and codes[0] > 0


@pytest.mark.long
@pytest.mark.timeout(14000)
@pytest.mark.parametrize("part", range(20))
def test_hundred_thousand_mutations(part: int, tmp_path: Path) -> None:
    codes = check_many(4900, tmp_path / "mutated.toml", seed=SEED + 100 + part)
    ran = run_many(100, tmp_path / "mutated.toml", seed=SEED + 200 + part)
    assert sum(codes.values()) == 4900
    assert sum(ran.values()) == 100
