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


def uff_samples(path: Path) -> tuple[FloatArray, dict[str, FloatArray], dict[str, str]]:
    """Times (n,), signals (n,) by their number from 1 on, and units of accelerations and speeds.

    Numbers count the data sets 58 in their order in the file. Raises Unreadable.
    """
    try:
        import pyuff
    except ImportError:
        raise Unreadable(
            "a universal file is read by pyuff, which is not there",
            "a CSV or WAV file",
            "pip install 'vibecalc[uff]'",
        ) from None
    try:
        read: Any = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # whatever a reader of text makes of a file that is none
        raise Unreadable(f"the file is no universal file: {str(error)[:80]}") from None
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
        if len(one["data"]) != len(sets[0]["data"]) or not np.all(np.isfinite(one["data"])):
            raise Unreadable(f"data set {number} has other samples than the first", "as many")
    columns = {str(place + 1): np.array(one["data"], float) for place, one in enumerate(sets)}
    labels = {
        str(place + 1): _unit_of(str(one["ordinate_axis_units_lab"]).strip())
        for place, one in enumerate(sets)
    }
    units = {name: unit for name, unit in labels.items() if unit}
    times = np.arange(len(sets[0]["data"]), dtype=np.float64) * float(sets[0]["abscissa_inc"])
    return times, columns, units


def _unit_of(label: str) -> str:
    """The unit of an acceleration or a speed, also where it is in capitals; else nothing."""
    for unit in (label, label.lower()):
        for wanted in ("m/s^2", "rad/s"):
            try:
                convert(1.0, unit, wanted)
            except UnitError:
                continue
            return unit
    return ""
