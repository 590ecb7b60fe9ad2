"""All hard cases, room by room, and the table of docs/stability.md."""

import math
from functools import cache

import numpy as np
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
from stability.stated import STATED, Stated

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


def in_words(lost: Lost) -> str:
    return lost if isinstance(lost, str) else f"{lost:g}"


def table() -> str:
    """Markdown: case, where it comes from, condition, digits lost, what vibecalc does."""
    lines = [
        "| case | from | condition | vibecalc loses | others lose | what vibecalc does |",
        "|---|---|---|---|---|---|",
    ]
    for name in ROOMS:
        lines.append(f"| **{name}** | | | | | |")
        for case in room(name):
            said = STATED[case.name]
            size = f"{said.condition:.1g}" if said.condition else "0"
            others = "; ".join(f"{way}: {in_words(lost)}" for way, lost in said.others.items())
            cells = (case.name, case.source, size, in_words(said.own), others, case.does)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def in_toml(lost: Lost) -> str:
    return f'"{lost}"' if isinstance(lost, str) else f"{lost:g}"


def main() -> None:
    """Print what `stated.toml` should hold, from a run on this machine."""
    for case in all_cases():
        said = measured(case)
        print(f'["{case.name}"]\ncondition = {said.condition:.2g}\nown = {in_toml(said.own)}')
        print(f'["{case.name}".others]')
        for name, lost in said.others.items():
            print(f'"{name}" = {in_toml(lost)}')
        print()


if __name__ == "__main__":
    main()
