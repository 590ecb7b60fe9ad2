"""Claim: an engine on its mounts under its torque is what a sum in time gives, written anew here.

Pistons and rods are followed through two turns in small steps; forces, couples and torques of every
step are transformed, and a dense system of six freedoms, put together here, answers them.
"""

import re

import numpy as np
import pytest
from engine_cases import replaced
from engine_mounted import COUNTER, ON_BODY, SEPARATE, mounted, wanted_of
from mpmath import mp

from vibecalc.core.run.plan import plan_case
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import GasCard, pressure_at
from vibecalc.excitation.model import crank_geometry, cycle_of, gas_cards
from vibecalc.excitation.pressure_cycle import motored_cycle
from vibecalc.isolation.torque_reaction import line_transfer
from vibecalc.numerics.bounded import Bounded
from vibecalc.torsion.line import chain, dynamic_stiffness
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.modes import natural_modes

ROOT = "isolation/torque_reaction/"
SPEED = 50.0 * np.pi
RADIUS, ROD, OFFSET, AREA = 0.06, 0.2, 0.004, 0.25 * np.pi * 0.1**2
#: piston and its share of the rod; the rod's own moment beyond that of two points
SLIDING, BEYOND = 1.7 + 1.0 * 0.06 / 0.2, 0.01 - 1.0 * 0.06 * 0.14
TURNING = 1.0 - 0.3
PHASE, BANK = np.radians([50.0, 170.0, 290.0]), np.radians(20.0)
PLACE, SCALE = np.array([-0.15, 0.0, 0.15]), np.array([1.0, 1.1, 1.0])
FIRES = np.radians([690.0, 210.0, 450.0])
INERTIA = np.array([[12.0, -1.0, 0.0], [-1.0, 25.0, 0.0], [0.0, 0.0, 22.0]])
MOUNTS = np.array([[-0.4, -0.3, -0.2], [-0.4, 0.3, -0.2], [0.5, -0.3, -0.2], [0.5, 0.25, -0.2]])
STIFFNESS, DAMPING = np.diag([2e5, 2e5, 4e5]), np.diag([200.0, 200.0, 400.0])
STEPS = 1 << 13
ORDERS = 200


