"""Records in universal files: functions of time, data set 58."""

from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.case.csv_files import Unreadable
from vibecalc.errors import UnitError
from vibecalc.numerics.rounding import FloatArray
from vibecalc.units import convert

#: of the function of a data set 58: a response over time
_OVER_TIME = 1
_EVENLY = 1


#: along z of the response of a data set 58; 0: it is not said
_UPWARDS, _UNSAID = 3, 0


def uff_samples(path: Path) -> tuple[FloatArray, dict[str, FloatArray], dict[str, str]]:
    """Times (n,), signals (n,) by their number from 1 on, and units of accelerations and speeds.

    Numbers count the data sets 58 in their order in the file. An acceleration downwards (-Z) is
    turned; one in another direction is refused. Raises Unreadable.
    """
    try:
        import pyuff
    except ImportError:
        raise Unreadable(
            "universal files need pyuff, which is not installed",
            "a CSV or WAV file",
            "pip install 'vibecalc[uff]'",
        ) from None
    try:
        read: Any = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # whatever a reader of text makes of a file that is none
        raise Unreadable(f"the file is not a universal file: {str(error)[:80]}") from None
    sets = [one for one in (read if isinstance(read, list) else [read]) if one.get("type") == 58]
    if not sets:
        raise Unreadable("the file has no data set 58", "functions of time")
    for number, one in enumerate(sets, start=1):
        if one["func_type"] != _OVER_TIME or np.iscomplexobj(one["data"]):
            raise Unreadable(
                f"data set {number} is no response over time: its function is {one['func_type']}",
                f"function {_OVER_TIME} in each",
            )
        same = one["abscissa_inc"] == sets[0]["abscissa_inc"]
        if one["abscissa_spacing"] != _EVENLY or not same or one["abscissa_inc"] <= 0.0:
            raise Unreadable(f"data set {number} has times of its own", "samples at one rate")
        if one["abscissa_min"] != sets[0]["abscissa_min"]:
            raise Unreadable(
                f"data set {number} begins at {one['abscissa_min']:.6g} s, and the first at "
                f"{sets[0]['abscissa_min']:.6g} s",
                "sets that begin together",
            )
        if len(one["data"]) != len(sets[0]["data"]) or not np.all(np.isfinite(one["data"])):
            raise Unreadable(f"data set {number} has other samples than the first", "as many")
    labels = {
        str(place + 1): _unit_of(str(one["ordinate_axis_units_lab"]).strip())
        for place, one in enumerate(sets)
    }
    units = {name: unit for name, unit in labels.items() if unit}
    columns = {
        name: np.array(one["data"], float) * _sense(name, one, units.get(name, ""))
        for name, one in zip(labels, sets, strict=True)
    }
    steps = np.arange(len(sets[0]["data"]), dtype=np.float64) * float(sets[0]["abscissa_inc"])
    return float(sets[0]["abscissa_min"]) + steps, columns, units


def _sense(name: str, one: Any, unit: str) -> float:
    """1 upwards, -1 downwards; of what is no acceleration 1."""
    direction = int(one.get("rsp_dir", _UNSAID))
    if not _is(unit, "m/s^2") or abs(direction) in (_UPWARDS, _UNSAID):
        return -1.0 if direction == -_UPWARDS and _is(unit, "m/s^2") else 1.0
    raise Unreadable(
        f"data set {name} is an acceleration in direction {direction} (1: X, 2: Y, 3: Z, 4 to 6 "
        "about them)",
        "accelerations along z, which is upwards",
    )


def _is(unit: str, wanted: str) -> bool:
    try:
        convert(1.0, unit, wanted)
    except UnitError:
        return False
    return bool(unit)


def _unit_of(label: str) -> str:
    """The unit of an acceleration or a speed, also where it is in capitals; else nothing."""
    for unit in (label, label.lower()):
        for wanted in ("m/s^2", "rad/s"):
            if _is(unit, wanted):
                return unit
    return ""
