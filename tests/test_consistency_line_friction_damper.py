"""Claim: a ring on dry friction moves in time as an integration from one slip to the next says,
and its steady motion has the torque and heat of the first harmonic of the friction.
"""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibecalc import check, run
from vibecalc.absorber.friction_damper import DryFriction, response
from vibecalc.errors import CaseError
from vibecalc.parts.dry_friction import ALWAYS_SLIPS
from vibecalc.torsion.line import Line
from vibecalc.torsion.transient.clutch import Clutch
from vibecalc.torsion.transient.friction_damper import Dragged, drag
from vibecalc.torsion.transient.motion import split, stretch

INERTIA = np.array([2.0, 0.8, 0.5])
SHAFT, LININGS, SPEED = 4e4, 3e6, 150.0
ORDER = np.array([0.0, 1.0, 2.0])


def line_of(damping: float, of_linings: float = 0.0) -> Line:
    """A flywheel, a shaft, a hub with a ring on linings."""
    none, ends = np.zeros(3), np.array([0, 1, 2])
    stiffness, dashpots = np.array([SHAFT, LININGS]), np.array([damping, of_linings])
    return Line(INERTIA, none, none, ends[:2], ends[1:], stiffness, dashpots, np.zeros(2))


def torque(time: np.ndarray | float, accelerated: float) -> np.ndarray:
    """On the hub, with the orders 1 and 2 of a speed that grows."""
    angle = SPEED * np.asarray(time) + 0.5 * accelerated * np.asarray(time) ** 2
    return 300.0 * np.cos(angle) + 200.0 * np.cos(2.0 * angle + 0.5)


def dragged(friction: float, duration: float, accelerated: float, of_linings: float) -> Dragged:
    gas = np.zeros((3, 3), dtype=complex)
    gas[1, 1:] = 300.0, 200.0 * np.exp(0.5j)
    clutch = Clutch(1, friction, 0.0, np.array([False, False, True]), 0.0)
    parts = [stretch(duration, accelerated, gas)]
    reaction = np.array([1.0, 0.0, 0.0])
    line = line_of(20.0, of_linings)
    return drag(line, ORDER, clutch, parts, SPEED, "rest", reaction, 1e-9)


def integrated(
    friction: float, duration: float, accelerated: float, of_linings: float
) -> tuple[np.ndarray, float, int]:
    """Twist of the shaft, velocities and twist of the linings at the end, heat, times it locked.

    Relative to the speed of the crank: the flywheel takes what accelerates all three.
    """
    pull = -INERTIA * accelerated
    pull[0] += INERTIA.sum() * accelerated

    def slope(time: float, x: np.ndarray, slip: int) -> np.ndarray:
        twist, one, two, ring, wound, _ = x
        shaft = SHAFT * twist + 20.0 * (one - two)
        if slip:
            rub = slip * friction
            winds = (rub - LININGS * wound) / of_linings if of_linings else 0.0
        else:
            winds = two - ring
            rub = LININGS * wound + of_linings * winds
        moved = np.array([-shaft, shaft - rub + torque(time, accelerated), rub]) + pull
        return np.array([one - two, *(moved / INERTIA), winds, rub * (two - ring - winds)])

    def holding(time: float, x: np.ndarray) -> float:
        return friction - abs(LININGS * x[4] + of_linings * (x[2] - x[3]))

    def ends(time: float, x: np.ndarray, slip: int) -> float:
        if not slip:
            return holding(time, x)
        return slip * (x[2] - x[3] - slope(time, x, slip)[4])

    time, x, slip, locked = 0.0, np.zeros(6), 0, 0
    while time < duration:
        event = lambda t, y, way=slip: ends(t, y, way)  # noqa: E731
        event.terminal, event.direction = True, -1.0
        found = solve_ivp(
            lambda t, y, way=slip: slope(t, y, way), (time, duration), x, "DOP853",
            events=event, rtol=1e-12, atol=1e-14, max_step=2e-4,
        )  # fmt: skip
        time, x = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            if slip:
                slip, locked = 0, locked + 1
            else:
                slip = int(np.sign(LININGS * x[4] + of_linings * (x[2] - x[3])))
    return x, float(x[5]), locked


