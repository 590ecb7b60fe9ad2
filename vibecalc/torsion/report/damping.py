"""Dampings of a shaft line that follow speed, load or a mode: each with its law."""

from collections.abc import Mapping
from typing import Any

from vibecalc.core.report.sections import Section, having, labels, table_of
from vibecalc.core.report.writing import Column, number, paragraph, table
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.damping_tables import ARCHER
from vibecalc.torsion.report.line import TORSION, cell, short, together, turns

# ----------------------------------------------------------------------------
# Which damping each station and shaft has: its law, and its value at the operating speed.
# ----------------------------------------------------------------------------


def torsion_damping(result: Result) -> Section | None:
    """The section, None where all dampings are numbers of the case."""
    record = result.record
    station = having(record, TORSION + "damping/station", "station")
    if station is None:
        return None
    dashpot = having(record, TORSION + "damping/section", "section")
    loss = having(record, TORSION + "damping/loss_factor", "section")
    line = table_of(result.case, "machine", "shaft_line")
    columns = [Column("part"), Column("damping"), number("N m s/rad"),
               number("loss\nfactor")]  # fmt: skip
    rows = [
        [name, "; ".join(_of_station(line, given)), cell(station, place, 1.0), ""]
        for place, (name, given) in enumerate(
            zip(labels(station.axes[0]), line.get("stations") or (), strict=True)
        )
        if station.values[place]
    ]
    shafts = list(line.get("shafts") or ())
    for place, name in enumerate(labels(dashpot.axes[0]) if dashpot is not None else ()):
        values = [_some(one, place) for one in (dashpot, loss)]
        if any(values):
            words = _of_shaft(shafts[place]) if place < len(shafts) else "as given"
            rows.append([name, words, *values])
    words = (
        "Values at the operating speed, actual, not referred. T is the mean torque that the load "
        "takes, n its speed in rpm, w in rad/s; J the inertia of the station."
    )
    return Section("Damping", [*table(columns, together(rows)), *paragraph(words)], frozenset())


def _some(quantity: Quantity | None, place: int) -> str:
    return cell(quantity, place, 1.0) if quantity is not None and quantity.values[place] else ""


def _of_station(line: Mapping[str, Any], station: Mapping[str, Any]) -> list[str]:
    """The laws of a station in words, each with its source."""
    found = []
    if station.get("absolute_damping"):
        found.append("as given" + _over(station.get("over_speed")))
    engine = line.get("engine_damping")
    if engine and (station.get("cylinder") or station.get("cylinders")):
        found.append(_of_engine(engine) + _over(engine.get("over_speed")))
    for load in line.get("loads") or ():
        if load["on"] == station["name"] and load.get("propeller_damping"):
            found.append(_of_propeller(load))
    return found


def _of_engine(given: Mapping[str, Any]) -> str:
    if given.get("damping") is not None:
        return "engine, viscous"
    mode = given.get("mode")
    w = f"w of mode {mode}" if mode else "w of the lowest elastic mode"
    if given.get("magnifier") is not None:
        return f"engine, J w / M, magnifier M = {short(given['magnifier'])}, {w}"
    if given.get("damping_ratio") is not None:
        return f"engine, 2 D J w, Lehr's D = {short(given['damping_ratio'])}, {w}"
    return f"engine, d J w, loss factor d = {short(given['loss_factor'])}, {w}"


def _of_propeller(load: Mapping[str, Any]) -> str:
    given, power = load["propeller_damping"], load.get("exponent") or 0.0
    torque = "T of a table" if load.get("curve") else f"T as speed^{power:g}"
    factor = given.get("coefficient")
    if given["method"] == "archer":
        return f"Archer (1951), a T / n, a = {short(factor or ARCHER)}, {torque}"
    if given["method"] == "slope":
        return f"slope of the load, {power:g} T / w, {torque}"
    return f"{short(factor)} T / w, {torque}"


def _of_shaft(given: Mapping[str, Any]) -> str:
    found = []
    if given.get("damping"):
        found.append("viscous")
    if given.get("damping_ratio"):
        found.append(f"ratio {short(given['damping_ratio'])} of its two neighbours")
    if given.get("magnifier"):
        found.append(f"magnifier {short(given['magnifier'])}")
    if given.get("lehr_ratio"):
        found.append(f"Lehr's ratio {short(given['lehr_ratio'])}")
    if given.get("loss_factor"):
        found.append("loss factor")
    return ", ".join(found) + _over(given.get("over_speed"))


def _over(given: Mapping[str, Any] | None) -> str:
    """How it follows the speed."""
    if not given:
        return ""
    whose = "own speed" if given.get("of") == "own" else "speed"
    if given.get("exponent") is not None:
        return f", {whose}^{given['exponent']:g} from {turns(given['reference'])} rpm"
    factor, speed = (given["table"][key] for key in ("factor", "speed"))
    ends = f"{turns(speed[0])} to {turns(speed[-1])} rpm"
    return f", times {short(factor[0])} to {short(factor[-1])} over {ends} {whose}".replace(
        " rpm speed", " rpm"
    )
