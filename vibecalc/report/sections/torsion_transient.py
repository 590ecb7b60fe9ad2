"""A change in time of a shaft line: peaks of the sections beside the steady vibration."""

import numpy as np

from vibecalc.report.lookup import having, labels, scalar_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_terms import within
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

TRANSIENT = "response/torsion/transient/"


def torsion_transient(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(TRANSIENT))
    if not shown:
        return None
    lines = paragraph(change_in_words(result))
    lines += paragraph(
        "Crank speed as prescribed; torques with the mean, on the section's own shaft. A half "
        "range is that of one cycle, the steady one the largest between the same speeds."
    )
    supplied = _supplied(result)
    if supplied:
        lines += paragraph(supplied)
    verdict = _verdict(record)
    if verdict:
        lines += paragraph(verdict)
    lines += ["", *_table(record)]
    return Section("Change in time", lines, shown)


def change_in_words(result: Result) -> str:
    """What happens, in a sentence."""
    change = table_of(result.case, "response", "torsion", "transient")
    kind = str(change.get("kind", ""))

    def turns(key: str) -> str:
        return f"{show(rpm(float(change.get(key) or 0.0)), digits=5)} rpm"

    if kind in ("run_up", "run_down"):
        words = f"{kind.replace('_', '-').capitalize()} from {turns('from')} to {turns('to')}"
    elif kind == "start":
        words = f"Start from rest to {turns('to')}"
    elif kind == "load_step":
        words = (
            f"Step of the load by {show(float(change.get('torque') or 0.0))} N*m at "
            f"{change.get('on')}"
        )
    else:
        words = f"Cylinder {change.get('cylinder')} stops firing"
    acceleration, duration = change.get("acceleration"), change.get("duration")
    if acceleration is not None:
        words += (
            f" with up to {show(float(acceleration), digits=4)} rad/s^2, growing from zero "
            "at the beginning and fading to zero at the end"
        )
    elif duration is not None:
        words += f" in {show(float(duration), digits=4)} s"
    return words + "."


def _verdict(record: Record) -> str:
    peak = having(record, TRANSIENT + "peak", "section")
    speed = having(record, TRANSIENT + "peak_speed", "section")
    worst = scalar_of(record, TRANSIENT + "worst_section")
    if peak is None or speed is None or worst is None:
        return ""
    place = int(worst) - 1
    name = peak.axes[0].values[place]
    words = (
        f"Most loaded is section {name}: {show(float(peak.values[place]), digits=5)} N*m at "
        f"{show(rpm(float(speed.values[place])), digits=5)} rpm"
    )
    over = having(record, TRANSIENT + "overshoot", "section")
    if over is not None and np.isfinite(over.values[place]):
        share = 100.0 * float(over.values[place])
        side = "above" if share > 0.0 else "below"
        words += f"; its half range stays {show(abs(share), digits=3)} % {side} the steady one"
        if share > 0.0:
            words = words.replace("stays", "goes")
        lag = having(record, TRANSIENT + "lag", "section")
        if lag is not None:
            late = float(lag.values[place])
            if abs(late) > lag.error_estimate:
                when = "later" if late > 0.0 else "earlier"
                words += f" and comes {within(rpm(abs(late)), rpm(lag.error_estimate))} rpm {when}"
            else:
                words += f", at the same speed within {show(rpm(lag.error_estimate), digits=2)} rpm"
    factor = having(record, TRANSIENT + "dynamic_factor", "section")
    if factor is not None:
        words += (
            f", {show(float(factor.values[place]), digits=4)} times the larger of the steady peaks "
            "before and after"
        )
    return words + "."


def _supplied(result: Result) -> str:
    """The torque that speeds the line up, and where the case has to find it."""
    record = result.record
    whole = scalar_of(record, TRANSIENT + "acceleration_torque")
    given = scalar_of(record, TRANSIENT + "acceleration_supplied")
    if whole is None:
        return ""
    words = f"To change the speed of the line takes up to {show(abs(whole), digits=4)} N*m"
    words += " at the crankshaft's speed"
    mean = scalar_of(record, "response/torsion/excitation/mean_torque")
    if mean is not None:
        words += f"; the cylinders give {show(mean, digits=4)} N*m in the mean at operating speed"
    words += ". The speed is prescribed, so what the cylinders do not give is supplied"
    place = scalar_of(record, TRANSIENT + "acceleration_supplied_at")
    station = _station(record, place)
    words += f" at station {station!r}" if station else " where the load acts"
    if given is not None:
        words += f": {show(given, digits=4)} N*m on its own shaft, positive on the line"
    return words + ". This torque is in the peaks; the table has them without it too."


def _station(record: Record, place: float | None) -> str:
    known = having(record, "response/torsion/angle_half_range", "station")
    found = [] if known is None else labels(known.axes[0])
    return found[int(place) - 1] if place and 0 < place <= len(found) else ""


def _table(record: Record) -> list[str]:
    """A row for each section; a lag shows the digits that its error leaves."""
    quantities = {
        name: quantity
        for name in ("peak", "peak_time", "steady_before", "steady_after", "dynamic_factor",
                     "peak_without_acceleration", "peak_half_range", "steady_half_range",
                     "overshoot", "lag")
        if (quantity := having(record, TRANSIENT + name, "section")) is not None
    }  # fmt: skip
    first = quantities.get("peak")
    if first is None:
        return []
    ways: dict[str, tuple[str, float, int]] = {
        "peak": ("peak\nN*m", 1.0, 11), "peak_time": ("at\ns", 1.0, 8),
        "peak_without_acceleration": ("without\nits torque\nN*m", 1.0, 11),
        "steady_before": ("steady before\nN*m", 1.0, 14),
        "steady_after": ("steady after\nN*m", 1.0, 14), "dynamic_factor": ("factor", 1.0, 10),
        "peak_half_range": ("half range\nN*m", 1.0, 11),
        "steady_half_range": ("steady\nN*m", 1.0, 11),
        "overshoot": ("more than\nsteady, %", 100.0, 9), "lag": ("later by\nrpm", rpm(1.0), 13),
    }  # fmt: skip
    shown = [name for name in ways if name in quantities]
    if "steady_before" in quantities:
        shown = [name for name in shown if name not in ("peak_half_range", "steady_half_range",
                                                        "overshoot", "lag")]  # fmt: skip
    columns = [Column("section", 17)]
    columns += [number(ways[name][0], ways[name][2]) for name in shown]
    rows = []
    for i, label in enumerate(labels(first.axes[0])):
        row = [label]
        for name in shown:
            quantity, factor = quantities[name], ways[name][1]
            value, error = factor * float(quantity.values[i]), factor * quantity.error_estimate
            row.append(within(value, error) if name == "lag" else show(value, error, 5))
        rows.append(row)
    return table(columns, rows)
