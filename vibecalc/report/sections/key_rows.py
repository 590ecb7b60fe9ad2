"""The few numbers worth a line on the terminal: peaks, frequencies, ratios, what is optimised."""

import numpy as np

from vibecalc.report.levels import decibels
from vibecalc.report.lookup import START, magnitudes
from vibecalc.report.numbers import also, rpm, show
from vibecalc.report.sections.section import scalar_rows
from vibecalc.results.record import Quantity, Record
from vibecalc.results.select import select

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
    "buy/peak",
    "buy/penalty",
    "pendulum/order",
    "jump/torque",
)
_VARIABLES = "optimisation/variable/"
_ARRAYS = ("_peak", "natural_frequency", "impact/mean_force")
#: levels of which the strongest order has a row, and those of which each has one
_STRONGEST = "response/roll/level/shell_acceleration"
_EACH = ("measurement/roll_level", "measurement/pitch_level")
#: peaks that say the same as others, or the half of it
_LEFT_OUT = (
    "/rotating_peak",
    "excitation/rod/couple_peak",
    "response/roll/classical/rod_force_peak",
    "response/roll/classical/wall_force_peak",
    "instant/worst_kinetic_energy_peak",
    "tuning/mass_ratio",
    "tuning/bounded/stiffness_ratio",
    "locked_frequency_ratio",
    "hardware/built/stiffness_ratio",
    "response/absorber/primary_frequency",
    *(
        f"{way}/{name}_peak"
        for way in ("instant", "reversal")
        for name in ("rotation", "ground_couple", "potential_energy")
    ),
)


def key_rows(record: Record) -> list[list[str]]:
    """Rows for `SCALARS` in the order of the record, 16 at most; variables of an optimum and
    values found come first, then scalars, then arrays.

    Levels follow: the strongest order of the shell, every order of the roll and pitch of a plate.
    Of an array the largest entry is shown and named (which mount, which direction), of natural
    frequencies the lowest one; a peak of the run-up says its speed.
    """
    found = [
        quantity
        for path, quantity in record.items()
        if not path.startswith(START) and not path.endswith(_LEFT_OUT)
    ]
    variables = [q for q in found if not q.axes and _is_variable(q.path)]
    scalars = [q for q in found if not q.axes and q.path.endswith(_SCALARS)]
    arrays = [q for q in found if q.axes and q.path.endswith(_ARRAYS) and q.values.size]
    chosen = {q.path for q in [*variables, *scalars, *arrays][:_MOST]}
    rows = [
        _worst_row(record, quantity) if quantity.axes else scalar_rows([quantity])[0]
        for quantity in found
        if quantity.path in chosen
    ]
    return rows + [row for quantity in found for row in _level_rows(quantity)]


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


def _is_variable(path: str) -> bool:
    return path.startswith(_VARIABLES) or (path.startswith("find/") and path.endswith("/value"))


def _worst_row(record: Record, quantity: Quantity) -> list[str]:
    values, error = magnitudes(quantity), quantity.error_estimate
    at = int(np.argmin(values) if quantity.path.endswith("frequency") else np.argmax(values))
    value = float(values.flat[at])
    words = [quantity.amplitude or "", also(quantity.path, value, quantity.unit, error)]
    shown = show(value, error)
    if shown != "0":
        words.append(select(quantity, {}).labels[at] + _speed(record, quantity, at))
    return [quantity.path, shown, quantity.unit, "  ".join(word for word in words if word)]


def _speed(record: Record, quantity: Quantity, at: int) -> str:
    speeds = record.quantities.get(f"{quantity.path}_speed")
    if speeds is None or speeds.values.shape != quantity.values.shape:
        return ""
    return f" at {show(rpm(float(speeds.values.flat[at])))} rpm"
