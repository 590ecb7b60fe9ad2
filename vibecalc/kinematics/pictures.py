"""Pictures of the piston motion over one turn, and of what its first two harmonics miss."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.canvas import COLOURS, TOTAL, unit_words, waves
from vibecalc.core.report.curves import Curve, Curves, Panel
from vibecalc.core.report.sections import having
from vibecalc.core.report.sources import over_turn
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Result

# ----------------------------------------------------------------------------
# Motion of the piston over one turn: position, velocity, acceleration.
# ----------------------------------------------------------------------------


def _motion(name: str, unit: str, colour: str) -> Panel:
    return Panel(f"{name}\n", (Curve(f"kinematics/{name}", look={"color": colour}),), unit=unit)


_UNITS = {"position": "mm", "velocity": "m/s", "acceleration": "m/s^2"}
PISTON_MOTION = Curves(
    "piston motion over one turn", tuple(map(_motion, _UNITS, _UNITS.values(), COLOURS)), high=1.93
)

# ----------------------------------------------------------------------------
# Acceleration of the piston over one turn next to its first two harmonics, and what these miss.
# ----------------------------------------------------------------------------

_FEW = 2
#: of the largest acceleration, what is no difference
_ROUNDING = 1e-9
_CURVE = "kinematics/acceleration"


def _short(result: Result) -> Quantity | None:
    """The first two harmonics at the crank angles of the acceleration."""
    whole = having(result.record, _CURVE, "crank_angle")
    series = having(result.record, f"{_CURVE}_harmonics", "order")
    if whole is None or series is None:
        return None
    order = np.asarray(series.axes[0].values)
    few = order <= _FEW
    turned = waves(order[few], np.asarray(whole.axes[0].values))
    return replace(whole, path="", values=np.real(np.asarray(series.values)[few] @ turned))


def _missed(result: Result) -> Quantity | None:
    """The difference to them, None if it is rounding."""
    whole, short = having(result.record, _CURVE, "crank_angle"), _short(result)
    if whole is None or short is None:
        return None
    values = whole.values - short.values
    if np.abs(values).max() <= _ROUNDING * np.abs(whole.values).max():
        return None
    return replace(short, values=values)


def _title(result: Result) -> str:
    rest = " (no higher ones)" if _missed(result) is None else ""
    return f"piston acceleration and its first two harmonics{rest}"


def _largest(result: Result) -> str:
    missed = _missed(result)
    assert missed is not None  # or there is no panel
    largest = np.abs(missed.values).max()
    share = show(100.0 * largest / np.abs(result.record[_CURVE].values).max(), digits=2)
    unit = unit_words(missed.unit)[1]
    return f"largest difference {show(largest, digits=3)} {unit}, {share} % of the largest"


_BOTH = (Curve(_CURVE, "all orders", {"color": TOTAL, "linewidth": 2.0}),
         Curve(_short, "orders 1 and 2", {"color": COLOURS[1], "linestyle": "--"}))  # fmt: skip
PISTON_ACCELERATION = Curves(
    _title,
    (Panel("acceleration", _BOTH, needs=(_short,), height=2.0, legend={"loc": "lower center"}),
     Panel("difference\n", (Curve(_missed),), _largest)),
    high=2.55,
)  # fmt: skip

_EACH = Curve(over_turn("kinematics/cylinder/acceleration_harmonics"), "cylinder {}")
SLAVE_RODS = Curves(
    "pistons on master and slave rods over a turn", (Panel("acceleration", (_EACH,)),)
)
