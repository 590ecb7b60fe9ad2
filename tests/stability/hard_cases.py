"""All hard cases, room by room, and the table of docs/accuracy.md."""

import math
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tomli_w
from stability import (
    hard_absorber,
    hard_compressor,
    hard_impact,
    hard_isolation,
    hard_kinematics,
    hard_numerics,
    hard_roll,
    hard_torsion,
)
from stability.hard_case import INFINITE, NOT_FINITE, HardCase, Lost, outcome


class Stated(NamedTuple):
    """Condition; digits that vibecalc loses at most; digits of the other ways, to a half."""

    condition: float
    own: Lost
    others: dict[str, Lost]


_TEXT = (Path(__file__).parent / "stated.toml").read_text(encoding="utf-8")
STATED = {name: Stated(**row) for name, row in tomllib.loads(_TEXT).items()}

#: condition below which the digits lost count against the method, not against the data
WELL_CONDITIONED = 1e4
ROOMS = {
    "kinematics": hard_kinematics.cases,
    "body on springs": hard_compressor.cases,
    "impact": hard_impact.cases,
    "roll": hard_roll.cases,
    "absorber": hard_absorber.cases,
    "torsion": hard_torsion.cases,
    "isolation": hard_isolation.cases,
    "shared methods": hard_numerics.cases,
}


@cache
def room(name: str) -> tuple[HardCase, ...]:
    return ROOMS[name]()


def all_cases() -> list[HardCase]:
    return [case for name in ROOMS for case in room(name)]


def to_half(lost: Lost) -> Lost:
    return lost if isinstance(lost, str) else round(2.0 * lost) / 2.0


def upwards(lost: Lost) -> Lost:
    """The next half digit that leaves a fifth of one to spare."""
    return lost if isinstance(lost, str) else math.ceil(2.0 * (lost + 0.2)) / 2.0


def measured(case: HardCase) -> Stated:
    """What `stated.toml` should say of a case."""
    size = case.condition()
    rounded = size if not np.isfinite(size) or size == 0.0 else float(f"{size:.1e}")
    own = own_outcome(case)
    others = {way.name: to_half(outcome(way.values, case)) for way in case.ways}
    return Stated(rounded, upwards(own), others)


def own_outcome(case: HardCase) -> Lost:
    """As of any way; where there is no value, an infinite one says so."""
    found = outcome(lambda: case.own().value, case)
    return INFINITE if case.truth is None and found == NOT_FINITE else found


def table() -> str:
    """Markdown by subject: cases, without an answer, digits that vibecalc and others lose."""
    lines = [
        "| subject | cases | no answer | vibecalc loses at most | others lose 8 or more in |",
        "|---|---|---|---|---|",
    ]
    for name in ROOMS:
        stated = [STATED[case.name] for case in room(name)]
        answered = [one for one in stated if not isinstance(one.own, str)]
        own = max(float(one.own) for one in answered if one.condition < WELL_CONDITIONED)
        lost = [one for one in answered if any(_many(other) for other in one.others.values())]
        cells = (name, len(stated), len(stated) - len(answered), f"{own:g}", len(lost))
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _many(lost: Lost) -> bool:
    return isinstance(lost, str) or lost >= 8.0


def main() -> None:
    """Print what `stated.toml` should hold, from a run on this machine."""
    for case in all_cases():
        print(tomli_w.dumps({case.name: measured(case)._asdict()}))


if __name__ == "__main__":
    main()
