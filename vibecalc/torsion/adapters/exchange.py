"""Shaft lines in and out: an openTorsion assembly to a case, a case to CSV files or an assembly."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.case.load import LoadedCase, validate
from vibecalc.core.case.row_files import LISTS, text_of_rows
from vibecalc.core.results.files import write_together
from vibecalc.core.results.text_files import text_file
from vibecalc.core.results.visible import fits_a_line
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import CaseError, Problem, UsageError
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.tors import (
    LARGEST_FILE,
    Joint,
    LineRead,
    Mesh,
    NoAssembly,
    Twist,
    read_assembly,
    tors,
)

if TYPE_CHECKING:
    from vibecalc.torsion.shaft_line_tables import Gear, ShaftLine

# ----------------------------------------------------------------------------
# An openTorsion assembly as a case.
# ----------------------------------------------------------------------------

#: what a case wants besides its shaft line
_BEFORE = """\
#:schema ./vibecalc.schema.json
# The shaft line of {file}, as openTorsion reads it. Numbers are those of the
# file, each at the speed of its own shaft.{remarks}

schema = 1
title = {title}
source = {source}

[machine]
kind = "drive_train"
speed = "1500 rpm" # of the first station; the file does not say it
"""
_BEHIND = """
[response.torsion]
campbell = true
"""


def case_of_assembly(path: Path) -> str:
    """A case, as TOML, with the shaft line of an openTorsion assembly (TORS, JSON).

    Raises UsageError where the file is none, or is a line that no case can have.
    """
    try:
        read = read_assembly(text_file(path, LARGEST_FILE, "the assembly"))
    except NoAssembly as error:
        raise UsageError(f"{path}: {error}") from None
    text = _case_text(read, path.name if fits_a_line(path.name) else ascii(path.name))
    import tomllib

    data = tomllib.loads(text)
    try:
        problems: list[Problem] = check_machine(validate(data))
    except CaseError as error:
        problems = list(error.problems)
    if problems:
        said = [
            " ".join(part for part in (one.message, one.found and f"(found {one.found})") if part)
            for one in problems[:8]
        ]
        raise UsageError(f"{path}: no case can have this line: " + "\n  ".join(said))
    return text


def _case_text(read: LineRead, file: str) -> str:
    import textwrap

    remarks = "".join(
        "\n" + textwrap.fill(one[:1].upper() + one[1:] + ".", 98, initial_indent="# ",
                             subsequent_indent="# ")
        for one in read.remarks
    )  # fmt: skip
    head = _BEFORE.format(
        file=file,
        remarks=remarks,
        title=_toml(read.title[:200]),
        source=_toml(f"{file}, an assembly of openTorsion"),
    )
    excited = {"on": read.stations[0]["name"], "orders": [1], "torques": ["0 N*m"]}
    lines = [head, "[machine.shaft_line]"]
    for key, rows in (
        ("stations", read.stations),
        ("shafts", read.shafts),
        ("gears", read.gears),
        ("dampers", read.dampers),
    ):
        if rows:
            lines += [f"{key} = [", *(f"  {_toml(row)}," for row in rows), "]"]
    lines += [f"excitations = [{_toml(excited)}] # put what excites the line here"]
    return "\n".join(lines) + "\n" + _BEHIND


def _toml(value: Any) -> str:
    """A value as TOML, on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    import tomli_w

    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")


# ----------------------------------------------------------------------------
# A case as CSV files, or as an openTorsion assembly.
# ----------------------------------------------------------------------------

#: keys whose values an assembly has, in its own words
_CARRIED = {
    "stations": {"name", "inertia", "throw", "absolute_damping"},
    "shafts": {"name", "between", "stiffness", "section", "throw", "damping", "damping_ratio"},
    "gears": {"name", "between", "ratio", "teeth", "reverses", "mesh_stiffness", "pitch_radius"},
    "dampers": {"name", "on", "kind", "inertia", "stiffness", "damping"},
}


