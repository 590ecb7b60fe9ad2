"""A start-up or a change of load in time: crank speed, shell, torque; and where it starts from."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, QUIET, TOTAL, canvas, note
from vibecalc.core.report.sections import along, scalar_of, table_of
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/start_up/"
_RPM = 30.0 / np.pi
_WHOLE = 360.0


class _Row(NamedTuple):
    """A quantity with its name in words, and the unit of the picture with its factor."""

    name: str
    words: str
    unit: str
    factor: float
    colour: str


_ROWS = (
    _Row("crank_speed", "crank speed", "rpm", _RPM, COLOURS[0]),
    _Row("shell_angle", "shell angle", "mrad", 1e3, COLOURS[2]),
    _Row("shell_acceleration", "shell accel.", "rad/s$^2$", 1.0, COLOURS[3]),
    _Row("motor_torque", "motor torque", "N m", 1.0, COLOURS[1]),
    _Row("mount_torque", "mount torque", "N m", 1.0, COLOURS[5]),
)


def draw_roll_start_up(result: Result) -> "Figure | None":
    """A panel for each quantity over time, its envelope filled; None without a history.

    Below them, if they were looked for, the crank angles from which the machine starts.
    """
    record = result.record
    rows = [row for row in _ROWS if _moves(record, row.name)]
    angles = along(record, _STEM + "start_angles/lower", "start_interval")
    bar = angles is not None or f"{_STEM}start_angles/fraction" in record
    if not rows and not bar:
        return None
    count = len(rows) + bar
    heights = [1.35 if row.name == "crank_speed" else 1.0 for row in rows] + [0.3] * bar
    figure = canvas(result, _verdict(record), 1.5 + 1.5 * sum(heights))
    panels = list(figure.subplots(count, 1, height_ratios=heights, squeeze=False)[:, 0])
    for axes, row in zip(panels, rows, strict=False):
        _envelope(axes, record, row)
        _steps(axes, record, named=axes is panels[0])
    if rows:
        _speeds(panels[0], result, rows[0])
        for axes in panels[: len(rows) - 1]:
            axes.tick_params(labelbottom=False)
        panels[len(rows) - 1].set_xlabel("time in s")
        _moments(panels[: len(rows)], record)
    if bar:
        _start_angles(panels[-1], record)
    figure.align_ylabels(panels[: len(rows)])
    if panels[0].get_legend_handles_labels()[0]:
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _moves(record: Record, name: str) -> bool:
    """Whether there is a history that is not zero all the time."""
    ends = [along(record, f"{_STEM}history/{name}_{end}", "start_time") for end in ("low", "high")]
    return all(hit is not None and hit[1].size > 0 for hit in ends) and any(
        hit is not None and bool(np.any(np.asarray(hit[0].values) != 0.0)) for hit in ends
    )


def _verdict(record: Record) -> str:
    if f"{_STEM}started" not in record:
        return "crank angles from which it starts"
    if not scalar_of(record, _STEM + "started"):
        return "start-up: it does not start"
    settled = scalar_of(record, _STEM + "settled")
    return "start-up: it runs" + (" and settles" if settled else ", not yet settled")


def _envelope(axes: "Axes", record: Record, row: _Row) -> None:
    low, high = (
        along(record, f"{_STEM}history/{row.name}_{end}", "start_time") for end in ("low", "high")
    )
    assert low is not None and high is not None
    time = low[1]
    ends = [row.factor * np.asarray(hit[0].values, dtype=float) for hit in (low, high)]
    axes.fill_between(time, ends[0], ends[1], color=row.colour, alpha=0.85, linewidth=0.8)
    if np.min(ends[0]) < 0.5 * np.max(ends[1]):
        # a speed that hardly varies keeps its panel to itself
        axes.axhline(0.0, color=QUIET, linewidth=0.6)
    axes.set_xlim(0.0, float(time[-1]))
    axes.set_ylabel(f"{row.words}\nin {row.unit}")
    peak, when = (scalar_of(record, f"{_STEM}{row.name}_peak{end}") for end in ("", "_time"))
    if peak is None or when is None or row.name == "crank_speed":
        return
    place = int(np.clip(np.searchsorted(time, when), 0, len(time) - 1))
    sign = 1.0 if ends[1][place] >= -ends[0][place] else -1.0
    axes.plot([when], [sign * row.factor * peak], "o", color=TOTAL, ms=4.5, zorder=4)
    title = f"largest {show(row.factor * peak, digits=4)} {row.unit} at {show(when, digits=4)} s"
    axes.set_title(title, loc="right", fontsize=8, pad=2.0)


def _speeds(axes: "Axes", result: Result, row: _Row) -> None:
    """Mean speed of each turn, and that of the motor's field."""
    if row.name != "crank_speed":
        return
    begin = along(result.record, _STEM + "turn/begin", "turn")
    speed = along(result.record, _STEM + "turn/speed", "turn")
    if begin is not None and speed is not None and begin[1].size:
        mean = np.asarray(speed[0].values, dtype=float)
        middle = np.asarray(begin[0].values) + np.pi / mean
        axes.plot(middle, _RPM * mean, color=TOTAL, linewidth=1.1, label="mean of a turn")
    synchronous = table_of(result.case, "machine", "motor").get("synchronous_speed")
    if isinstance(synchronous, int | float):
        words = f"synchronous {show(rpm(float(synchronous)), digits=4)} rpm"
        axes.axhline(rpm(synchronous), color=LIMIT, linestyle=":", linewidth=1.2, label=words)


