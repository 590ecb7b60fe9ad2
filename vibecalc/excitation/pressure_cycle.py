"""Computed pressure in a cylinder over its cycle: spark and diesel engines, pumps."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_harmonics
from vibecalc.excitation.gas_tables import FOUR_STROKE, TWO_STROKE, GasCard, fitted_card
from vibecalc.kinematics.slider_crank import (
    bottom_dead_centre,
    piston_displacement,
    stroke,
    top_dead_centre,
)
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# Computed pressure cards, for an engine whose pressure nobody has measured.
#
# Compression is polytropic from the closing of the inlet on. Combustion passes over from it to the
# expansion of a cycle with all heat at top dead centre (spark: Otto) or with a level pressure up to
# the end of the injection (diesel: limited pressure), by a share B that rises smoothly from 0 to 1:
#
#     p = (1 - B) p_compression + B level g,
#
# g being 1 at the top and falling polytropically. The rule to interpolate between the two is that
# of Eriksson and Andersson (2002), An analytic model for cylinder pressure in a four stroke SI
# engine, SAE 2002-01-0371; the shape of B and the diesel's plateau are ours. As the pressure is
# linear in the level, a peak pressure or a mean indicated pressure gives it without iteration.
# ----------------------------------------------------------------------------

PI = float(np.pi)
#: absolute, in Pa, at angles in rad
Pressure: TypeAlias = Callable[[FloatArray], FloatArray]
#: samples of the search for the largest pressure, and halvings of the interval around it
PEAK_SAMPLES = 512
PEAK_ROUNDS = 60


class PressureCycle(NamedTuple):
    """What a computed card is made of. Pressures absolute in Pa, angles in rad from firing.

    `inlet_closes` < `combustion_starts` < `combustion_ends` < `exhaust_opens`, the latter below pi,
    the first at -pi or later (two-stroke: later). Combustion ends where the share B reaches 1. A
    diesel holds its level until `injection_ends`, between that and the exhaust. From the opening of
    the exhaust to bottom dead centre the pressure passes over to `exhaust_pressure`, then to
    `intake_pressure`: around the charge exchange, within `overlap` on both sides (four-stroke), or
    from bottom dead centre to the closing of the inlet (two-stroke). `crankcase_pressure` is
    subtracted from all.
    """

    stroke: str
    kind: str
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


#: Pa and rad: what is usual of each kind, and of each number of strokes
USUAL: dict[str, dict[str, float]] = {
    "spark": {
        "compression_ratio": 9.0,
        "intake_pressure": 0.9e5,
        "exhaust_pressure": 1.1e5,
        "compression_exponent": 1.32,
        "expansion_exponent": 1.28,
        "combustion_starts": -np.radians(20.0),
        "combustion_ends": np.radians(40.0),
        "injection_ends": 0.0,
        "overlap": np.radians(15.0),
    },
    "diesel": {
        "compression_ratio": 15.0,
        "intake_pressure": 2.0e5,
        "exhaust_pressure": 1.8e5,
        "compression_exponent": 1.36,
        "expansion_exponent": 1.30,
        "combustion_starts": -np.radians(8.0),
        "combustion_ends": np.radians(14.0),
        "injection_ends": np.radians(14.0),
        "overlap": np.radians(30.0),
    },
    "four_stroke": {"inlet_closes": -np.radians(180.0), "exhaust_opens": np.radians(130.0)},
    "two_stroke": {"inlet_closes": -np.radians(120.0), "exhaust_opens": np.radians(110.0)},
}


def usual_cycle(kind: str, stroke_kind: str = "four_stroke", **said: float) -> PressureCycle:
    """A cycle "spark" or "diesel" with usual values for all that is not said, see `PressureCycle`.

    `injection_ends` before `combustion_ends` counts as there: the plateau is as long as the share B
    still rises.
    """
    values = {"crankcase_pressure": 101325.0, **USUAL[kind], **USUAL[stroke_kind], **said}
    values["injection_ends"] = max(values["injection_ends"], values["combustion_ends"])
    return PressureCycle(stroke=stroke_kind, kind=kind, **values)


def card_of_peak(cycle: PressureCycle, geometry: CrankGeometry, peak_pressure: float) -> GasCard:
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
    return _card(cycle, _raised(base, unit, float(allowed(grid).min())))


def card_of_mean_pressure(
    cycle: PressureCycle, geometry: CrankGeometry, mean_indicated_pressure: float
) -> GasCard:
    """Card whose work is `mean_indicated_pressure`, Pa, times the swept volume.

    Raises
    ------
    NumericalFailure
        So little work that the level would have to be below zero.
    """
    base, unit = _parts(cycle, geometry)
    without = mean_pressure(_card(cycle, base), geometry)
    level = cycle.intake_pressure * cycle.compression_ratio
    gain = mean_pressure(_card(cycle, _raised(base, unit, level)), geometry)
    per_level = (gain.value - without.value) / level
    pressure = float((mean_indicated_pressure - without.value) / per_level)
    if not pressure > 0.0:
        raise NumericalFailure(
            f"gas cycle: a mean indicated pressure of {mean_indicated_pressure:.6g} Pa is below "
            "what the cycle has without any pressure after combustion; raise it"
        )
    return _card(cycle, _raised(base, unit, pressure))


def motored_cycle(cycle: PressureCycle, geometry: CrankGeometry) -> GasCard:
    """Card of the same cylinder without combustion: the charge expands as it was compressed."""
    return _card(cycle, lambda angle: _compression(cycle, geometry, angle))


def mean_pressure(card: GasCard, geometry: CrankGeometry) -> Bounded:
    """Mean indicated pressure, Pa: the work of one cycle over the swept volume."""
    _, mean = gas_harmonics(card, geometry, np.empty(0))
    travel = stroke(*geometry.lengths)
    return mean * rounded(card.cycle / (geometry.piston_area * float(travel)), 6)


def cylinder_volume(
    geometry: CrankGeometry, compression_ratio: float, angle: FloatArray
) -> FloatArray:
    """Volume above the piston over the clearance volume: 1 at the top, the ratio at the bottom."""
    travel = piston_displacement(angle, *geometry.lengths).value
    return np.asarray(1.0 + (compression_ratio - 1.0) * travel / stroke(*geometry.lengths))


def smooth_step(share: FloatArray) -> FloatArray:
    """Rise from 0 to 1 over 0 .. 1 with two smooth derivatives at both ends."""
    x = np.clip(share, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (6.0 * x - 15.0)))


def _parts(cycle: PressureCycle, geometry: CrankGeometry) -> tuple[Pressure, Pressure]:
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


def _compression(cycle: PressureCycle, geometry: CrankGeometry, angle: FloatArray) -> FloatArray:
    start = cylinder_volume(geometry, cycle.compression_ratio, np.asarray(cycle.inlet_closes))
    volume = cylinder_volume(geometry, cycle.compression_ratio, angle)
    return np.asarray(cycle.intake_pressure * (start / volume) ** cycle.compression_exponent)


def _raised(base: Pressure, unit: Pressure, level: float) -> Pressure:
    return lambda angle: base(angle) + level * unit(angle)


def _card(cycle: PressureCycle, closed: Pressure) -> GasCard:
    """Of the absolute pressure in the closed cylinder, and what the exchange of gas makes of it."""

    def pressure(angle: FloatArray) -> FloatArray:
        return _gas_exchange(cycle, closed(angle), angle) - cycle.crankcase_pressure

    return fitted_card(pressure, _breakpoints(cycle), _length(cycle))


def _gas_exchange(cycle: PressureCycle, closed: FloatArray, angle: FloatArray) -> FloatArray:
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


def _breakpoints(cycle: PressureCycle) -> list[float]:
    inside = {cycle.combustion_starts, cycle.combustion_ends, cycle.exhaust_opens, PI}
    if cycle.kind == "diesel":
        inside.add(cycle.injection_ends)
    if cycle.stroke == "four_stroke":
        inside |= {2.0 * PI - cycle.overlap, 2.0 * PI + cycle.overlap}
    return [cycle.inlet_closes, *sorted(inside), cycle.inlet_closes + _length(cycle)]


def _length(cycle: PressureCycle) -> float:
    return FOUR_STROKE if cycle.stroke == "four_stroke" else TWO_STROKE


# ----------------------------------------------------------------------------
# Pressure on the plunger of a pump over one turn, in closed form.
#
# From top dead centre on the liquid left in the dead volume expands to the suction pressure, then
# the suction valve opens; from bottom dead centre on the full cylinder is compressed to the
# discharge pressure, then the discharge valve opens. The valves have no mass and no resistance:
# they open where the pressures meet and close at the dead centres. With a constant bulk modulus K =
# -V dp/dV
#
#     re-expansion:  p = p_d - K ln(V / V_dead),        compression:  p = p_s + K ln(V_full / V),
#
# and all that follows has a closed form: with d = (p_d - p_s) / K the suction valve opens at the
# volume V_dead exp(d), the discharge valve at V_full exp(-d), and a turn takes the work
#
#     W = K (V_full (1 - exp(-d)) - V_dead (exp(d) - 1)),
#
# the area of the indicator diagram. (Own derivation; the diagram is that of any text on plunger
# pumps.) The volumes drawn and delivered differ, their masses do not.
# ----------------------------------------------------------------------------


class Liquid(NamedTuple):
    """What a cylinder works with: absolute pressures and the bulk modulus in Pa, m^3."""

    suction_pressure: float
    discharge_pressure: float
    bulk_modulus: float
    dead_volume: float
    outside_pressure: float = 101325.0

    @property
    def strain(self) -> float:
        """Pressure difference over bulk modulus: what the liquid gives way."""
        return (self.discharge_pressure - self.suction_pressure) / self.bulk_modulus


class PumpTurn(NamedTuple):
    """One turn of one cylinder, numbers or each with its absolute error.

    `suction_opens`, `discharge_opens`: the cylinder's own crank angle, rad, from `top`, about 0, to
    a turn beyond it; `swept`, `drawn` (at the suction pressure) and `delivered` (at the discharge
    pressure) volumes, m^3; `work` that the crank gives to the liquid, J.
    """

    top: Any
    suction_opens: Any
    bottom: Any
    discharge_opens: Any
    swept: Any
    drawn: Any
    delivered: Any
    work: Any


def pump_turn(liquid: Liquid, geometry: CrankGeometry) -> PumpTurn:
    """Angles, volumes and work of a turn, each with its error.

    Raises
    ------
    NumericalFailure
        What is left at top dead centre expands beyond the stroke: nothing is drawn.
    """
    found: PumpTurn = with_errors(_pump_turn, liquid, geometry)
    return found


def _pump_turn(liquid: Liquid, geometry: CrankGeometry) -> PumpTurn:
    radius, length, offset = geometry.lengths
    top, bottom = (centre(*geometry.lengths) for centre in (top_dead_centre, bottom_dead_centre))
    area = geometry.piston_area
    swept = area * float(stroke(radius, length, offset))
    dead, full = liquid.dead_volume, liquid.dead_volume + swept
    expanded = dead * float(np.expm1(liquid.strain))
    compressed = -full * float(np.expm1(-liquid.strain))
    if not expanded < swept * (1.0 - 64.0 * EPSILON):
        raise NumericalFailure(
            f"pump: the {1e6 * dead:.4g} cm^3 of dead volume expand by {1e6 * expanded:.4g} cm^3 "
            f"and the plunger sweeps {1e6 * swept:.4g} cm^3: nothing is drawn; the dead volume or "
            "the pressure is too large, or the bulk modulus too small"
        )
    return PumpTurn(
        float(top.angle),
        _opening(expanded / area, float(top.position), geometry, radius),
        float(bottom.angle),
        np.pi + _opening(compressed / area, float(bottom.position), geometry, -radius),
        swept,
        swept - expanded,
        swept - compressed,
        liquid.bulk_modulus * (compressed - expanded),
    )


def cylinder_pressure(liquid: Liquid, geometry: CrankGeometry, angle: ArrayLike) -> FloatArray:
    """Absolute pressure (...) in Pa at the cylinder's own crank angles, rad, of any turn.

    The plunger goes in from top to bottom dead centre and out from there: each half is read from
    its own end, so that no digits are lost where a stiff liquid is compressed within a degree.
    """
    top = float(top_dead_centre(*geometry.lengths).angle)
    bottom = float(bottom_dead_centre(*geometry.lengths).angle)
    given = np.asarray(angle, dtype=float)
    this_turn = (given >= top) & (given <= top + TWO_STROKE)
    turned = np.where(this_turn, given, top + np.mod(given - top, TWO_STROKE))
    area = geometry.piston_area
    full = liquid.dead_volume + area * float(stroke(*geometry.lengths))
    travel = piston_displacement(turned, *geometry.lengths).value
    low = liquid.discharge_pressure - liquid.bulk_modulus * np.log1p(
        area * travel / liquid.dead_volume
    )
    lost = np.minimum(_travel_from_bottom(turned, geometry) * area / full, 1.0 - EPSILON)
    high = liquid.suction_pressure - liquid.bulk_modulus * np.log1p(-lost)
    expanding = np.maximum(low, liquid.suction_pressure)
    compressing = np.minimum(high, liquid.discharge_pressure)
    return np.asarray(np.where(turned <= bottom, expanding, compressing))


def pump_card(liquid: Liquid, geometry: CrankGeometry) -> GasCard:
    """The pressure over that outside as a card, with panels that end where the valves open.

    Raises
    ------
    NumericalFailure
        Nothing is drawn, or the liquid is so stiff that its compression takes no angle.
    """
    turn = pump_turn(liquid, geometry)
    top = float(turn.top.value)
    events = [top, *(float(turn[place].value) for place in (1, 2, 3)), top + TWO_STROKE]

    def gauge(angle: FloatArray) -> FloatArray:
        return cylinder_pressure(liquid, geometry, angle) - liquid.outside_pressure

    card = fitted_card(gauge, events, TWO_STROKE)
    # a rounded angle moves the pressure by its slope, which is steep while no valve is open
    width = np.diff(card.node)[:, None]
    power = np.arange(1, card.coefficient.shape[1])
    steepest = np.sum(np.abs(power * card.coefficient[:, 1:]) * width ** (power - 1), axis=1)
    return card._replace(error=card.error + 4.0 * np.pi * EPSILON * steepest)


def _opening(travel: float, start: float, geometry: CrankGeometry, stretch: float) -> float:
    """Angle of the crank to the line of the dead centre where the wrist pin has gone by `travel`.

    It leaves `start`, where the linkage is stretched by `stretch`, R at the top, or folded, -R.
    """
    radius, length, offset = geometry.lengths
    pin = start - float(np.sign(stretch)) * travel
    reach = float(np.hypot(pin, offset))
    short = travel * (start + pin) / (length + reach + stretch)
    square = short * (length + reach - stretch) / (4.0 * radius * reach)
    return 2.0 * float(np.arcsin(np.sqrt(square))) + float(np.arctan2(offset, pin))


def _travel_from_bottom(angle: FloatArray, geometry: CrankGeometry) -> FloatArray:
    """Way of the piston from bottom dead centre, m, as `piston_displacement` is from the top.

    The folded linkage is a stretched one of a crank of -R, half a turn on.
    """
    radius, length, offset = geometry.lengths
    travel = piston_displacement(angle - np.pi, -radius, length, offset).value
    return np.asarray(np.maximum(-travel, 0.0))
