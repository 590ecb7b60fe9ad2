"""Claim: a shaft line on the body gives it back the torques that a sum in time says; a run-up under
them is that of plain runs at single speeds inside it.

Pistons and rods are followed through two turns in small steps, their torque is transformed, and a
dense solution of the line answers it. Gas and rotors without a line are in
`test_consistency_random_machines.py`.
"""

import re
import tomllib

import numpy as np
import pytest
from engine_cases import replaced
from engine_mounted import COUNTER, ON_BODY, SEPARATE, mounted, wanted_of
from long_but import long_but
from mpmath import mp

from vibecalc.core.case.load import validate
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import GasCard, pressure_at
from vibecalc.excitation.model import cycle_of, gas_cards
from vibecalc.excitation.pressure_cycle import motored_cycle
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.response.torque_reaction import line_transfer
from vibecalc.schema import Case
from vibecalc.torsion.line import chain, dynamic_stiffness
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.modes import natural_modes

ROOT = "isolation/torque_reaction/"
SPEED = 50.0 * np.pi
RADIUS, ROD, OFFSET, AREA = 0.06, 0.2, 0.004, 0.25 * np.pi * 0.1**2
#: piston and its share of the rod; the rod's own moment beyond that of two points
SLIDING, BEYOND = 1.7 + 1.0 * 0.06 / 0.2, 0.01 - 1.0 * 0.06 * 0.14
PHASE, BANK = np.radians([50.0, 170.0, 290.0]), np.radians(20.0)
SCALE = np.array([1.0, 1.1, 1.0])
FIRES = np.radians([690.0, 210.0, 450.0])
STEPS = 1 << 13
ORDERS = 200


def in_time(third: GasCard) -> np.ndarray:
    """Torque of gas and inertia (STEPS, 3) on the crank; the third cylinder has its own card."""
    angle = 4.0 * np.pi * np.arange(STEPS) / STEPS
    torque = np.zeros((STEPS, 3))
    (card,) = gas_cards(mounted(SEPARATE).machine)[1]
    for one, (phase, scale, fires) in enumerate(zip(PHASE, SCALE, FIRES, strict=True)):
        own = angle + phase - BANK
        lean = np.arcsin((RADIUS * np.sin(own) - OFFSET) / ROD)
        lean_1 = RADIUS * np.cos(own) / (ROD * np.cos(lean))
        lean_2 = np.tan(lean) * lean_1**2 - RADIUS * np.sin(own) / (ROD * np.cos(lean))
        out_1 = -RADIUS * np.sin(own) - ROD * np.sin(lean) * lean_1
        out_2 = -RADIUS * np.cos(own) - ROD * (np.cos(lean) * lean_1**2 + np.sin(lean) * lean_2)
        pressure = scale * pressure_at(third if one == 2 else card, angle - fires)
        torque[:, one] -= pressure * AREA * out_1
        torque[:, one] -= SPEED**2 * (SLIDING * out_1 * out_2 + BEYOND * lean_1 * lean_2)
    return torque


def halves(signal: np.ndarray) -> np.ndarray:
    """Amplitudes (ORDERS, ...) of the orders 1/2, 1, 3/2 ... of signals over two turns."""
    return 2.0 * np.fft.rfft(signal, axis=0)[1 : ORDERS + 1] / STEPS


def test_line_on_the_body_gives_it_its_torques_back() -> None:
    """Sum of all torques of the body on the line, by a dense solution, against its momentum."""
    case, record = mounted(ON_BODY), wanted_of(ON_BODY, "excitation/couple")
    line = build_shaft_line(case).line
    couple = record[f"{ROOT}couple"]
    motored = motored_cycle(cycle_of(case.machine), crank_geometry(case.machine.crank_train))
    engine = halves(in_time(motored))[: couple.values.size]
    expected = []
    for order, torque in zip(couple.axes[0].values, engine, strict=True):
        w = order * SPEED
        on_line = np.concatenate([torque, np.zeros(3)])
        angle = np.linalg.solve(dynamic_stiffness(line, np.array(w)), on_line)
        # dampers to the body turn it with the line, against it the side thrusts of the pistons
        expected.append(1j * w * line.absolute_damping @ angle - torque.sum())
    assert np.allclose(couple.values, expected, rtol=0.0, atol=2e-7)
    assert np.abs(couple.values + engine.sum(1)).max() > 1.0  # the dampers are no small thing
    assert record[f"{ROOT}mean_couple"].values == 0.0
    assert np.abs(couple.values[0]) > 1e3 * couple.error_estimate


