"""A start-up or a change of load in time: crank speed, shell, torque; and where it starts from."""

from functools import partial
from typing import Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, TOTAL, note
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, Plot, level
from vibecalc.core.report.sections import along, having, scalar_of, table_of
from vibecalc.core.report.sources import Source
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Axis, Quantity, Record, Result

_STEM = "response/start_up/"
_WHOLE = 360.0


def _histories(name: str) -> tuple[Source, Source]:
    """Ends of the envelope of a quantity that is not zero all the time."""

    def end(which: str) -> Source:
        path = f"{_STEM}history/{name}_{which}"

        def made(result: Result) -> Quantity | None:
            both = [having(result.record, f"{_STEM}history/{name}_{one}", "start_time")
                    for one in ("low", "high")]  # fmt: skip
            moves = any(one is not None and np.any(one.values != 0.0) for one in both)
            there = moves and all(one is not None for one in both)
            return result.record.quantities[path] if there else None

        return made

    return end("low"), end("high")


def _verdict(record: Record) -> str:
    if f"{_STEM}started" not in record:
        return "crank angles with a start"
    if not scalar_of(record, _STEM + "started"):
        return "start-up: does not start"
    settled = scalar_of(record, _STEM + "settled")
    return "start-up: runs" + (" and settles" if settled else ", not yet settled")


def _peak(plot: Plot, name: str) -> None:
    """A dot at the largest, on the side where it is, and its words above."""
    found = [scalar_of(plot.result.record, f"{_STEM}{name}_peak{end}") for end in ("", "_time")]
    if found[0] is None or found[1] is None:
        return
    height, when = plot.factor * found[0], found[1]
    (time, low), (_, high) = plot.drawn
    place = int(np.clip(np.searchsorted(time, when), 0, len(time) - 1))
    sign = 1.0 if high[place] >= -low[place] else -1.0
    plot.axes.plot([when], [sign * height], "o", color=TOTAL, ms=4.5, zorder=4)
    words = f"largest {show(height, digits=4)} {plot.unit} at {show(when, digits=4)} s"
    plot.axes.set_title(words, loc="right", fontsize=8, pad=2.0)


def _turns(plot: Plot) -> None:
    """Mean speed of each turn."""
    begin, speed = (
        having(plot.result.record, f"{_STEM}turn/{name}", "turn") for name in ("begin", "speed")
    )
    if begin is not None and speed is not None:
        mean = np.asarray(speed.values, dtype=float)
        plot.axes.plot(begin.values + np.pi / mean, plot.factor * mean, color=TOTAL, linewidth=1.1,
                       label="mean of a turn")  # fmt: skip


def _synchronous(result: Result) -> Any:
    return table_of(result.case, "machine", "motor").get("synchronous_speed")


def _moments(plot: Plot, named: bool = False) -> None:
    """When the running speed is reached, from when on the shaking is settled, the load changes."""
    upright = plot.axes.get_xaxis_transform()
    for name, words, style, height in (
        ("time_to_speed", "at speed", "--", 0.06), ("time_to_steady", "settled", "-.", 0.45)
    ):  # fmt: skip
        when = scalar_of(plot.result.record, _STEM + name)
        if when is None or not np.isfinite(when) or when <= 0.0:
            continue
        plot.axes.axvline(when, color=TOTAL, linestyle=style, linewidth=1.0)
        if named:
            note(plot.axes, f"{words} {show(when, digits=4)} s", (when, height), (4, 0),
                 xycoords=upright, bbox=PLATE)  # fmt: skip
    hit = along(plot.result.record, _STEM + "load/factor", "load_step")
    for at, factor in zip(hit[1], hit[0].values, strict=True) if hit else ():
        plot.axes.axvline(float(at), color=LIMIT, linewidth=0.9, alpha=0.7)
        if named:
            note(plot.axes, f"load x {float(factor):.3g}", (float(at), 1.0), (2, 2),
                 xycoords=upright, color=LIMIT)  # fmt: skip


def _panel(name: str, words: str, unit: str, colour: str) -> Panel:
    low, high = _histories(name)
    look = {"color": colour, "alpha": 0.85, "linewidth": 0.8}
    named = name == "crank_speed"
    parts: tuple[Mark, ...] = (Curve(low, "", look, upto=high), partial(_moments, named=named))
    if not named:
        parts += (partial(_peak, name=name),)
    else:
        parts += (_turns, level(_synchronous, "synchronous {}", color=LIMIT, linestyle=":"))
    return Panel(f"{words}\n", parts, unit=unit, height=1.35 if named else 1.0, below="time in s")


def _turn(result: Result) -> Quantity | None:
    """The turn that the bar stands over, if angles of the start were looked for."""
    stem = f"{_STEM}start_angles/"
    if stem + "lower" not in result.record and stem + "fraction" not in result.record:
        return None
    angle = Axis(name="crank_angle", values=np.radians([0.0, _WHOLE]), unit="rad")
    return Quantity(path="", values=np.zeros(2), unit="", long_name="", axes=(angle,))


def _start_angles(plot: Plot) -> None:
    """A bar over a turn, coloured where the machine starts from rest under its full load."""
    axes, record = plot.axes, plot.result.record
    lower, upper = (
        along(record, f"{_STEM}start_angles/{end}", "start_interval") for end in ("lower", "upper")
    )
    axes.axvspan(0.0, _WHOLE, color="#e4e4e4", linewidth=0.0)
    if lower is not None and upper is not None:
        for low, high in zip(lower[0].values, upper[0].values, strict=True):
            for left, right in arcs(float(np.degrees(low)), float(np.degrees(high))):
                axes.axvspan(left, right, color=COLOURS[2], linewidth=0.0)
    axes.set_yticks([])
    axes.grid(visible=False)
    share = scalar_of(record, _STEM + "start_angles/fraction")
    words = "green: starts from rest under full load"
    if share is not None:
        words += f" ({show(100.0 * share, digits=4)} % of all angles)"
    axes.set_title(words, loc="left", fontsize=8)


ROLL_START_UP = Curves(
    lambda result: _verdict(result.record),
    (
        _panel("crank_speed", "crank speed", "rpm", COLOURS[0]),
        _panel("shell_angle", "shell angle", "mrad", COLOURS[2]),
        _panel("shell_acceleration", "shell accel.", "rad/s^2", COLOURS[3]),
        _panel("motor_torque", "motor torque", "N*m", COLOURS[1]),
        _panel("mount_torque", "mount torque", "N*m", COLOURS[5]),
        Panel(
            "",
            (Curve(_turn, look={"linewidth": 0.0, "marker": ""}), _start_angles),
            height=0.3,
            below="crank angle at start in deg",
        ),
    ),
    high=1.55,
    names=2,
)


def arcs(low: float, high: float) -> list[tuple[float, float]]:
    """An interval of angles in degrees as one or two parts within [0, 360]."""
    if high - low >= _WHOLE:
        return [(0.0, _WHOLE)]
    start = low % _WHOLE
    end = start + high - low
    return [(start, end)] if end <= _WHOLE else [(start, _WHOLE), (0.0, end - _WHOLE)]