def _moments(panels: list["Axes"], record: Record) -> None:
    """When the running speed is reached, and from when on the shaking is settled."""
    for name, words, style in (
        ("time_to_speed", "at speed", "--"),
        ("time_to_steady", "settled", "-."),
    ):
        when = scalar_of(record, _STEM + name)
        if when is None or not np.isfinite(when) or when <= 0.0:
            continue
        for axes in panels:
            axes.axvline(when, color=TOTAL, linestyle=style, linewidth=1.0)
        note(panels[0], f"{words} {show(when, digits=4)} s",
            (when, 0.06 if name == "time_to_speed" else 0.45), (4, 0),
            xycoords=panels[0].get_xaxis_transform(),
            bbox=PLATE)  # fmt: skip


def _steps(axes: "Axes", record: Record, *, named: bool) -> None:
    """Where the load changes, and the factor on the gas forces from there on."""
    hit = along(record, _STEM + "load/factor", "load_step")
    if hit is None:
        return
    for when, factor in zip(hit[1], hit[0].values, strict=True):
        axes.axvline(float(when), color=LIMIT, linewidth=0.9, alpha=0.7)
        if named:
            note(axes, f"load x {float(factor):.3g}", (float(when), 1.0), (2, 2),
                xycoords=axes.get_xaxis_transform(), color=LIMIT)  # fmt: skip


def _start_angles(axes: "Axes", record: Record) -> None:
    """A bar over a turn, coloured where the machine starts from rest under its full load."""
    lower, upper = (
        along(record, f"{_STEM}start_angles/{end}", "start_interval") for end in ("lower", "upper")
    )
    axes.axvspan(0.0, _WHOLE, color="#e4e4e4", linewidth=0.0)
    if lower is not None and upper is not None:
        for low, high in zip(lower[0].values, upper[0].values, strict=True):
            for left, right in arcs(float(np.degrees(low)), float(np.degrees(high))):
                axes.axvspan(left, right, color=COLOURS[2], linewidth=0.0)
    axes.set_xlim(0.0, _WHOLE)
    axes.set_xticks(range(0, 361, 45))
    axes.set_yticks([])
    axes.grid(visible=False)
    axes.set_xlabel("crank angle of the start in deg")
    share = scalar_of(record, _STEM + "start_angles/fraction")
    words = "green: from there it starts, at rest and under its full load"
    if share is not None:
        words += f" ({show(100.0 * share, digits=4)} % of all angles)"
    axes.set_title(words, loc="left", fontsize=8)


def arcs(low: float, high: float) -> list[tuple[float, float]]:
    """An interval of angles in degrees as one or two parts within [0, 360]."""
    if high - low >= _WHOLE:
        return [(0.0, _WHOLE)]
    start = low % _WHOLE
    end = start + high - low
    return [(start, end)] if end <= _WHOLE else [(start, _WHOLE), (0.0, end - _WHOLE)]
