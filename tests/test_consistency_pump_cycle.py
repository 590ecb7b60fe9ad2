"""Claim: pressure, valves, work and torque of a pump are right within their own error estimates.

Truth: the law of cosines and the volumes in 40 digits, quadrature in 22 digits, the area of the
indicator diagram, and the mass that goes in and out.
"""

import mpmath
import numpy as np
import pytest
from pump_cases import GEOMETRY, LIQUID

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_harmonics
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.excitation.pressure_cycle import Liquid, cylinder_pressure, pump_card, pump_turn
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.geometry import CrankGeometry

#: a common one, an offset one either way, a long-stroke stiff one, a soft one with much dead volume
PUMPS = (
    (LIQUID, GEOMETRY),
    (LIQUID, GEOMETRY._replace(wrist_pin_offset=0.006)),
    (LIQUID._replace(discharge_pressure=3e5), GEOMETRY._replace(wrist_pin_offset=-0.004)),
    (LIQUID._replace(bulk_modulus=4e10), CrankGeometry(0.06, 0.15, 0.02)),
    (LIQUID._replace(discharge_pressure=6e7, dead_volume=5e-4), GEOMETRY),
)


class Exact:
    """The same pump in many digits; angles from the crank's place along the cylinder."""

    def __init__(self, liquid: Liquid, geometry: CrankGeometry) -> None:
        self.liquid = Liquid(*(mpmath.mpf(one) for one in liquid))
        self.r, self.l, bore, self.e = (mpmath.mpf(one) for one in geometry)
        self.area = mpmath.pi * bore**2 / 4
        self.strain = (self.liquid[1] - self.liquid[0]) / self.liquid[2]
        self.top = mpmath.asin(self.e / (self.l + self.r))
        self.bottom = mpmath.pi + mpmath.asin(self.e / (self.l - self.r))
        self.swept = self.area * (self.place(self.top) - self.place(self.bottom))
        self.full = self.liquid.dead_volume + self.swept

    def place(self, angle: mpmath.mpf) -> mpmath.mpf:
        across = self.r * mpmath.sin(angle) - self.e
        return self.r * mpmath.cos(angle) + mpmath.sqrt(self.l**2 - across**2)

    def opens(self) -> list[mpmath.mpf]:
        """Both angles, by bisection of the volumes."""
        low, high = (
            self.liquid.dead_volume * mpmath.exp(self.strain),
            self.full * mpmath.exp(-self.strain),
        )
        found = []
        for volume, ends in (
            (low, (self.top, self.bottom)),
            (high, (self.bottom, self.top + 2 * mpmath.pi)),
        ):
            one, other = ends
            rising = self.volume(other) > self.volume(one)
            for _ in range(120):
                middle = (one + other) / 2
                below = (self.volume(middle) < volume) == rising
                one, other = (middle, other) if below else (one, middle)
            found.append(one)
        return found

    def volume(self, angle: mpmath.mpf) -> mpmath.mpf:
        return self.liquid.dead_volume + self.area * (self.place(self.top) - self.place(angle))

    def gauge(self, angle: mpmath.mpf) -> mpmath.mpf:
        suction, discharge, modulus, dead, outside = self.liquid
        volume = self.volume(angle)
        if angle <= self.bottom:
            return max(discharge - modulus * mpmath.log(volume / dead), suction) - outside
        return min(suction + modulus * mpmath.log(self.full / volume), discharge) - outside

    def harmonic(self, order: int) -> mpmath.mpc:
        """Of the torque, by quadrature between all events; the mean is order 0."""

        def torque(angle: mpmath.mpf) -> mpmath.mpc:
            across = self.r * mpmath.sin(angle) - self.e
            rod = mpmath.sqrt(self.l**2 - across**2)
            lever = self.r * mpmath.sin(angle) + across * self.r * mpmath.cos(angle) / rod
            turn = mpmath.expj(-order * angle)
            return self.gauge(angle) * self.area * lever * turn

        suction, discharge = self.opens()
        places = [self.top, suction, self.bottom, discharge, self.top + 2 * mpmath.pi]
        whole = mpmath.quad(torque, places) / (2 * mpmath.pi)
        return whole if order == 0 else 2 * whole


def off(found: Bounded, true: mpmath.mpf) -> float:
    """The error in units of its estimate."""
    return abs(float(mpmath.mpf(float(found.value)) - true)) / float(found.error)


