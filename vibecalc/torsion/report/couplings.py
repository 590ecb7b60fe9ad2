"""Elastic couplings of a shaft line: what they are taken as, what they bear, what is permitted."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import (
    Column,
    hertz,
    number,
    pairs,
    paragraph,
    rpm,
    show,
    table,
)
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.coupling_results import COUPLING, HEALTHY
from vibecalc.torsion.report.line import joined, line_of, short, turns

if TYPE_CHECKING:
    from vibecalc.torsion.couplings import Coupling

# ----------------------------------------------------------------------------
# Couplings at the operating speed and over the range, limit by limit.
# ----------------------------------------------------------------------------

ICE, _KILO, _TURN = 273.15, 1e-3, 2.0 * np.pi
BORNE = {
    "T_KN": "mean_torque",
    "T_Kmax": "peak_torque",
    "T_KW": "vibratory_torque",
    "T_KW by orders": "torque_by_orders",
    "P_KV": "power_loss",
    "n_max": "",
    "temperature": "temperature",
}
LIMIT_WORDS = {
    "T_KN": "mean torque, T_KN",
    "T_Kmax": "peak torque, T_Kmax",
    "T_KW": "vibratory torque, T_KW",
    "T_KW by orders": "  the same by orders",
    "P_KV": "power loss, P_KV",
    "n_max": "speed, n_max",
    "temperature": "temperature",
}


def torsion_couplings(result: Result) -> Section | None:
    """The section, None without couplings."""
    line = line_of(result)
    if line is None or not line.couplings or f"{COUPLING}/mean_torque" not in result.record:
        return None
    lines: list[str] = []
    for place, one in enumerate(line.couplings):
        lines += ["", *_identity(result, one, place)] if lines else _identity(result, one, place)
        lines += ["", *_limits(result, one, place)]
    use = having(result.record, f"{COUPLING}/use", "coupling", "coupling_limit")
    if use is not None and "T_KW" in labels(use.axes[1]):
        lines += ["", *paragraph(
            "T_KW holds at its own frequency, 10 Hz if the maker says no other; above it a "
            "vibratory torque counts sqrt(f / 10 Hz) times (DIN 740-2). The half range of all "
            "orders counts by the frequency of its largest order; by orders: root of the sum of "
            "squares, each order by its own frequency, which goes with the heat."
        )]  # fmt: skip
    return Section("Couplings", lines, frozenset())


def _identity(result: Result, one: "Coupling", place: int) -> list[str]:
    """Type, stiffness and damping at the operating speed, and the temperature."""
    record = result.record
    rows = [(one.name, one.type or "values of the case")]
    stiffness, loss, main = (
        np.asarray(record[f"{COUPLING}/{name}"].values)[place]
        if f"{COUPLING}/{name}" in record
        else None
        for name in ("stiffness", "loss_factor", "main_frequency")
    )
    order = having(record, f"{COUPLING}/stiffness", "coupling", "half_order")
    speed = speed_of(result)
    if stiffness is not None and loss is not None and main is not None and order and speed:
        at = int(np.argmin(np.abs(np.asarray(order.axes[1].values) * speed - main)))
        rows.append((
            "  dynamic stiffness",
            f"{show(_KILO * stiffness[at], digits=4)} kN m/rad at {short(hertz(main))} Hz, "
            f"relative damping {show(_TURN * loss[at], digits=4)}",
        ))  # fmt: skip
    follows = [
        words
        for words, rows_of in (
            ("mean torque", one.mean_torque),
            ("temperature", one.over_temperature),
            ("frequency", one.frequency),
            ("vibratory torque", one.amplitude),
        )
        if rows_of is not None
    ]
    if follows:
        rows.append(("  they follow", joined(follows)))
    heat = record.quantities.get(f"{COUPLING}/temperature")
    if one.temperature and heat is not None:
        found = float(np.asarray(heat.values)[place]) - ICE
        words = f"{show(found, digits=4)} degC"
        if one.resistance:
            air = one.temperature - ICE
            words += f", {show(air, digits=4)} degC about it and {one.resistance:.4g} K/W"
        rows.append(("  temperature", words))
    return pairs(rows)


def _limits(result: Result, one: "Coupling", place: int) -> list[str]:
    """A row for each limit that the maker says."""
    from vibecalc.torsion.couplings import LIMITS, has_limit

    record = result.record
    use = having(record, f"{COUPLING}/use", "coupling", "coupling_limit")
    if use is None:
        return paragraph("Its maker says no limits.")
    more = [
        (title, quantity, factor)
        for title, path, factor in (
            ("largest\n%", f"{COUPLING}/largest_use", 100.0),
            ("at\nrpm", f"{COUPLING}/largest_use_speed", 0.0),
            ("all fire\n%", f"{HEALTHY}/use", 100.0),
            ("largest\n%", f"{HEALTHY}/largest_use", 100.0),
        )
        if (quantity := having(record, path, "coupling", "coupling_limit")) is not None
    ]
    columns = [Column("limit"), number("permitted"), number("at speed"),
               number("use\n%"), *(number(title) for title, *_ in more)]  # fmt: skip
    said = dict(zip(LIMITS, has_limit(one), strict=True))
    rows = []
    for at, name in enumerate(labels(use.axes[1])):
        if not said[name]:
            continue
        cells = [_percent(use, (place, at))]
        for _, quantity, factor in more:
            value = float(quantity.values[place, at])
            cells.append(_percent(quantity, (place, at)) if factor else turns(value))
        allowed, unit = permitted(one, name)
        load = borne(result, name, place)
        load = allowed * float(use.values[place, at]) if name == "n_max" else load
        texts = ["" if one is None else f"{as_text(one, unit)} {unit}" for one in (allowed, load)]
        rows.append([LIMIT_WORDS[name], *texts, *cells])
    return table(columns, rows)


def _percent(quantity: Quantity, place: tuple[int, int]) -> str:
    value = 100.0 * float(quantity.values[place])
    return show(value, 100.0 * quantity.error_estimate, 4)


def permitted(one: "Coupling", name: str) -> tuple[float, str]:
    """What the maker permits by one of its limits, in the unit that people read."""
    may = one.permissible
    torque = {"T_KN": may.mean, "T_Kmax": may.peak}.get(name, may.vibratory)
    values = {"n_max": may.speed, "temperature": may.temperature, "P_KV": may.power}
    units = {"n_max": "rpm", "temperature": "degC", "P_KV": "W"}
    return _as_read(name, values.get(name, torque)), units.get(name, "kN m")


def as_text(value: float, unit: str) -> str:
    """Four digits; of turns without zeros at the end."""
    return short(value) if unit == "rpm" else show(value, digits=4)


def _as_read(name: str, value: float) -> float:
    if name == "n_max":
        return rpm(value)
    return value - ICE if name == "temperature" else value * (1.0 if name == "P_KV" else _KILO)


def borne(result: Result, name: str, place: int, speed: float | None = None) -> float | None:
    """What a coupling bears of it in the unit of `permitted`: operating, or at a speed in rad/s.

    None between the speeds of the curve.
    """
    path, axes = f"{COUPLING}/{BORNE[name]}", ["coupling"]
    if speed is not None:
        path, axes = f"{COUPLING}/speeds/{BORNE[name]}", ["coupling", "speed"]
    quantity, at = having(result.record, path, *axes), 0
    if quantity is not None and speed is not None:
        speeds = np.asarray(quantity.axes[1].values, dtype=float)
        at = int(np.argmin(np.abs(speeds - speed)))
        quantity = None if abs(speeds[at] - speed) > 1e-9 * speed else quantity
    return None if quantity is None else _as_read(name, np.ravel(quantity.values[place])[at])
