"""The short summary on the terminal: what came out, against what it is held, in colour."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.pages import (
    LONGEST_PRINTED,
    brief,
    computed,
    conclusion,
    difference,
    known_notes,
    limit_verdict,
    margin,
    not_shown,
    tolerance_line,
)
from vibecalc.core.report.pages import limits as limit_table
from vibecalc.core.report.pages import references as reference_table
from vibecalc.core.report.sections import SCALARS, START, labels, magnitudes, scalar_of, scalar_rows
from vibecalc.core.report.studies import bound_units, in_unit
from vibecalc.core.report.verdicts import OUTSIDE, WITHIN, judge_limits, judge_references
from vibecalc.core.report.writing import (
    WIDTH,
    also,
    decibels,
    filled,
    fold,
    hertz,
    paragraph,
    rpm,
    show,
)
from vibecalc.core.report.writing import table as fixed_table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.core.results.select import select
from vibecalc.core.results.tolerance import UNRESOLVED

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

# ----------------------------------------------------------------------------
# The few numbers worth a line on the terminal: peaks, frequencies, ratios, what is optimised.
# ----------------------------------------------------------------------------

_MOST = 16
_SCALARS = (
    "_peak",
    "frequency",
    "_ratio",
    "speed",
    "excitation/residual",
    "/objective",
    "_energy/mean",
    "_energy/peak",
    "/motor/peak",
    "tuning/peak",
    "tuning/travel",
    "tuning/secondary_damping",
    *(
        f"tuning/{kind}_{name}"
        for kind in ("linear", "torsional")
        for name in ("stiffness", "damping")
    ),
    "buy/peak",
    "buy/penalty",
    "pendulum/order",
    "jump/torque",
)
_VARIABLES, _BOUNDS = "optimisation/variable/", "optimisation/active_bound/"
_SIDES = {-1: "at its lower bound", 1: "at its upper bound"}
#: what a damper found for a shaft line is told by: its values, what they reach, what they gain
_DAMPER = tuple(
    f"damper_design/{name}"
    for name in ("stiffness", "damping", "worst_torque", "worst_twist", "worst_stress",
                 "worst_speed", "heat", "travel", "table/gain")
)  # fmt: skip
_ARRAYS = (
    "_peak",
    "natural_frequency",
    "impact/mean_force",
    "torsion/torque_half_range",
    "torsion/largest/torque_half_range",
    "torsion/largest/stress_half_range",
    "torsion/limit/largest_use",
    "torsion/damper/heat",
    "torsion/transient/peak",
)
#: levels of which the strongest order has a row, and those of which each has one
_STRONGEST = "response/roll/level/shell_acceleration"
_EACH = ("measurement/roll_level", "measurement/pitch_level")
#: of several absorbers, each has a row
_OF_ABSORBERS = tuple(
    f"tuning/each/{name}"
    for name in ("linear_stiffness", "linear_damping", "torsional_stiffness", "torsional_damping",
                 "stiffness_ratio", "secondary_damping", "frequency", "travel")
)  # fmt: skip
#: of an absorber that is given, what its curve comes to
_OF_CURVE = tuple(
    f"response/absorber/{name}" for name in ("largest", "largest_travel", "each/largest_travel")
)
_GIVEN = "as given"
#: ratios that go without saying where a tuning is told in units
_RATIOS = ("stiffness_ratio", "secondary_damping")
#: peaks that say the same as others, or the half of it
_LEFT_OUT = (
    "/rotating_peak",
    "excitation/rod/couple_peak",
    "response/roll/classical/rod_force_peak",
    "response/roll/classical/wall_force_peak",
    "instant/worst_kinetic_energy_peak",
    "tuning/mass_ratio",
    "unbounded/stiffness_ratio",
    "locked_frequency_ratio",
    "hardware/built/stiffness_ratio",
    "response/absorber/primary_frequency",
    "torsion/angle_peak",
    "torsion/torque_peak",
    "torsion/speeds/torque_peak",
    "torsion/bare/natural_frequency",
    "torsion/campbell/natural_frequency",
    *(
        f"{way}/{name}_peak"
        for way in ("instant", "reversal")
        for name in ("rotation", "ground_couple", "potential_energy")
    ),
)


def key_rows(record: Record, case: Mapping[str, Any] | None = None) -> list[list[str]]:
    """Rows for `SCALARS` in the order of the record, 16 at most; variables of an optimum and
    values found come first, then scalars, then arrays.

    Levels follow: the strongest order of the shell, every order of the roll and pitch of a plate.
    Of an array the largest entry is shown and named (which mount, which direction), of natural
    frequencies the lowest one; a peak of the run-up says its speed. Variables and values found are
    shown in the unit that `case` gives their bounds in.
    """
    in_units = any(path.endswith(("linear_damping", "torsional_damping")) for path in record
                   if path.startswith("tuning/"))  # fmt: skip
    found = [
        quantity
        for path, quantity in record.items()
        if not path.startswith(START)
        and not path.endswith(_LEFT_OUT)
        and not (in_units and path.startswith("tuning/") and path.endswith(_RATIOS))
    ]
    variables = [q for q in found if not q.axes and _is_variable(q.path)]
    scalars = [q for q in found if not q.axes and _is_key(q.path)]
    arrays = [q for q in found if q.axes and q.path.endswith(_ARRAYS) and q.values.size]
    chosen = {q.path for q in [*variables, *scalars, *arrays][:_MOST]}
    units = bound_units(case or {})
    rows = [
        _worst_row(record, quantity) if quantity.axes else _scalar_row(record, quantity, units)
        for quantity in found
        if quantity.path in chosen
    ]
    rows += [row for quantity in found for row in _absorber_rows(record, quantity)]
    return rows + [row for quantity in found for row in _level_rows(quantity)]


def _absorber_rows(record: Record, quantity: Quantity) -> list[list[str]]:
    """Of several absorbers a row for each; of one as given the largest response, and travels."""
    values = np.asarray(quantity.values)
    if quantity.path in _OF_ABSORBERS:
        names = labels(quantity.axes[0])
    elif quantity.path in _OF_CURVE and labels(quantity.axes[0])[0] == _GIVEN:
        values = np.atleast_1d(values[0])
        names = labels(quantity.axes[1]) if quantity.path.endswith("each/largest_travel") else [""]
        where = record.quantities.get(f"{quantity.path}_frequency_ratio")
        if where is not None:
            names = [f"{_GIVEN}, at {_place(record, float(where.values[0]))}"]
    else:
        return []
    return [
        [quantity.path, show(float(value), quantity.error_estimate), quantity.unit,
         "  ".join(word for word in (
             also(quantity.path, float(value), quantity.unit, quantity.error_estimate), name
         ) if word)]
        for value, name in zip(values, names, strict=True)
    ]  # fmt: skip


def _place(record: Record, ratio: float) -> str:
    """A frequency ratio, in Hz where the primary has units."""
    own = scalar_of(record, "response/absorber/primary_frequency")
    return f"ratio {show(ratio)}" if own is None else f"{show(hertz(own * ratio))} Hz"


def _level_rows(quantity: Quantity) -> list[list[str]]:
    """Levels in dB by order; one that is nothing is said to be zero."""
    if quantity.path not in (_STRONGEST, *_EACH) or not quantity.values.size:
        return []
    values, names = np.ravel(quantity.values), select(quantity, {}).labels
    if quantity.path == _STRONGEST:
        at = int(np.argmax(values))
        words = f"strongest: {names[at]}" if np.isfinite(values[at]) else "all orders"
        return [[quantity.path, decibels(float(values[at])), quantity.unit, words]]
    return [
        [quantity.path, decibels(float(value)), quantity.unit, name]
        for value, name in zip(values, names, strict=True)
    ][:_MOST]


def _is_key(path: str) -> bool:
    if path.startswith("damper_design/"):
        return path in _DAMPER
    return path.endswith(_SCALARS)


def _scalar_row(record: Record, quantity: Quantity, units: Mapping[str, str]) -> list[str]:
    """The row of a scalar; a variable that ended on a bound says so."""
    row = scalar_rows([quantity])[0]
    if quantity.path in units:
        unit = units[quantity.path]
        row[1:] = [show(*in_unit(quantity, unit)), unit, ""]
    if quantity.path.startswith(_VARIABLES):
        side = record.quantities.get(_BOUNDS + quantity.path.removeprefix(_VARIABLES))
        words = "" if side is None else _SIDES.get(int(side.values), "")
        row[3] = "  ".join(text for text in (row[3], words) if text)
    return row


def _is_variable(path: str) -> bool:
    return path.startswith(_VARIABLES) or (path.startswith("find/") and path.endswith("/value"))


def _is_line(quantity: Quantity) -> bool:
    return quantity.path.startswith("response/torsion/")


def _worst_row(record: Record, quantity: Quantity) -> list[str]:
    values, error = magnitudes(quantity), quantity.estimate
    at = int(np.argmax(values))
    if quantity.path.endswith("frequency"):
        # a free shaft line turns as a whole at exactly zero
        moving = np.where(values > 0.0, values, np.inf) if _is_line(quantity) else values
        at = int(np.argmin(moving))
    value = float(values.flat[at])
    words = [quantity.amplitude or "", also(quantity.path, value, quantity.unit, error)]
    shown = show(value, error)
    if error.unresolved(value):
        words.append(UNRESOLVED)
    if not error.is_zero(value):
        words.append(select(quantity, {}).labels[at] + _speed(record, quantity, at))
    return [quantity.path, shown, quantity.unit, "  ".join(word for word in words if word)]


def _speed(record: Record, quantity: Quantity, at: int) -> str:
    speeds = record.quantities.get(f"{quantity.path}_speed")
    if speeds is None or speeds.values.shape != quantity.values.shape:
        return ""
    return f" at {show(rpm(float(speeds.values.flat[at])))} rpm"


# ----------------------------------------------------------------------------
# The short summary on the terminal: what came out, against what it is held, in colour.
# ----------------------------------------------------------------------------

_MOST_REFERENCES = 10
#: characters that names get on the narrowest terminal
LEAST_NAME = 16


def print_summary(result: Result, path: Path) -> None:
    """Print the summary on stdout, in colour on a terminal, and where the files are."""
    if sys.stdout.isatty():
        from rich.console import Console

        summary(result, Console(highlight=False))
    else:
        sys.stdout.write(plain_summary(result))
    sys.stdout.write(f"wrote {path} and {path.with_suffix('.txt').name}\n")
    sys.stdout.flush()


def summary(result: Result, console: "Console") -> None:
    """Print title, key numbers, limits, references, warnings and the conclusion.

    Colours are left to `console`, which drops them where the output is no terminal.
    """
    from rich.markup import escape

    references, limits = judge_references(result), judge_limits(result)
    console.print(f"[bold]{escape(str(result.case.get('title') or result.name))}[/bold]")
    for make in (_scalars, _limits, _references):
        table = make(result, console.width)
        if table is not None:
            console.print(table)
    shown = brief(references, _MOST_REFERENCES)
    hidden = not_shown(references, shown)
    if hidden:
        console.print(escape(hidden))
    for note in known_notes(shown):
        console.print(f"[yellow]known:[/yellow] {escape(note)}")
    for text in dict.fromkeys(result.record.warnings):
        console.print(f"[yellow]warning:[/yellow] {escape(text)}")
    reached = tolerance_line(result)
    if reached:
        console.print(escape(reached))
    good = all(row.satisfied for row in limits) and all(
        row.within is not False for row in references
    )
    colour = "green" if good else "red"
    console.print(f"[{colour}]{escape(conclusion(references, limits))}[/{colour}]")


def plain_summary(result: Result) -> str:
    """The same without colour and without importing rich, for pipes and files."""
    references, limits = judge_references(result), judge_limits(result)
    rows = key_rows(result.record, result.case)
    tables = (
        fixed_table(SCALARS, rows) if rows else [],
        limit_table(limits),
        reference_table(references, _MOST_REFERENCES),
        [
            line
            for text in dict.fromkeys(result.record.warnings)
            for line in paragraph(text, "warning:")
        ],
    )
    lines = fold(str(result.case.get("title") or result.name), WIDTH)
    for table in tables:
        lines += ["", *table] if table else []
    reached = tolerance_line(result)
    lines += ["", *paragraph(reached)] if reached else []
    lines += ["", *paragraph(conclusion(references, limits))]
    return "\n".join(lines) + "\n"


def _scalars(result: Result, width: int) -> "Table | None":
    rows = key_rows(result.record, result.case)
    if not rows:
        return None
    return _table(width, ("quantity", ">value", "unit", ""), [list(row) for row in rows])


def _limits(result: Result, width: int) -> "Table | None":
    rows = judge_limits(result)
    if not rows:
        return None
    lines, colours = [], []
    for row in rows:
        bounds = [
            f"{side} {value:.6g}"
            for side, value in (("min", row.min), ("max", row.max))
            if value is not None
        ]
        name = row.quantity + (f" [{row.label}]" if row.label else "")
        cells = [name, " ".join(bounds), show(row.computed, row.error_estimate)]
        cells += [margin(row), row.unit]
        lines.append([*cells, limit_verdict(row)])
        colours.append("green" if row.satisfied else "bold red")
    heads = ("limit on", ">bound", ">computed", ">margin", "unit", "verdict")
    return _table(width, heads, lines, colours)


def _references(result: Result, width: int) -> "Table | None":
    rows = judge_references(result)
    if not rows:
        return None
    lines, colours = [], []
    for row in brief(rows, _MOST_REFERENCES):
        picks = ", ".join(f"{axis}={entry}" for axis, entry in row.where.items())
        name = row.quantity + (f" [{picks}]" if picks else "") + f" ({row.source})"
        printed = row.printed if len(row.printed) <= LONGEST_PRINTED else show(row.value)
        cells = [name, printed, computed(row), row.unit]
        lines.append([*cells, difference(row), row.verdict])
        missed = dict.fromkeys((OUTSIDE, UNRESOLVED), "bold red")
        colours.append(({WITHIN: "green"} | missed).get(row.verdict, "yellow"))
    heads = ("reference (source)", ">value", ">computed", "unit", ">difference", "verdict")
    return _table(width, heads, lines, colours)


def _table(
    width: int, heads: Sequence[str], rows: Sequence[Sequence[str]], colours: Sequence[str] = ()
) -> "Table":
    """A table of at most `width` characters; `colours` are those of the last cells.

    Where the terminal is narrow the names of the first column, and only they, go on below: after
    a `/` of a path, never within a word. A number cut short would be another number.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    places = filled(rows, len(heads))
    heads, *rows = ([cells[place] for place in places] for cells in (heads, *rows))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    others = zip(*(heads, *rows), strict=True)
    taken = sum(max(map(len, column)) + 2 for column in list(others)[1:])
    name = max(width - taken - 2, LEAST_NAME)
    for number, head in enumerate(heads):
        right = head.startswith(">")
        table.add_column(
            head.removeprefix(">"),
            justify="right" if right else "left",
            no_wrap=number == 0 or right,
            overflow="fold",
        )
    for cells, colour in zip(rows, colours or [""] * len(rows), strict=True):
        first = Text("\n".join(fold(cells[0], name)))
        table.add_row(first, *map(Text, cells[1:-1]), Text(cells[-1], style=colour))
    return table
