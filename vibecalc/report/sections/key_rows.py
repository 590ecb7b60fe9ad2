"""The few numbers worth a line on the terminal: peaks, frequencies, ratios, what is optimised."""

import numpy as np

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
)
_VARIABLES = "optimisation/variable/"
_ARRAYS = ("_peak", "natural_frequency", "impact/mean_force")
#: peaks that say the same as others, or the half of it
_LEFT_OUT = (
    "/rotating_peak",
    "excitation/rod/couple_peak",
    "instant/worst_kinetic_energy_peak",
    *(
        f"{way}/{name}_peak"
        for way in ("instant", "reversal")
        for name in ("rotation", "ground_couple", "potential_energy")
    ),
)


def key_rows(record: Record) -> list[list[str]]:
    """Rows for `SCALARS` in the order of the record, 16 at most; variables of an optimum
    come first, then scalars, then arrays.

    Of an array the largest entry is shown and named (which mount, which direction), of natural
    frequencies the lowest one; a peak of the run-up says its speed.
    """
    found = [
        quantity
        for path, quantity in record.items()
        if not path.startswith(START) and not path.endswith(_LEFT_OUT)
    ]
    variables = [q for q in found if not q.axes and q.path.startswith(_VARIABLES)]
    scalars = [q for q in found if not q.axes and q.path.endswith(_SCALARS)]
    arrays = [q for q in found if q.axes and q.path.endswith(_ARRAYS) and q.values.size]
    chosen = {q.path for q in [*variables, *scalars, *arrays][:_MOST]}
    return [
        _worst_row(record, quantity) if quantity.axes else scalar_rows([quantity])[0]
        for quantity in found
        if quantity.path in chosen
    ]


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
