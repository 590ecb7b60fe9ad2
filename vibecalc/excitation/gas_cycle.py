"""Computed pressure cards, for an engine whose pressure nobody has measured.

Compression is polytropic from the closing of the inlet on. Combustion passes over from it to the
expansion of a cycle with all heat at top dead centre (spark: Otto) or with a level pressure up to
the end of the injection (diesel: limited pressure), by a share B that rises smoothly from 0 to 1:

    p = (1 - B) p_compression + B level g,

g being 1 at the top and falling polytropically. The way to interpolate between the two is that of
Eriksson and Andersson (2002), An analytic model for cylinder pressure in a four stroke SI engine,
SAE 2002-01-0371; the shape of B and the diesel's plateau are ours. As the pressure is linear in the
level, a peak pressure or a mean indicated pressure gives it without iteration.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import CrankGeometry, gas_harmonics
from vibecalc.excitation.gas_card import FOUR_STROKE, TWO_STROKE, GasCard, fitted_card
from vibecalc.kinematics.dead_centres import piston_displacement, stroke
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray

PI = float(np.pi)
#: samples of the search for the largest pressure, and halvings of the interval around it
PEAK_SAMPLES = 512
PEAK_ROUNDS = 60


class Cycle(NamedTuple):
    """What a computed card is made of. Pressures absolute in Pa, angles in rad from firing.

    `inlet_closes` < `combustion_starts` < `combustion_ends` < `exhaust_opens`, the latter below pi,
    the first at -pi or later (two-stroke: later). Combustion ends where the share B reaches 1. A
    diesel holds its level until `injection_ends`, between that and the exhaust. From the opening of
    the exhaust to bottom dead centre the pressure passes over to `exhaust_pressure`, then to
    `intake_pressure`: around the charge exchange, within `overlap` on both sides (four-stroke), or
    from bottom dead centre to the closing of the inlet (two-stroke). `crankcase_pressure` is
    subtracted from all.
    """

    stroke: Literal["four_stroke", "two_stroke"]
    kind: Literal["spark", "diesel"]
    compression_ratio: float
    intake_pressure: float
    exhaust_pressure: float
    compression_exponent: float
    expansion_exponent: float
    combustion_starts: float
    combustion_ends: float
    injection_ends: float
    inlet_closes: float
    exhaust_opens: float
    overlap: float
    crankcase_pressure: float


def spark_cycle(
    stroke_kind: Literal["four_stroke", "two_stroke"] = "four_stroke",
    *,
    compression_ratio: float = 9.0,
    intake_pressure: float = 0.9e5,
    exhaust_pressure: float = 1.1e5,
    compression_exponent: float = 1.32,
    expansion_exponent: float = 1.28,
    combustion_starts: float = -np.radians(20.0),
    combustion_ends: float = np.radians(40.0),
    inlet_closes: float | None = None,
    exhaust_opens: float | None = None,
    overlap: float = np.radians(15.0),
    crankcase_pressure: float = 101325.0,
) -> Cycle:
    """A spark ignition cycle with usual values; see `Cycle`."""
    closes, opens = _valves(stroke_kind, inlet_closes, exhaust_opens)
    return Cycle(
        stroke_kind, "spark", compression_ratio, intake_pressure, exhaust_pressure,
        compression_exponent, expansion_exponent, combustion_starts, combustion_ends, 0.0,
        closes, opens, overlap, crankcase_pressure,
    )  # fmt: skip


def diesel_cycle(
    stroke_kind: Literal["four_stroke", "two_stroke"] = "four_stroke",
    *,
    compression_ratio: float = 15.0,
    intake_pressure: float = 2.0e5,
    exhaust_pressure: float = 1.8e5,
    compression_exponent: float = 1.36,
    expansion_exponent: float = 1.30,
    combustion_starts: float = -np.radians(8.0),
    combustion_ends: float = np.radians(14.0),
    injection_ends: float = np.radians(14.0),
    inlet_closes: float | None = None,
    exhaust_opens: float | None = None,
    overlap: float = np.radians(30.0),
    crankcase_pressure: float = 101325.0,
) -> Cycle:
    """A diesel cycle of limited pressure with usual values; see `Cycle`.

    `injection_ends` before `combustion_ends` counts as there: the plateau is as long as the share B
    still rises.
    """
    closes, opens = _valves(stroke_kind, inlet_closes, exhaust_opens)
    return Cycle(
        stroke_kind, "diesel", compression_ratio, intake_pressure, exhaust_pressure,
        compression_exponent, expansion_exponent, combustion_starts, combustion_ends,
        max(injection_ends, combustion_ends), closes, opens, overlap, crankcase_pressure,
    )  # fmt: skip


def card_of_peak(cycle: Cycle, geometry: CrankGeometry, peak_pressure: float) -> GasCard:
    """Card whose largest absolute pressure is `peak_pressure`, Pa.

    Every angle of the combustion allows the level up to (peak - (1 - B) p_compression) / (B g), so
    the least of these is the level at which one of them just reaches the peak.

    Raises
    ------
    NumericalFailure
        The compression alone goes higher than that where combustion takes over.
    """
    base, unit = _parts(cycle, geometry)
    low, high = cycle.combustion_starts, cycle.exhaust_opens
    # the expansion only falls
    grid = np.linspace(low, max(cycle.combustion_ends, cycle.injection_ends, 0.0), PEAK_SAMPLES)
    highest = float(base(np.linspace(cycle.inlet_closes, low, PEAK_SAMPLES)).max())
    highest = max(highest, float(base(grid).max()))
    if not peak_pressure > highest:
        raise NumericalFailure(
            f"gas cycle: a peak pressure of {peak_pressure:.6g} Pa is not above what the "
            f"compression alone reaches, {highest:.6g} Pa; raise it, let combustion start "
            "earlier or lower the compression ratio"
        )

    def allowed(angle: FloatArray) -> FloatArray:
        share = unit(angle)
        room = np.where(share > 0.0, share, 1.0)
        return np.where(share > 0.0, (peak_pressure - base(angle)) / room, np.inf)

    for _ in range(PEAK_ROUNDS):
        best = int(np.argmin(allowed(grid)))
        left, right = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        if right - left < 1e-9 * (high - low):
            break
        grid = np.linspace(left, right, 17)
    return _card(cycle, base, unit, float(allowed(grid).min()))


def card_of_mean_pressure(
    cycle: Cycle, geometry: CrankGeometry, mean_indicated_pressure: float
) -> GasCard:
    """Card whose work is `mean_indicated_pressure`, Pa, times the swept volume.

    Raises
    ------
    NumericalFailure
        So little work that the level would have to be below zero.
    """
    base, unit = _parts(cycle, geometry)
    without = mean_pressure(_card(cycle, base, unit, 0.0), geometry)
    level = cycle.intake_pressure * cycle.compression_ratio
    gain = mean_pressure(_card(cycle, base, unit, level), geometry)
    per_level = (gain.value - without.value) / level
    found = float((mean_indicated_pressure - without.value) / per_level)
    if not found > 0.0:
        raise NumericalFailure(
            f"gas cycle: a mean indicated pressure of {mean_indicated_pressure:.6g} Pa is below "
            "what the cycle has without any pressure after combustion; raise it"
        )
    return _card(cycle, base, unit, found)


def motored_cycle(cycle: Cycle, geometry: CrankGeometry) -> GasCard:
    """Card of the same cylinder without combustion: the charge expands as it was compressed."""

    def pressure(angle: FloatArray) -> FloatArray:
        closed = _compression(cycle, geometry, angle)
        return _gas_exchange(cycle, closed, angle) - cycle.crankcase_pressure

    return fitted_card(pressure, _breakpoints(cycle), _length(cycle))


def mean_pressure(card: GasCard, geometry: CrankGeometry) -> WithError:
    """Mean indicated pressure, Pa: the work of one cycle over the swept volume."""
    _, mean = gas_harmonics(card, geometry, np.empty(0))
    way = stroke(geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset)
    factor = card.cycle / (geometry.piston_area * float(way))
    return WithError(mean.value * factor, mean.error * factor + 8e-16 * np.abs(mean.value * factor))


def cylinder_volume(
    geometry: CrankGeometry, compression_ratio: float, angle: FloatArray
) -> FloatArray:
    """Volume above the piston over the clearance volume: 1 at the top, the ratio at the bottom."""
    radius, length, offset = geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset
    way = piston_displacement(angle, radius, length, offset).value
    return np.asarray(1.0 + (compression_ratio - 1.0) * way / stroke(radius, length, offset))


def smooth_step(share: FloatArray) -> FloatArray:
    """Rise from 0 to 1 over 0 .. 1 with two smooth derivatives at both ends."""
    x = np.clip(share, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (6.0 * x - 15.0)))


def _parts(
    cycle: Cycle, geometry: CrankGeometry
) -> tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FloatArray]]:
    """(1 - B) p_compression and B g of the closed cylinder, absolute, against the angle."""
    burning = cycle.combustion_ends - cycle.combustion_starts

    def burnt(angle: FloatArray) -> FloatArray:
        return smooth_step((angle - cycle.combustion_starts) / burning)

    def base(angle: FloatArray) -> FloatArray:
        return (1.0 - burnt(angle)) * _compression(cycle, geometry, angle)

    def unit(angle: FloatArray) -> FloatArray:
        volume = cylinder_volume(geometry, cycle.compression_ratio, angle)
        if cycle.kind == "diesel":
            held = np.asarray(cycle.injection_ends)
            volume = volume / cylinder_volume(geometry, cycle.compression_ratio, held)
            volume = np.where(angle <= cycle.injection_ends, 1.0, volume)
        return np.asarray(burnt(angle) * volume**-cycle.expansion_exponent)

    return base, unit


def _compression(cycle: Cycle, geometry: CrankGeometry, angle: FloatArray) -> FloatArray:
    start = cylinder_volume(geometry, cycle.compression_ratio, np.asarray(cycle.inlet_closes))
    volume = cylinder_volume(geometry, cycle.compression_ratio, angle)
    return np.asarray(cycle.intake_pressure * (start / volume) ** cycle.compression_exponent)


def _card(
    cycle: Cycle,
    base: Callable[[FloatArray], FloatArray],
    unit: Callable[[FloatArray], FloatArray],
    level: float,
) -> GasCard:
    def pressure(angle: FloatArray) -> FloatArray:
        closed = base(angle) + level * unit(angle)
        return _gas_exchange(cycle, closed, angle) - cycle.crankcase_pressure

    return fitted_card(pressure, _breakpoints(cycle), _length(cycle))


def _gas_exchange(cycle: Cycle, closed: FloatArray, angle: FloatArray) -> FloatArray:
    """Pressure of the closed cylinder up to the exhaust, then passing over to the manifolds'."""
    end = cycle.inlet_closes + _length(cycle)
    blown = smooth_step((angle - cycle.exhaust_opens) / (PI - cycle.exhaust_opens))
    if cycle.stroke == "four_stroke":
        middle, half = 2.0 * PI, cycle.overlap
        filled = smooth_step((angle - middle + half) / (2.0 * half))
    else:
        filled = smooth_step((angle - PI) / (end - PI))
    outside = cycle.exhaust_pressure + filled * (cycle.intake_pressure - cycle.exhaust_pressure)
    return np.asarray((1.0 - blown) * closed + blown * outside)


def _breakpoints(cycle: Cycle) -> list[float]:
    inside = {cycle.combustion_starts, cycle.combustion_ends, cycle.exhaust_opens, PI}
    if cycle.kind == "diesel":
        inside.add(cycle.injection_ends)
    if cycle.stroke == "four_stroke":
        inside |= {2.0 * PI - cycle.overlap, 2.0 * PI + cycle.overlap}
    return [cycle.inlet_closes, *sorted(inside), cycle.inlet_closes + _length(cycle)]


def _length(cycle: Cycle) -> float:
    return FOUR_STROKE if cycle.stroke == "four_stroke" else TWO_STROKE


def _valves(kind: str, closes: float | None, opens: float | None) -> tuple[float, float]:
    """Four-stroke: bottom dead centre and 130 degrees; two-stroke: 120 before, 110 after firing."""
    early, late = (-180.0, 130.0) if kind == "four_stroke" else (-120.0, 110.0)
    return (
        float(np.radians(early)) if closes is None else closes,
        float(np.radians(late)) if opens is None else opens,
    )