def export_shaft_line(loaded: LoadedCase, output: Path) -> tuple[list[Path], list[str]]:
    """Write the shaft line of a validated case; return the files, and what they do not carry.

    `output` that ends in .json becomes an openTorsion assembly, else it is a folder for CSV files
    <case>_stations.csv, <case>_shafts.csv and <case>_gears.csv. Raises UsageError where there is no
    shaft line, a file is there already, or the format cannot say the line.
    """
    line = loaded.case.machine.shaft_line
    if line is None:
        raise UsageError(f"{loaded.path} has no [machine.shaft_line] to write")
    if output.suffix.lower() == ".json":
        content, left = _assembly(loaded)
        files = {output: json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)}
    else:
        texts, left = _csv_texts(line)
        files = {output / f"{loaded.name}_{key}.csv": text for key, text in texts.items()}
    taken = [path for path in files if path.exists()]
    if taken:
        raise UsageError(f"{taken[0]} exists already; remove it or choose another name")
    write_together([(path, f"{text}\n".encode()) for path, text in files.items()])
    return list(files), left


def _given(line: "ShaftLine") -> dict[str, Any]:
    """What the tables of a line have beyond defaults."""
    return line.model_dump(by_alias=True, exclude_none=True, exclude_defaults=True)


def _csv_texts(line: "ShaftLine") -> tuple[dict[str, str], list[str]]:
    given = _given(line)
    texts, left = {}, []
    for path in LISTS:
        key = str(path[-1])
        rows = given.pop(key, ())
        if rows:
            texts[key], lost = text_of_rows(path, rows)
            left += [f"{key}: {name}" for name in lost]
    return texts, [*left, *given]


def _assembly(loaded: LoadedCase) -> tuple[dict[str, Any], list[str]]:
    """The line as openTorsion reads it, from the arrays that a run solves."""
    line = loaded.case.machine.shaft_line
    assert line is not None
    shaft = build_shaft_line(loaded.case)
    held = np.flatnonzero(shaft.station_values[2])
    turning = [one.name for one in shaft.dampers if one.kind == "pendulum"]
    if len(held) or turning:
        what = (
            f"pendulums, as {turning[0]!r}"
            if turning
            else f"a stiffness to the ground, as of {shaft.station_names[held[0]]!r}"
        )
        raise UsageError(
            f"the JSON of openTorsion has no word for {what}: natural frequencies would be others"
        )
    square = shaft.station_ratio**2
    inertia, damping, _ = shaft.station_values / square
    names = [*shaft.station_names, *(one.name for one in shaft.dampers)]
    ring = {one.element: len(square) + place for place, one in enumerate(shaft.dampers)}
    meshes = {gear.element: gear for gear in shaft.gears if gear.element >= 0}
    own = shaft.section_ratio**2
    joints: list[Joint] = []
    for place, (first, second) in enumerate(shaft.section_ends.tolist()):
        stiffness = float(shaft.line.stiffness[place] / own[place])
        damping_of = float(shaft.line.damping[place] / own[place])
        gear = meshes.get(place)
        wheels = None if gear is None else _wheels(gear.ratio)
        ends = (first, ring.get(place, second))
        joints.append(Twist(shaft.section_names[place], *ends, stiffness, damping_of, wheels))
    for gearing, given in zip(shaft.gears, line.gears, strict=True):
        if gearing.element < 0:
            teeth, key = _rigid(given, gearing.ratio)
            joints.append(Mesh(gearing.name, gearing.first, gearing.second, teeth, key))
    left: list[str] = []
    for key, rows in _given(line).items():
        if key in _CARRIED:
            lost = {name for row in rows for name in row} - _CARRIED[key]
            left += [f"{key}: {name}" for name in sorted(lost)]
        else:
            left.append(key)
    rings = [one.inertia for one in shaft.dampers]
    inertias, dampings = [*inertia, *rings], [*damping, *(0.0 for _ in rings)]
    return tors(loaded.case.title or loaded.name, names, inertias, dampings, joints), left


def _wheels(ratio: float) -> tuple[float, float]:
    """R of two wheels, R theta + R' theta' = 0, for own speed of the second over the first."""
    return -ratio, 1.0


def _rigid(gear: "Gear", ratio: float) -> tuple[tuple[float, float], str]:
    if gear.teeth is None:
        return _wheels(ratio), "diameter"
    first, second = gear.teeth
    return (first, second if gear.reverses else -second), "teeth"