@pytest.mark.parametrize(
    ("friction", "accelerated", "of_linings"),
    [(60.0, 0.0, 0.0), (150.0, 200.0, 0.0), (150.0, 200.0, 150.0), (3000.0, 0.0, 0.0)],
)
def test_ring_moves_as_an_integration_from_slip_to_slip(
    friction: float, accelerated: float, of_linings: float
) -> None:
    found = dragged(friction, 0.15, accelerated, of_linings)
    x, heat, locked = integrated(friction, 0.15, accelerated, of_linings)
    state = found.run.states[-1][-1]
    roots = np.sqrt([SHAFT, LININGS, *INERTIA])
    seen = state[:5] / roots
    assert found.locks == locked
    assert np.allclose(seen[[0, 2, 3, 4]], x[:4], rtol=0.0, atol=1e-7 * np.abs(x[:4]).max())
    assert found.heat == pytest.approx(heat, rel=1e-7, abs=1e-9)
    assert (found.slip_time > 0.0) == (friction < 1000.0)


def test_a_stretch_goes_on_where_it_is_cut() -> None:
    gas = np.array([[0.0, 2.0 + 1.0j]])
    part = stretch(2.0, 3.0, gas, scale=(0.2, 1.0), acceleration_rate=-1.0, gas_end=3.0 * gas)
    first, rest = split(part, 10.0, 0.5)
    assert first.duration + rest.duration == part.duration
    assert rest.acceleration == 2.5 and rest.gas_end is part.gas_end
    assert first.scale_end == rest.scale_start == pytest.approx(0.4)
    # the speed goes from 10 to 14 rad/s, to 11.375 at the cut
    assert np.allclose(first.gas_end, gas * (1.0 + 2.0 * 1.375 / 4.0))


CASE = Path(__file__).parents[1] / "cases" / "drive_friction_damper.toml"
FRICTION = "response/torsion/friction_damper/"
STIFFNESS, HUB, RING, AMPLITUDE = 45e3, 2.0, 0.4, 30.0


def of_one_mode(speed: float, friction: float, **damper: Any) -> dict[str, Any]:
    """The shipped line with a heavy flywheel, linings like stone and no damping, at a speed."""
    table = tomllib.loads(CASE.read_text())
    line, torsion = table["machine"]["shaft_line"], table["response"]["torsion"]
    table["machine"]["speed"] = speed
    line["stations"][0]["inertia"] = 2e9
    del line["shafts"][0]["damping"], torsion["transient"]
    line["dampers"][0] |= {"friction_torque": friction, "stiffness": 1e13, **damper}
    return table


def test_first_harmonic_is_den_hartogs_of_one_mode() -> None:
    """Against the closed form of the fixed point, and the response of an absorber."""
    natural, ratio = np.sqrt(STIFFNESS / HUB), RING / HUB
    best = AMPLITUDE * np.pi / np.sqrt(8.0 * (1.0 + 4.0 * ratio / np.pi**2))
    for x in (0.9, 0.95, 0.99, 1.02):
        table = of_one_mode(x * natural / 3.0, best)
        table["response"]["torsion"].pop("speeds")
        record = run(table).record
        found, static = record[FRICTION + "angle"], AMPLITUDE / STIFFNESS
        expected = response(DryFriction(0.0, ratio, best / AMPLITUDE), [x])[0] * static
        assert float(found.values) == pytest.approx(expected, rel=1e-6)
        assert found.error_estimate < 1e-6 * expected
        # locked and free it is a line of one inertia
        for name, inertia in (("locked_angle", HUB + RING), ("free_angle", HUB)):
            alone = AMPLITUDE / abs(STIFFNESS - inertia * (x * natural) ** 2)
            assert float(record[FRICTION + name].values) == pytest.approx(alone, rel=1e-5)
        top = 1.0 + np.pi**2 / (4.0 * ratio)
        assert expected <= top * static * (1.0 + 1e-9)