@pytest.mark.parametrize(("liquid", "geometry"), PUMPS)
def test_valves_volumes_and_work_are_within_their_errors(
    liquid: Liquid, geometry: CrankGeometry
) -> None:
    with mpmath.workdps(40):
        exact, turn = Exact(liquid, geometry), pump_turn(liquid, geometry)
        opens = exact.opens()
        assert off(turn.suction_opens, opens[0]) < 1.0
        assert off(turn.discharge_opens, opens[1]) < 1.0
        assert off(turn.swept, exact.swept) < 1.0
        drawn = exact.full - exact.volume(opens[0])
        delivered = exact.volume(opens[1]) - exact.liquid.dead_volume
        assert off(turn.drawn, drawn) < 1.0
        assert off(turn.delivered, delivered) < 1.0
        assert turn.suction_opens.error < 1e-13 and turn.discharge_opens.error < 1e-13
        # the mass that comes in goes out: the density grows by exp(strain)
        assert abs(drawn / delivered / mpmath.exp(exact.strain) - 1) < mpmath.mpf("1e-30")


@pytest.mark.parametrize(("liquid", "geometry"), PUMPS)
def test_work_is_the_mean_torque_and_the_area_of_the_diagram(
    liquid: Liquid, geometry: CrankGeometry
) -> None:
    turn = pump_turn(liquid, geometry)
    mean = gas_harmonics(pump_card(liquid, geometry), geometry, [1.0])[1]
    around = 2.0 * np.pi
    uncertainty = turn.work.error + around * mean.error
    assert abs(turn.work.value + around * mean.value) <= uncertainty < 1e-10 * turn.work.value
    # pressure difference, swept volume, volumetric efficiency: the mean of both ways to count it
    efficiency = 0.5 * (turn.drawn.value + turn.delivered.value) / turn.swept.value
    rise = liquid.discharge_pressure - liquid.suction_pressure
    simple = rise * turn.swept.value * efficiency
    # the mean stands for a logarithmic mean: off by strain^2 / 12 of the volumes
    full = liquid.dead_volume + float(turn.swept.value)
    bound = rise * (full + liquid.dead_volume) * liquid.strain**2 * np.exp(liquid.strain) / 12.0
    assert abs(simple - turn.work.value) <= bound + 1e-12 * turn.work.value


def test_harmonics_are_those_of_a_quadrature_in_22_digits() -> None:
    orders, (liquid, geometry) = [1, 24], PUMPS[1]
    found, mean = gas_harmonics(pump_card(liquid, geometry), geometry, orders)
    with mpmath.workdps(22):
        exact = Exact(liquid, geometry)
        assert off(mean, exact.harmonic(0).real) < 1.0
        for place, order in enumerate(orders):
            error = abs(complex(exact.harmonic(order)) - found.value[place])
            assert error <= found.error[place] < 1e-11 * abs(found.value[0]), (order, error)


def test_the_card_is_the_pressure_and_bends_only_where_a_valve_opens() -> None:
    for liquid, geometry in PUMPS:
        card, turn = pump_card(liquid, geometry), pump_turn(liquid, geometry)
        angle = np.linspace(-1.0, 7.0, 1001)
        pressure = cylinder_pressure(liquid, geometry, angle)
        gauge = pressure - liquid.outside_pressure
        assert np.max(np.abs(pressure_at(card, angle) - gauge)) <= 3.0 * card.error.max()
        assert pressure.min() >= liquid.suction_pressure
        assert pressure.max() <= liquid.discharge_pressure
        for place in (turn.suction_opens, turn.discharge_opens):
            assert float(place.value) in card.node
        around = cylinder_pressure(liquid, geometry, angle + 2.0 * np.pi)
        slope = 1e-13 * liquid.bulk_modulus
        assert np.max(np.abs(around - pressure)) < slope


def test_a_pump_that_only_springs_is_refused() -> None:
    soft = LIQUID._replace(dead_volume=1.2e-3, discharge_pressure=1e8)
    with pytest.raises(NumericalFailure, match="nothing is drawn"):
        pump_turn(soft, GEOMETRY)
    with pytest.raises(NumericalFailure, match="nothing is drawn"):
        pump_card(soft, GEOMETRY)
