"""Claim: modes and forced response are those of openTorsion, on chains and on a geared line.

Its rigid mode is rounding (1e-5 rad/s), its shaft torques lack the damping part and add orders by
magnitude: held against it are natural frequencies and complex angles, and torques formed of these.
"""

import engine_source as source
import numpy as np
import opentorsion as ot
import pytest
from engine_as_published import full_torque
from pages import shows
from test_consistency_engine_cases import stated

from vibecalc.core.case.load import load_case
from vibecalc.numerics.bounded import bounded
from vibecalc.torsion.forced import forced
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.section_loads import twist_and_torque

DAMPER = 2131.976
ORDER = 0.5 * np.arange(1, 31)


def engine(freedoms: int) -> tuple[Line, ot.Assembly]:
    """The published engine, with some damping, as a line and as an assembly."""
    damped = freedoms == 8
    inertia = np.array(source.DAMPED_INERTIA if damped else source.INERTIA)
    stiffness = np.array(source.DAMPED_STIFFNESS if damped else source.STIFFNESS)
    damping = 4.7452e-5 * stiffness
    absolute = 1.8355 * inertia
    if damped:
        damping[0], absolute[0] = DAMPER, 0.0
    line = chain(inertia, stiffness)._replace(damping=damping, absolute_damping=absolute)
    shafts = [ot.Shaft(i, i + 1, k=k, c=damping[i]) for i, k in enumerate(stiffness)]
    discs = [ot.Disk(i, j, c=c) for i, (j, c) in enumerate(zip(inertia, absolute, strict=True))]
    return line, ot.Assembly(shafts, disk_elements=discs)


@pytest.mark.parametrize("freedoms", [7, 8])
def test_frequencies_of_the_published_engine(freedoms: int) -> None:
    line, assembly = engine(freedoms)
    found = natural_modes(line)
    square, vector = assembly.undamped_modal_analysis()
    place = np.argsort(square.real)
    other, shapes = np.sqrt(np.abs(square[place])), vector.real[:, place].T
    assert found.frequency[0] == 0.0
    assert 0.0 < other[0] < 1e-3
    assert found.frequency[1:] == pytest.approx(other[1:], rel=1e-11)
    shapes /= np.take_along_axis(shapes, np.argmax(np.abs(shapes), axis=1)[:, None], axis=1)
    sign = np.sign(np.sum(shapes * found.shape, axis=1))[:, None]
    assert np.abs(sign * shapes - found.shape).max() < 1e-9


@pytest.mark.parametrize("freedoms", [7, 8])
def test_forced_response_of_the_published_engine(freedoms: int) -> None:
    line, assembly = engine(freedoms)
    for speed in (37.0, 88.05, 211.0, 400.0, 991.0):
        torque = full_torque(freedoms, speed=speed)
        mine = forced(line, speed * ORDER, torque)
        other, _ = assembly.ss_response(torque.T, speed * ORDER)
        off = np.abs(mine.angle - other.T).max(axis=1)
        assert np.all(off <= 1e-11 * np.abs(mine.angle).max(axis=1) + mine.error)


def test_geared_line_with_a_branch_and_elastic_teeth() -> None:
    from geared_line import CASE, assembly, frequencies, loads, names, response, sections

    shaft = build_shaft_line(load_case(CASE).case)
    assert list(shaft.station_names) == names()
    found = natural_modes(shaft.line)
    assert found.frequency[0] == 0.0
    assert found.frequency[1:] == pytest.approx(frequencies()[1:], rel=1e-10)
    # torques as openTorsion's T carries them to the freedoms that are left
    order, speed = 0.5 * np.arange(1, 25), 75.0 * np.pi / 3.0
    other = response(speed)
    line = assembly()
    transform = line.T(line.E())
    assert transform.shape == (13, 12)
    own = loads(speed)
    load = np.zeros((len(order), len(shaft.freedom_names)), dtype=complex)
    for station, freedom in enumerate(shaft.freedom):
        load[:, freedom] += shaft.station_ratio[station] * own[station]
    mine = forced(shaft.line, speed * order, load)
    angle = shaft.station_ratio * mine.angle[:, shaft.freedom]
    assert np.abs(angle - other.angle.T).max() < 1e-10 * np.abs(angle).max()
    torque = twist_and_torque(shaft.line, speed * order, bounded(mine.angle))[1].value
    torque = torque / shaft.section_ratio
    assert [*(name for name, *_ in sections()), "power take-off"] == list(shaft.section_names)
    size = np.abs(torque).max(axis=0)
    assert np.all(np.abs(torque - other.torque.T).max(axis=0) < 1e-8 * size)


@pytest.mark.parametrize(("name", "silent", "orders"), [("damped", -1, 30), ("misfire", 2, 24)])
def test_numbers_stated_in_the_cases(name: str, silent: int, orders: int) -> None:
    import engine_by_hand as hand
    from geared_line import half_range

    line = hand.engine(ring=True)
    torque, mean = hand.torques(source.SPEED_OF_TEXT, orders, silent)
    twist = hand.twists(line, source.SPEED_OF_TEXT, torque)
    half = half_range(hand.section_torques(line, source.SPEED_OF_TEXT, twist))
    printed = stated(f"engine_{name}.toml")
    names = [*(f"throw {n}" for n in range(1, 6)), "rear", "ring"]
    for section, value in zip(names, half, strict=True):
        assert shows(printed["torque_half_range", section], float(value))
    rate = source.SPEED_OF_TEXT * ORDER[:orders] * np.abs(twist[-1])
    assert shows(printed["damper/heat", "ring"], 0.5 * hand.RING * float(np.sum(rate**2)))
    if name == "misfire":
        assert shows(printed["excitation/mean_torque",], float(mean.sum()))