def in_time(third: GasCard | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Torque of gas and inertia (STEPS, 3) on the crank, and what shakes the body (STEPS, 6).

    The third cylinder may have a card of its own.

    The shaking is minus the change of momentum and angular momentum of all that moves but the
    crank itself, the couple about the crankshaft by the torque not in it.
    """
    angle = 4.0 * np.pi * np.arange(STEPS) / STEPS
    torque, shaking = np.zeros((STEPS, 3)), np.zeros((STEPS, 6))
    (card,) = gas_cards(mounted(SEPARATE).machine)[1]
    for one, (phase, place, scale, fires) in enumerate(
        zip(PHASE, PLACE, SCALE, FIRES, strict=True)
    ):
        own = angle + phase - BANK
        lean = np.arcsin((RADIUS * np.sin(own) - OFFSET) / ROD)
        lean_1 = RADIUS * np.cos(own) / (ROD * np.cos(lean))
        lean_2 = np.tan(lean) * lean_1**2 - RADIUS * np.sin(own) / (ROD * np.cos(lean))
        out_1 = -RADIUS * np.sin(own) - ROD * np.sin(lean) * lean_1
        out_2 = -RADIUS * np.cos(own) - ROD * (np.cos(lean) * lean_1**2 + np.sin(lean) * lean_2)
        used = third if third is not None and one == 2 else card
        pressure = scale * pressure_at(used, angle - fires)
        torque[:, one] -= pressure * AREA * out_1
        torque[:, one] -= SPEED**2 * (SLIDING * out_1 * out_2 + BEYOND * lean_1 * lean_2)
        force = -SLIDING * SPEED**2 * out_2
        # the stroke is z, across it y; the crank turns from z to -y, and so leans a cylinder
        for along, across, size in (
            (np.cos(BANK), -np.sin(BANK), force),
            (
                np.cos(angle + phase),
                -np.sin(angle + phase),
                np.full(STEPS, TURNING * RADIUS * SPEED**2),
            ),
        ):
            shaking[:, 1] += size * across
            shaking[:, 2] += size * along
            shaking[:, 4] -= size * along * place
            shaking[:, 5] += size * across * place
        # the offset towards the crank pin at 90 degrees, which is at -y: a lever about the shaft
        shaking[:, 3] -= OFFSET * force
        # a rod leans against the crank
        shaking[:, 3] += BEYOND * SPEED**2 * lean_2
    return torque, shaking


def halves(signal: np.ndarray) -> np.ndarray:
    """Amplitudes (ORDERS, ...) of the orders 1/2, 1, 3/2 ... of signals over two turns."""
    return 2.0 * np.fft.rfft(signal, axis=0)[1 : ORDERS + 1] / STEPS


def arm(point: np.ndarray) -> np.ndarray:
    """What six freedoms move at a point: t + r x p."""
    x, y, z = point
    turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), turn])


def supports(load: np.ndarray) -> np.ndarray:
    """Forces (mounts, 3, ORDERS) on the ground under loads (ORDERS, 6)."""
    mass = np.zeros((6, 6))
    mass[:3, :3], mass[3:, 3:] = 300.0 * np.eye(3), INERTIA
    rows = []
    for number, one in enumerate(load, start=1):
        w = 0.5 * number * SPEED
        passing = STIFFNESS + 1j * w * DAMPING
        system = sum(arm(p).T @ passing @ arm(p) for p in MOUNTS) - w**2 * mass
        motion = np.linalg.solve(system, one)
        rows.append([passing @ arm(p) @ motion for p in MOUNTS])
    return np.moveaxis(np.array(rows), 0, -1)


def largest(force: np.ndarray) -> np.ndarray:
    """Longest vector (mounts,) in steps of the cycle."""
    angle = np.linspace(0.0, 4.0 * np.pi, 8_001)
    number = 0.5 * np.arange(1, force.shape[-1] + 1)
    course = (force @ np.exp(1j * np.outer(number, angle))).real
    return np.asarray(np.sqrt(np.square(course).sum(1)).max(-1))


def test_driven_machine_elsewhere_is_the_sum_in_time() -> None:
    each, shaking = in_time()
    torque = each.sum(1)
    record = wanted_of(SEPARATE)
    couple = record[f"{ROOT}couple"]
    kept = couple.values.size
    assert np.allclose(couple.values, -halves(torque)[:kept], rtol=0.0, atol=2e-7)
    assert np.isclose(record[f"{ROOT}mean_couple"].values, -torque.mean(), rtol=1e-10)
    load = shaking.copy()
    load[:, 3] -= torque
    force = supports(halves(load))
    assert np.allclose(record[f"{ROOT}support_force"].values, force[..., :kept], rtol=0, atol=1e-6)
    peak = record[f"{ROOT}support_force_peak"]
    # 200 orders here, 24 there: what it leaves out is in its error, which is no wild one either
    away = np.abs(peak.values - largest(force)).max()
    assert away < peak.error_estimate < 3e-3 * peak.values.max()
    alone = record[f"{ROOT}support_force_of_torque"]
    none = np.zeros((STEPS, 6))
    none[:, 3] = -torque
    assert np.abs(alone.values - largest(supports(halves(none)))).max() < alone.error_estimate


def test_mean_torque_and_weight_stand_on_the_supports() -> None:
    record = wanted_of(SEPARATE, "isolation/support_force/static")
    mean = record[f"{ROOT}mean_support_force"].values
    turned = np.cross(MOUNTS, mean).sum(0)
    assert np.allclose(mean.sum(0), 0.0, atol=1e-9)
    assert np.allclose(turned, [record[f"{ROOT}mean_couple"].values, 0.0, 0.0], atol=1e-8)
    # up and down between the extremes, whose middle is near weight and mean
    low, high = (record[f"{ROOT}{name}_load"].values for name in ("minimum", "largest"))
    still = record["isolation/support_force/static"].values - mean[:, 2]
    force = record[f"{ROOT}support_force"].values[:, 2]
    angle = np.linspace(0.0, 4.0 * np.pi, 20_001)
    course = -(force @ np.exp(0.5j * np.outer(np.arange(1, force.shape[1] + 1), angle))).real
    assert np.allclose(low, still + course.min(-1), rtol=1e-5)
    assert np.allclose(high, still + course.max(-1), rtol=1e-5)


def test_line_on_the_body_gives_it_its_torques_back() -> None:
    """Sum of all torques of the body on the line, by a dense solution, against its momentum."""
    case, record = mounted(ON_BODY), wanted_of(ON_BODY, "excitation/couple")
    line = build_shaft_line(case).line
    couple = record[f"{ROOT}couple"]
    motored = motored_cycle(cycle_of(case.machine), crank_geometry(case.machine))
    engine = halves(in_time(motored)[0])[: couple.values.size]
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
        assert any(stage.name == "torque reaction" for stage in plan_case(mounted(text)))
    for change in (
        ('model = "rigid_body"', 'model = "pitch"\nlever = 0.5'),
        ('"separate"', '"cancels_torque"'),
        ('firing_order = ["2", "3", "1"]', ""),
    ):
        case = mounted(replaced(SEPARATE, change))
        assert all(stage.name != "torque reaction" for stage in plan_case(case))