def test_wheels_that_turn_against_each_other_leave_no_torque() -> None:
    record = wanted_of(COUNTER)
    assert np.abs(record[f"{ROOT}couple"].values).max() <= record[f"{ROOT}couple"].error_estimate
    twin = replaced(COUNTER, ("between = ", "reverses = false, between = "))
    size = np.abs(wanted_of(twin)[f"{ROOT}couple"].values)
    apart = replaced(COUNTER, ("orders = 6", 'orders = 6\ndriven_machine = "separate"'))
    assert np.allclose(size, np.abs(wanted_of(apart)[f"{ROOT}couple"].values), rtol=1e-9)


def test_error_of_the_transfer_bounds_what_it_misses() -> None:
    """Near to undamped resonances, where digits are lost, against fifty digits."""
    inertia = np.array([0.3, 0.7, 0.1, 2.1, 0.9])
    line = chain(inertia, np.array([1e6, 3e6, 2e5, 7e5]))
    line = line._replace(absolute_damping=np.array([0.0, 0.0, 0.0, 0.01, 0.0]))
    spin = Bounded(inertia * np.array([1.0, 1.0, -1.0, 1.0, -1.0]), np.zeros(5))
    own = natural_modes(line).frequency
    frequency = np.concatenate([own[1:] * (1.0 + 3e-7), [20.0, 4e4]])
    found = line_transfer(line, spin, frequency)
    with mp.workdps(50):
        for row, w in enumerate(frequency):
            system = mp.matrix(5, 5)
            for one in range(5):
                own_part = mp.mpc(0, w) * line.absolute_damping[one] - mp.mpf(w) ** 2 * inertia[one]
                system[one, one] += own_part
            for a, b, k in zip(line.first, line.second, line.stiffness, strict=True):
                for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                    system[int(i), int(j)] += sign * mp.mpf(k)
            load = mp.matrix([mp.mpf(w) ** 2 * mp.mpf(h) for h in spin.value])
            exact = mp.lu_solve(system, load)
            away = [abs(complex(exact[i] - mp.mpmathify(found.value[row, i]))) for i in range(5)]
            assert max(away) <= found.error[row, 0] < 1e-3 * np.abs(found.value[row]).max()


def test_half_order_on_an_undamped_mode_is_refused_and_named() -> None:
    bare = re.sub(r", damping = \[.*?\]", "", SEPARATE)
    assert bare != SEPARATE
    silent = replaced(bare, (", pressure_scale = 1.1", ""))
    frequency = wanted_of(bare, "isolation/modes/natural_frequency")
    own = frequency["isolation/modes/natural_frequency"].values
    met = repr(2.0 * float(own[3]))
    with pytest.raises(NumericalFailure, match=r"order 0\.5 at .* mode 4"):
        wanted_of(replaced(bare, ('"1500 rpm"', met)))
    # with equal cylinders nothing drives it at that order
    record = wanted_of(replaced(silent, ('"1500 rpm"', met)))
    assert any("order 0.5 " in warning and "drive" in warning for warning in record.warnings)
    # next to it the rocking of three throws does
    assert record[f"{ROOT}nearest_order"].values[3] == 1.0


def test_planned_where_it_has_something_to_say() -> None:
    for text in (SEPARATE, ON_BODY):
        assert f"{ROOT}couple" in planned_quantities(mounted(text))
    for change in (
        ('model = "rigid_body"', 'model = "pitch"\nlever = 0.5'),
        ('"separate"', '"cancels_torque"'),
        ('firing_order = ["2", "3", "1"]', ""),
    ):
        case = mounted(replaced(SEPARATE, change))
        assert f"{ROOT}couple" not in planned_quantities(case)


