"""Claim: a pressure card says what its table or its cycle says, and closes on itself."""

import numpy as np
import pytest
from long_but import long_but

from vibecalc.excitation.cylinder_torque import gas_harmonics, motored_card
from vibecalc.excitation.gas_tables import FOUR_STROKE, gas_card, pressure_at
from vibecalc.excitation.pressure_cycle import (
    PressureCycle,
    card_of_mean_pressure,
    card_of_peak,
    cylinder_volume,
    mean_pressure,
    motored_cycle,
    usual_cycle,
)
from vibecalc.parts.geometry import CrankGeometry

CAR = CrankGeometry(0.035, 0.123, 0.076)
OFFSET = CrankGeometry(0.05, 0.16, 0.09, wrist_pin_offset=0.006)
ANGLE = np.radians([-300.0, -180.0, -60.0, -20.0, 0.0, 7.0, 15.0, 40.0, 110.0, 200.0, 420.0])
PRESSURE = 1e5 * np.array([1.3, 1.9, 4.0, 12.0, 30.0, 71.0, 60.0, 25.0, 6.0, 2.1, 1.3])


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "monotone"])
def test_cards_pass_through_their_table_and_forget_where_it_began(interpolation: str) -> None:
    card = gas_card(ANGLE, PRESSURE, interpolation, cycle=FOUR_STROKE, crankcase_pressure=101325.0)
    for turn in (-FOUR_STROKE, 0.0, 3 * FOUR_STROKE):
        assert pressure_at(card, ANGLE + turn) == pytest.approx(PRESSURE - 101325.0, rel=1e-12)
    # the same table, begun four rows later
    later = np.concatenate([ANGLE[4:], ANGLE[1:5] + FOUR_STROKE])
    moved = gas_card(
        later, np.concatenate([PRESSURE[4:], PRESSURE[1:5]]), interpolation, cycle=FOUR_STROKE,
        crankcase_pressure=101325.0,
    )  # fmt: skip
    order = np.array([0.5, 3.0, 40.0])
    (first, mean), (other, other_mean) = (gas_harmonics(c, OFFSET, order) for c in (card, moved))
    assert np.all(np.abs(first.value - other.value) <= 0.1 * (first.error + other.error))
    assert mean.value == pytest.approx(float(other_mean.value), rel=1e-13)


def test_monotone_pieces_stay_between_their_ends_and_splines_are_smooth_at_the_seam() -> None:
    from scipy.interpolate import PchipInterpolator

    fine = np.linspace(ANGLE[0], ANGLE[-1], 5001)
    monotone = gas_card(ANGLE, PRESSURE, "monotone", cycle=FOUR_STROKE)
    value = pressure_at(monotone, fine)
    place = np.clip(np.searchsorted(ANGLE, fine, side="right") - 1, 0, len(ANGLE) - 2)
    ends = np.stack([PRESSURE[place], PRESSURE[place + 1]])
    assert np.all(value <= ends.max(0) * (1 + 1e-14)) and np.all(value >= ends.min(0) * (1 - 1e-14))
    inner = (fine > ANGLE[1]) & (fine < ANGLE[-2])
    truth = PchipInterpolator(ANGLE, PRESSURE)(fine[inner])
    assert np.abs(value[inner] - truth).max() < 1e-9 * truth.max()
    spline = gas_card(ANGLE, PRESSURE, "cubic", cycle=FOUR_STROKE)
    _, slope, bend, cube = spline.coefficient.T
    h = np.diff(spline.node)
    assert slope + h * (2 * bend + 3 * h * cube) == pytest.approx(np.roll(slope, -1), rel=1e-9)
    assert bend + 3 * h * cube == pytest.approx(np.roll(bend, -1), rel=1e-7, abs=1e-3)
    assert pressure_at(spline, fine).min() < PRESSURE.min()


CYCLES = {
    "spark": usual_cycle("spark"),
    "diesel": usual_cycle("diesel", injection_ends=0.4),
    "spark_two_stroke": usual_cycle("spark", "two_stroke"),
    "diesel_two_stroke": usual_cycle("diesel", "two_stroke", injection_ends=0.5),
}