def test_power_is_that_of_the_friction_and_the_best_one_takes_most() -> None:
    record = run(of_one_mode("459 rpm", 33.0)).record
    w = 3.0 * 459.0 * np.pi / 30.0
    value = {name: float(record[FRICTION + name].values) for name in
             ("angle", "heat", "equivalent_damping", "best_friction_torque")}  # fmt: skip
    # 4 F Y sqrt(1 - (pi t / 2)^2) in a cycle, where it slips all the time
    t = 33.0 / (RING * w**2 * value["angle"])
    work = 4.0 * 33.0 * value["angle"] * np.sqrt(1.0 - (0.5 * np.pi * t) ** 2)
    assert t < ALWAYS_SLIPS
    assert value["heat"] == pytest.approx(work * w / (2.0 * np.pi), rel=1e-8)
    taken = 0.5 * value["equivalent_damping"] * (w * value["angle"]) ** 2
    assert value["heat"] == pytest.approx(taken, rel=1e-8)
    best = run(of_one_mode("459 rpm", value["best_friction_torque"])).record
    most = float(best[FRICTION + "equivalent_damping"].values)
    assert most == pytest.approx(4.0 / np.pi**2 * RING * w, rel=1e-8)
    assert float(best[FRICTION + "angle"].values) == pytest.approx(
        float(record[FRICTION + "best_angle"].values), rel=1e-8
    )


def test_the_first_harmonic_is_near_the_motion_in_time() -> None:
    """Power of the slip and angle of the hub, after the beginning has died out."""
    table = tomllib.loads(CASE.read_text())
    del table["response"]["torsion"]["transient"], table["response"]["torsion"]["speeds"]
    record = run(table).record
    line = line_of(3.0)._replace(
        inertia=np.array([2000.0, HUB, RING]), stiffness=np.array([STIFFNESS, 4e6]),
        damping=np.array([3.0, 0.0]),
    )  # fmt: skip
    gas, speed = np.zeros((3, 1), dtype=complex), 459.0 * np.pi / 30.0
    gas[1] = AMPLITUDE
    clutch = Clutch(1, 32.0, 0.0, np.array([False, False, True]), 0.0)
    heat = []
    for turns in (13.0, 15.0):
        part = stretch(turns * 2.0 * np.pi / speed, 0.0, gas)
        found = drag(line, np.array([3.0]), clutch, [part], speed, "steady", None, 1e-6)
        heat.append(found.heat)
    power = (heat[1] - heat[0]) * speed / (2.0 * 2.0 * np.pi)
    assert power == pytest.approx(float(record[FRICTION + "heat"].values), rel=0.03)
    last = np.concatenate(found.run.states)[-2000:]
    twist = np.ptp(last[:, 0]) / 2.0 / np.sqrt(STIFFNESS)
    # the third harmonic of the friction moves the hub as well
    assert twist == pytest.approx(float(record[FRICTION + "angle"].values), rel=0.03)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"order": 4.0}, "none that excites the line"),
        ({"stiffness": 0.0}, "needs the stiffness of its linings"),
        ({"friction_torque": 0.0}, "friction_torque"),
        ({"loss_factor": 0.1}, "loss_factor"),
    ],
)
def test_what_makes_no_friction_damper_is_refused(changed: dict[str, Any], words: str) -> None:
    table = of_one_mode("459 rpm", 33.0)
    table["machine"]["shaft_line"]["dampers"][0] |= changed
    with pytest.raises(CaseError, match=words):
        run(table)


def test_what_does_not_go_with_dry_friction_is_refused() -> None:
    table = of_one_mode("459 rpm", 33.0)
    line, torsion = table["machine"]["shaft_line"], table["response"]["torsion"]
    line["dampers"].append(line["dampers"][0] | {"name": "other", "on": "motor"})
    torsion["damping_model"] = {"kind": "modal", "ratios": [0.01]}
    torsion["transient"] = {
        "kind": "clutch_in", "clutch": "shaft", "driven_speed": 1.0, "friction_torque": 30.0,
        "time_after": 0.1,
    }  # fmt: skip
    with pytest.raises(CaseError) as refused:
        check(table)
    for words in ("one damper with dry friction", "no damping ratio", "a clutch or a damper"):
        assert words in str(refused.value)
    ring = {"name": "ring", "on": "cylinder 1", "kind": "friction", "inertia": 27.5, "order": 3.0}
    ring |= {"friction_torque": 900.0, "stiffness": 1e8}
    design = {"on": "ring", "objective": "torque"}
    changes = {"machine.shaft_line.dampers": [ring], "damper_design": design}
    with pytest.raises(CaseError, match="not designed by a spring and a damper"):
        check(CASE.parent / "engine_damped.toml", set=changes)
