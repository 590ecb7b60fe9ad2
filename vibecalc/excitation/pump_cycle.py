"""Pressure on the plunger of a pump over one turn, in closed form.

From top dead centre on the liquid left in the dead volume expands to the suction pressure, then the
suction valve opens; from bottom dead centre on the full cylinder is compressed to the discharge
pressure, then the discharge valve opens. The valves have no mass and no resistance: they open where
the pressures meet and close at the dead centres. With a constant bulk modulus K = -V dp/dV

    re-expansion:  p = p_d - K ln(V / V_dead),        compression:  p = p_s + K ln(V_full / V),

and all that follows has a closed form: with d = (p_d - p_s) / K the suction valve opens at the
volume V_dead exp(d), the discharge valve at V_full exp(-d), and a turn takes the work

    W = K (V_full (1 - exp(-d)) - V_dead (exp(d) - 1)),

the area of the indicator diagram. (Own derivation; the diagram is that of any text on plunger
pumps.) The volumes drawn and delivered differ, their masses do not.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import CrankGeometry
from vibecalc.excitation.gas_card import TWO_STROKE, GasCard, fitted_card
from vibecalc.kinematics.dead_centres import (
    bottom_dead_centre,
    piston_displacement,
    stroke,
    top_dead_centre,
)
from vibecalc.kinematics.slider_crank import rod_projection
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray

#: roundings of a volume, and of the square of a half angle that follows from one
VOLUME_ROUNDINGS = 12.0
HALF_ANGLE_ROUNDINGS = 32.0


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
    """One turn of one cylinder, each a value with its absolute error.

    `suction_opens`, `discharge_opens`: the cylinder's own crank angle, rad, from `top`, about 0, to
    a turn beyond it; `swept`, `drawn` (at the suction pressure) and `delivered` (at the discharge
    pressure) volumes, m^3; `work` that the crank gives to the liquid, J.
    """

    top: WithError
    suction_opens: WithError
    bottom: WithError
    discharge_opens: WithError
    swept: WithError
    drawn: WithError
    delivered: WithError
    work: WithError


def pump_turn(liquid: Liquid, geometry: CrankGeometry) -> PumpTurn:
    """Angles, volumes and work of a turn.

    Raises
    ------
    NumericalFailure
        What is left at top dead centre expands beyond the stroke: nothing is drawn.
    """
    radius, length, _, offset = geometry
    outer, inner = (
        centre(radius, length, offset) for centre in (top_dead_centre, bottom_dead_centre)
    )
    swept = geometry.piston_area * float(stroke(radius, length, offset))
    dead, full = liquid.dead_volume, liquid.dead_volume + swept
    expanded = dead * float(np.expm1(liquid.strain))
    compressed = -full * float(np.expm1(-liquid.strain))
    doubt = VOLUME_ROUNDINGS * EPSILON
    if not expanded < swept * (1.0 - 64.0 * EPSILON):
        raise NumericalFailure(
            f"pump: the {1e6 * dead:.4g} cm^3 of dead volume expand by {1e6 * expanded:.4g} cm^3 "
            f"and the plunger sweeps {1e6 * swept:.4g} cm^3: nothing is drawn; the dead volume or "
            "the pressure is too large, or the bulk modulus too small"
        )
    area = geometry.piston_area
    opened = _from_top(expanded / area, float(outer.position), geometry)
    closed = _from_bottom(compressed / area, float(inner.position), geometry)
    return PumpTurn(
        WithError(np.asarray(outer.angle), np.asarray(outer.angle_error)),
        opened,
        WithError(np.asarray(inner.angle), np.asarray(inner.angle_error)),
        closed,
        _of(swept, doubt * swept),
        _of(swept - expanded, doubt * (swept + expanded)),
        _of(swept - compressed, doubt * (swept + compressed)),
        _of(
            liquid.bulk_modulus * (compressed - expanded),
            doubt * liquid.bulk_modulus * (compressed + expanded),
        ),
    )


def cylinder_pressure(liquid: Liquid, geometry: CrankGeometry, angle: ArrayLike) -> FloatArray:
    """Absolute pressure (...) in Pa at the cylinder's own crank angles, rad, of any turn.

    The plunger goes in from top to bottom dead centre and out from there: each half is read from
    its own end, so that no digits are lost where a stiff liquid is compressed within a degree.
    """
    radius, length, _, offset = geometry
    top = float(top_dead_centre(radius, length, offset).angle)
    bottom = float(bottom_dead_centre(radius, length, offset).angle)
    given = np.asarray(angle, dtype=float)
    this_turn = (given >= top) & (given <= top + TWO_STROKE)
    turned = np.where(this_turn, given, top + np.mod(given - top, TWO_STROKE))
    area = geometry.piston_area
    full = liquid.dead_volume + area * float(stroke(radius, length, offset))
    way = piston_displacement(turned, radius, length, offset).value
    low = liquid.discharge_pressure - liquid.bulk_modulus * np.log1p(
        area * way / liquid.dead_volume
    )
    lost = np.minimum(_way_from_bottom(turned, geometry) * area / full, 1.0 - EPSILON)
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


def _from_top(way: float, top: float, geometry: CrankGeometry) -> WithError:
    """Crank angle at which the wrist pin, at first at `top`, has come in by `way`."""
    radius, length, _, offset = geometry
    pin = top - way
    reach = float(np.hypot(pin, offset))
    short = way * (top + pin) / (radius + length + reach)  # of the stretched linkage
    square = short * (length + reach - radius) / (4.0 * radius * reach)
    half = float(np.arcsin(np.sqrt(square)))
    return _turned(2.0 * half, float(np.arctan2(offset, pin)), square)


def _from_bottom(way: float, bottom: float, geometry: CrankGeometry) -> WithError:
    """Crank angle beyond bottom dead centre at which the wrist pin has come out by `way`."""
    radius, length, _, offset = geometry
    pin = bottom + way
    reach = float(np.hypot(pin, offset))
    beyond = way * (pin + bottom) / (length - radius + reach)  # the folded linkage
    square = beyond * (length + reach + radius) / (4.0 * radius * reach)
    half = float(np.arcsin(np.sqrt(square)))
    return _turned(2.0 * half, float(np.pi + np.arctan2(offset, pin)), square)


def _turned(turn: float, start: float, square: float) -> WithError:
    slack = HALF_ANGLE_ROUNDINGS * EPSILON * float(np.sqrt(square / (1.0 - square)))
    return _of(start + turn, slack + 2.0 * EPSILON * (abs(start) + turn))


def _way_from_bottom(angle: FloatArray, geometry: CrankGeometry) -> FloatArray:
    """Way of the piston from bottom dead centre, m, as `piston_displacement` is from the top.

    The difference 2 (R sin^2((t - t0)/2) - L sin^2(psi/2)) / cos t0 loses no more than
    (L + R)/(L - R).
    """
    radius, length, _, offset = geometry
    folded = float(bottom_dead_centre(radius, length, offset).angle)
    start = folded - np.pi
    sine, cosine = np.sin(angle), np.cos(angle)
    rod = rod_projection(sine, cosine, *np.broadcast_arrays(radius, length, offset))
    rod_angle = np.arctan2(radius * sine - offset, rod)
    half_turn = np.sin(0.5 * (angle - folded))
    half_swing = (radius / length) * half_turn * np.cos(0.5 * (angle + folded))
    half_swing = half_swing / np.cos(0.5 * (rod_angle - start))
    way = 2.0 * (radius * half_turn**2 - length * half_swing**2) / np.cos(start)
    return np.asarray(np.maximum(way, 0.0))


def _of(value: float, error: float) -> WithError:
    return WithError(np.asarray(value), np.asarray(error))