@pytest.mark.parametrize("name", long_but(CYCLES, "spark", "diesel_two_stroke"))
@pytest.mark.parametrize("geometry", long_but([CAR, OFFSET], OFFSET))
def test_computed_cards_have_the_peak_or_the_work_asked_for(
    name: str, geometry: CrankGeometry
) -> None:
    cycle = CYCLES[name]
    crankcase = cycle.crankcase_pressure
    card = card_of_peak(cycle, geometry, 150e5)
    angle = np.linspace(cycle.inlet_closes, cycle.exhaust_opens, 20001)
    pressure = pressure_at(card, angle) + crankcase
    assert pressure.max() == pytest.approx(150e5, rel=1e-7)
    assert pressure.max() < 150e5 * (1 + 1e-12)
    # polytropic on both sides of the combustion
    volume = cylinder_volume(geometry, cycle.compression_ratio, angle)
    before = angle < cycle.combustion_starts
    squeezed = pressure[before] * volume[before] ** cycle.compression_exponent
    assert np.ptp(squeezed) < 1e-11 * squeezed[0]
    after = angle > max(cycle.combustion_ends, cycle.injection_ends)
    expanded = pressure[after] * volume[after] ** cycle.expansion_exponent
    assert np.ptp(expanded) < 1e-11 * expanded[0]

    wanted = float(mean_pressure(card, geometry).value)
    again = card_of_mean_pressure(cycle, geometry, wanted)
    off = pressure_at(again, angle) + crankcase - pressure
    assert np.abs(off).max() < 1e-11 * 150e5


@pytest.mark.parametrize("kind", ["spark", "diesel"])
def test_short_combustion_and_late_exhaust_give_the_ideal_cycles(kind: str) -> None:
    """Otto and limited pressure in closed form; what is short is 0.004 rad, and the rest falls."""
    n_c, n_e, ratio, p1, peak = 1.36, 1.28, 12.0, 1e5, 90e5
    held = np.radians(25.0)
    rest = []
    for short in (0.004, 0.002):
        cycle = PressureCycle(
            "four_stroke", "spark" if kind == "spark" else "diesel", ratio, p1, p1, n_c, n_e,
            -short, short, short if kind == "spark" else held, -np.pi, np.pi - short, 0.2, p1,
        )  # fmt: skip
        found = float(mean_pressure(card_of_peak(cycle, CAR, peak), CAR).value)
        cut = 1.0
        if kind == "diesel":
            cut = float(cylinder_volume(CAR, ratio, np.asarray(held)))
        taken = p1 * ratio / (n_c - 1) * (ratio ** (n_c - 1) - 1)
        given = peak * (cut - 1 + cut / (n_e - 1) * (1 - (cut / ratio) ** (n_e - 1)))
        # volumes over the clearance volume; the charge exchange at one pressure has no work
        rest.append(abs(found * (ratio - 1) / (given - taken) - 1))
    assert rest[1] < 3e-3 and rest[1] < 0.6 * rest[0]


@pytest.mark.parametrize("geometry", [CAR, OFFSET], ids=["centred", "offset"])
def test_a_mirrored_compression_is_the_cycle_without_combustion(geometry: CrankGeometry) -> None:
    """Where nothing burns before top dead centre, both ways to a motored card agree."""
    cycle = usual_cycle("spark", combustion_starts=0.05, combustion_ends=0.9)
    fired = card_of_peak(cycle, geometry, 45e5)
    mirrored = motored_card(fired, geometry, cycle.exhaust_opens)
    computed = motored_cycle(cycle, geometry)
    closed = np.linspace(-np.pi, cycle.exhaust_opens, 500)
    both = [pressure_at(card, closed) for card in (mirrored, computed)]
    assert np.abs(both[0] - both[1]).max() < 1e-11 * both[1].max()
    exchange = np.linspace(np.pi + 1e-9, 3 * np.pi - 1e-9, 50)
    assert pressure_at(mirrored, exchange) == pytest.approx(pressure_at(fired, exchange), abs=1e-3)
    # what goes in comes back: only the charge exchange costs work
    work = [float(mean_pressure(card, geometry).value) for card in (fired, mirrored)]
    assert work[0] > 5e5 and -0.3e5 < work[1] < 0.0
