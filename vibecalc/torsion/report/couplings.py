"""Elastic couplings of a shaft line: what they are taken as, what they bear, what is permitted."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import (
    Column,
    as_text,
    hertz,
    number,
    pairs,
    paragraph,
    rpm,
    short,
    show,
    table,
    turns,
)
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.report.line import joined, line_of, place_of, titled
from vibecalc.torsion.study_results import COUPLING, HEALTHY

if TYPE_CHECKING:
    from vibecalc.torsion.couplings import Coupling

# ----------------------------------------------------------------------------
# Couplings at the operating speed and over the range, limit by limit.
# ----------------------------------------------------------------------------

ICE, _KILO, _TURN = 273.15, 1e-3, 2.0 * np.pi
#: limit -> name of what is borne of it, and its words
BORNE = {
    "T_KN": ("mean_torque", "mean torque, T_KN"),
    "T_Kmax": ("peak_torque", "peak torque, T_Kmax"),
    "T_KW": ("vibratory_torque", "vibratory torque, T_KW"),
    "T_KW by orders": ("torque_by_orders", "  by orders"),
    "P_KV": ("power_loss", "power loss, P_KV"),
    "n_max": ("", "speed, n_max"),
    "temperature": ("temperature", "temperature"),
}
_UNITS = {"n_max": "rpm", "temperature": "degC", "P_KV": "W"}
_FREQUENCY = (
    "T_KW applies at its reference frequency, 10 Hz unless the manufacturer gives another; above "
    "it the vibratory torque is multiplied by sqrt(f / 10 Hz) (DIN 740-2). Half range of all "
    "orders: f of the largest order. By orders: root of the sum of squares, each at its own f, as "
    "for the heat."
)


def torsion_couplings(result: Result) -> Section | None:
    """The section, None without couplings."""
    line = line_of(result)
    if line is None or f"{COUPLING}/mean_torque" not in result.record:
        return None
    blocks = [[*_identity(result, one, place), *_limits(result, one, place)]
              for place, one in enumerate(line.couplings)]  # fmt: skip
    use = having(result.record, f"{COUPLING}/utilisation", "coupling", "coupling_limit")
    if use is not None and "T_KW" in labels(use.axes[1]):
        blocks.append(paragraph(_FREQUENCY))
    return titled(result, "Couplings", *blocks)


def _identity(result: Result, one: "Coupling", place: int) -> list[str]:
    """Type, stiffness and damping at the operating speed, and the temperature."""
    record = result.record
    rows = [(one.name, one.type or "values of the case")]
    order = having(record, f"{COUPLING}/stiffness", "coupling", "order")
    loss = having(record, f"{COUPLING}/loss_factor", "coupling", "order")
    main = having(record, f"{COUPLING}/main_frequency", "coupling")
    speed = speed_of(result)
    if loss is not None and main is not None and order and speed:
        frequency = float(main.values[place])
        at = int(np.argmin(np.abs(np.asarray(order.axes[1].values) * speed - frequency)))
        rows.append((
            "  dynamic stiffness",
            f"{show(_KILO * order.values[place, at])} kN m/rad at {short(hertz(frequency))} Hz, "
            f"relative damping {show(_TURN * loss.values[place, at])}",
        ))  # fmt: skip
    laws = {"mean torque": one.mean_torque, "temperature": one.over_temperature,
            "frequency": one.frequency, "vibratory torque": one.amplitude}  # fmt: skip
    if follows := [words for words, law in laws.items() if law is not None]:
        rows.append(("  both depend on", joined(follows)))
    warm = borne(result, "temperature", place)
    if warm is not None:
        words = f"{show(warm)} degC"
        if one.resistance:
            words += f", ambient {show(one.temperature - ICE)} degC, {one.resistance:.4g} K/W"
        rows.append(("  temperature", words))
    return pairs(rows)


def _limits(result: Result, one: "Coupling", place: int) -> list[str]:
    """A row for each limit that the maker says."""
    from vibecalc.torsion.couplings import LIMITS, has_limit

    use = having(result.record, f"{COUPLING}/utilisation", "coupling", "coupling_limit")
    if use is None:
        return paragraph("No limits given by the manufacturer.")
    shown = [
        (number(title), quantity)
        for title, path in (
            ("util.\n%", f"{COUPLING}/utilisation"),
            ("largest\n%", f"{COUPLING}/largest_utilisation"),
            ("at\nrpm", f"{COUPLING}/largest_utilisation_speed"),
            ("all fire\n%", f"{HEALTHY}/utilisation"),
            ("largest\n%", f"{HEALTHY}/largest_utilisation"),
        )
        if (quantity := having(result.record, path, *(axis.name for axis in use.axes))) is not None
    ]
    said = dict(zip(LIMITS, has_limit(one.permissible), strict=True))
    rows = []
    for at, name in enumerate(labels(use.axes[1])):
        if not said[name]:
            continue
        allowed, unit = permitted(one, name)
        load = borne(result, name, place)
        load = allowed * float(use.values[place, at]) if name == "n_max" else load
        texts = ["" if one is None else f"{as_text(one, unit)} {unit}" for one in (allowed, load)]
        cells = [_cell(quantity, (place, at)) for _, quantity in shown]
        rows.append([BORNE[name][1], *texts, *cells])
    heads = [Column("limit"), number("permitted"), number("at speed")]
    return table([*heads, *(head for head, _ in shown)], rows)


def _cell(quantity: Quantity, place: tuple[int, int]) -> str:
    value = float(quantity.values[place])
    if quantity.unit == "rad/s":
        return turns(value)
    return show(100.0 * value, 100.0 * quantity.error_estimate)


def permitted(one: "Coupling", name: str) -> tuple[float, str]:
    """What the maker permits by one of its limits, in the unit that people read."""
    may = one.permissible
    values = {"T_KN": may.mean, "T_Kmax": may.peak, "n_max": may.speed,
              "temperature": may.temperature, "P_KV": may.power}  # fmt: skip
    return _as_read(name, values.get(name, may.vibratory)), _UNITS.get(name, "kN m")


def _as_read(name: str, value: float) -> float:
    if name == "n_max":
        return rpm(value)
    return value - ICE if name == "temperature" else value * (1.0 if name == "P_KV" else _KILO)


def borne(result: Result, name: str, place: int, speed: float | None = None) -> float | None:
    """What a coupling bears of it in the unit of `permitted`: operating, or at a speed in rad/s.

    None between the speeds of the curve.
    """
    over = "" if speed is None else "speeds/"
    path = f"{COUPLING}/{over}{BORNE[name][0]}"
    quantity, line = (
        having(result.record, path, "coupling", *["speed"] * bool(over)),
        line_of(result),
    )
    if quantity is None or line is None:
        return None
    # temperatures are not known of all couplings
    at = place_of(quantity, line.couplings[place].name)
    if at is None:
        return None
    values = np.ravel(quantity.values[at])
    if speed is None:
        return _as_read(name, values[0])
    near = np.isclose(quantity.axes[1].values, speed, rtol=1e-9, atol=0.0)
    return _as_read(name, values[near][0]) if near.any() else None