def test_a_line_without_gears_and_damping_passes_all_torque_at_its_natural_frequency_too() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4800.0]))  # 0 and sqrt(4800 / 1.2) rad/s
    spin = Bounded(line.inertia, np.zeros(2))
    found = line_transfer(line, spin, np.array([10.0, np.sqrt(4000.0)]))
    np.testing.assert_allclose(found.value, -1.0, rtol=1e-12)
    hung = line._replace(damping=np.array([1e-3]))
    np.testing.assert_allclose(
        line_transfer(hung, spin, np.array([10.0, 63.0])).value, -1.0, rtol=1e-9
    )


#: a pressure that rises as it has fallen: its mean torque is zero
BREATHING = """
schema = 1
title = "one cylinder that works as a spring"
[machine]
kind = "compressor"
speed = "1500 rpm"
body = { mass = "120 kg", inertia = [3.1, 4.2, 3.7] }
[machine.crank_train]
crank_radius = "50 mm"
rod_length = "170 mm"
reciprocating_mass = "1.2 kg"
bore = "90 mm"
gas_pressure = { crank_angle = [0.0, "180 deg", "360 deg"], pressure = ["5 bar", "1 bar", "5 bar"] }
cylinders = [{ name = "1" }]
[machine.mounts]
positions = [[-0.3, -0.2, 0.0], [-0.3, 0.2, 0.0], [0.3, -0.2, 0.0], [0.3, 0.2, 0.0]]
each = { stiffness = "60 N/mm", damping = 80.0 }
[excitation]
driven_machine = "separate"
[isolation]
model = "rigid_body"
"""


def test_a_mean_torque_that_is_nothing_but_rounding_says_nothing_of_the_mounts() -> None:
    record = run_case(validate(tomllib.loads(BREATHING)))
    couple, force = record[f"{ROOT}mean_couple"], record["isolation/support_force/mean"]
    for found, size in ((couple, 1e-9), (force, 1e-9)):
        assert np.all(np.abs(found.values) <= found.error_estimate)
        assert found.error_estimate < size
    assert np.all(record["isolation/support_force/minimum_load"].values > 0.0)


RUN_UP = ('model = "rigid_body"\n', 'model = "rigid_body"\nrun_up = { from = 40.0, to = 180.0 }\n')
CURVE = "isolation/support_force/run_up"
PEAK = "isolation/support_force/steady_peak"
TEXTS = {
    "damped line on the body": replaced(ON_BODY, ("orders = 12", "orders = 4"), RUN_UP),
    "geared line, no momentum": replaced(COUNTER, RUN_UP),
}


def at_speed(case: Case, speed: float) -> Case:
    return case.model_copy(
        update={
            "machine": case.machine.model_copy(update={"speed": speed}),
            "isolation": case.isolation.model_copy(update={"run_up": None}),
        }
    )


@pytest.mark.parametrize("name", long_but(TEXTS, "geared line, no momentum"))
def test_plain_runs_at_speeds_of_the_run_up_agree(name: str) -> None:
    case = mounted(TEXTS[name])
    record = run_case(case)
    curve, top = record[CURVE], record[f"{CURVE}_peak"]
    where = record[f"{CURVE}_peak_speed"]
    speeds = curve.axes[1].values
    forces = np.asarray(curve.values)
    assert forces.max() > 0.0
    chosen = [0, len(speeds) // 4, int(np.argmax(forces[0])), 3 * len(speeds) // 4, -1]
    for place in chosen:
        plain = run_case(at_speed(case, float(speeds[place])), wanted=frozenset([PEAK]))[PEAK]
        away = np.abs(forces[:, place] - plain.values)
        # the same orders: what these leave out is no part of the difference
        assert np.all(away <= 1e-9 * np.abs(forces).max())
        assert away.max() <= curve.error_estimate
    # no speed is higher than the maximum, and it is that of a plain run there
    assert np.all(forces <= top.values[:, None] * (1.0 + 1e-9) + np.asarray(top.error_estimate))
    for mount, speed in enumerate(where.values[:2]):
        plain = run_case(at_speed(case, float(speed)), wanted=frozenset([PEAK]))[PEAK]
        assert float(top.values[mount]) == pytest.approx(float(plain.values[mount]), rel=1e-9)
