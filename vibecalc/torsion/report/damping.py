"""Dampings of a shaft line that follow speed, load or a mode: each with its law."""

from collections.abc import Mapping
from typing import Any

from vibecalc.core.report.sections import Section, having, labels, table_of
from vibecalc.core.report.writing import Column, number, paragraph, table
from vibecalc.core.results.record import Result
from vibecalc.torsion.report.line import TORSION, cell, short, titled, together, turns
from vibecalc.torsion.speed_damping import ARCHER

# ----------------------------------------------------------------------------
# Which damping each station and shaft has: its law, and its value at the operating speed.
# ----------------------------------------------------------------------------


def torsion_damping(result: Result) -> Section | None:
    """The section, None where all dampings are numbers of the case."""
    record, line = result.record, table_of(result.case, "machine", "shaft_line")
    station = having(record, TORSION + "damping/station", "station")
    dashpot, loss = (
        having(record, f"{TORSION}damping/{name}", "section") for name in ("section", "loss_factor")
    )
    if station is None:
        return None
    rows = [
        [name, "; ".join(_of_station(line, given)), cell(station, place), ""]
        for place, (name, given) in enumerate(
            zip(labels(station.axes[0]), line["stations"], strict=True)
        )
        if station.values[place]
    ]
    shafts = list(line.get("shafts") or ())
    for place, name in enumerate(labels(dashpot.axes[0]) if dashpot is not None else ()):
        values = [cell(one, place) if one is not None and one.values[place] else ""
                  for one in (dashpot, loss)]  # fmt: skip
        if any(values):
            words = _of_shaft(shafts[place]) if place < len(shafts) else "as given"
            rows.append([name, words, *values])
    columns = Column("part"), Column("damping"), number("N m s/rad"), number("loss\nfactor")
    words = (
        "Values at the operating speed, actual, not referred. T is the mean torque that the load "
        "takes, n its speed in rpm, w in rad/s; J the inertia of the station."
    )
    return titled(result, "Damping", [*table(columns, together(rows)), *paragraph(words)])


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
    mode = given.get("mode")
    w = f"w of mode {mode}" if mode else "w of the lowest elastic mode"
    for key, law in (
        ("magnifier", "J w / M, magnifier M = {}"),
        ("damping_ratio", "2 D J w, Lehr's D = {}"),
        ("loss_factor", "d J w, loss factor d = {}"),
    ):
        if given.get(key) is not None:
            return f"engine, {law.format(short(given[key]))}, {w}"
    return "engine, viscous"


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
    laws = {
        "damping": "viscous",
        "damping_ratio": "ratio {} of its two neighbours",
        "magnifier": "magnifier {}",
        "lehr_ratio": "Lehr's ratio {}",
        "loss_factor": "loss factor",
    }
    found = [words.format(short(given[key])) for key, words in laws.items() if given.get(key)]
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
