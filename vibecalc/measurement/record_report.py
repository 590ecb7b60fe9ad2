"""Orders of records in the report and as a picture."""

import math
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import COLOURS, canvas
from vibecalc.core.report.sections import Section, having, labels, section
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STEM = "measurement/record/"
_MOST = 24
#: channels, and harmonics of the curves over the speed, of a picture
_CHANNELS, _ORDERS = 6, 5
#: of the mean, what a speed may change by and still count as one
_STEADY = 0.01


def records(result: Result) -> Section | None:
    """Amplitude and phase of each channel and harmonic with what the blocks leave open."""
    record = result.record
    size = having(record, _STEM + "acceleration", "channel", "order")
    speed = having(record, _STEM + "block_speed", "channel", "block")
    if size is None or speed is None:
        return None
    parts = [
        having(record, _STEM + name, "channel", "order")
        for name in ("phase", "uncertainty", "phase_uncertainty")
    ]
    rows = []
    for i, channel in enumerate(labels(size.axes[0])):
        for j, order in enumerate(labels(size.axes[1])):
            phase, along, across = (
                0.0 if one is None else float(one.values[i, j]) for one in parts
            )
            rows.append(
                [
                    channel if j == 0 else "",
                    order,
                    show(abs(size.values[i, j]), size.error_estimate),
                    show(along, digits=2),
                    f"{math.degrees(phase):.2f}",
                    f"{math.degrees(across):.2g}",
                ]
            )
    columns = (
        Column("channel"),
        number("order"),
        number("m/s^2"),
        number("+-"),
        number("phase deg"),
        number("+-"),
    )
    lines = table(columns, rows[:_MOST])
    if len(rows) > _MOST:
        lines += paragraph(f"and {len(rows) - _MOST} more rows in the result file")
    low, high = (rpm(float(one)) for one in (np.min(speed.values), np.max(speed.values)))
    at = f"{show(low)} rpm" if show(low) == show(high) else f"{show(low)} to {show(high)} rpm"
    words = f"{speed.values.shape[1]} blocks of whole turns at {at}; +- is the standard uncertainty"
    words += " of the mean by scatter of blocks and angle; phases lead, against the first pulse"
    return section("Orders of the records", [lines + paragraph(words)])


def draw_record_orders(result: Result) -> "Figure | None":
    """Spectra of orders of each channel; over the speed, where the record runs through one."""
    lines = having(result.record, _STEM + "spectrum", "channel", "order_line")
    speed = having(result.record, _STEM + "block_speed", "channel", "block")
    blocks = having(result.record, _STEM + "block_acceleration", "channel", "block", "order")
    if lines is None or speed is None or blocks is None:
        return None
    names = labels(lines.axes[0])[:_CHANNELS]
    speeds = np.asarray(speed.values, dtype=float)
    runs = float(np.ptp(speeds)) > _STEADY * float(np.mean(speeds))
    figure = canvas(result, "orders of the records", 1.0 + 1.8 * len(names))
    panels = figure.subplots(len(names), 2 if runs else 1, squeeze=False, sharex="col")
    at = np.asarray(lines.axes[1].values, dtype=float)
    for place, name in enumerate(names):
        axes = panels[place, 0]
        axes.vlines(at[1:], 0.0, np.asarray(lines.values)[place, 1:], color=COLOURS[0], lw=1.0)
        axes.set_title(name, loc="left")
        axes.set_ylabel("m/s$^2$, 0-pk")
        axes.set_ylim(bottom=0.0)
        if runs:
            axes = panels[place, 1]
            for j, order in enumerate(labels(blocks.axes[2])[:_ORDERS]):
                values = np.abs(np.asarray(blocks.values)[place, :, j])
                axes.plot(rpm(1.0) * speeds[place], values, "o-", ms=2.5, color=COLOURS[j],
                          label=f"order {order}")  # fmt: skip
            axes.set_ylim(bottom=0.0)
    panels[-1, 0].set_xlabel("order")
    if runs:
        panels[-1, 1].set_xlabel("crank speed in rpm")
        handles, words = panels[0, 1].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=_ORDERS)
    return figure
