"""Claim: a compressor's forces and its motion on the suspension are what other ways give.

Forces against sums by hand over pistons and throws at single crank angles; the motion against the
other method, against the isolation stage, against plain solves in doubles, against sums over time;
and what happens where a body is free or an order stands on a natural frequency.
"""

import copy
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from exact_motion import exact_motion
from exact_response import response_results
from exact_rod import couple_of, energy_of, three_masses, two_masses
from long_but import long_but
from mpmath import mpf
from random_machines import Table, random_machine
from response_machines import (
    IMPERIAL,
    INCH,
    POUND_FORCE,
    SI,
    bare,
    blocks,
    random_compressor,
    run,
    si_matrix,
)
from scipy.linalg import eigh
from truth_report import UNIT

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.parts.matrices import block_matrix

ANGLES = np.array([0.1, 0.9, 1.7, 2.8, 3.9, 5.2, 6.1])
MOTION = ("translation_harmonics", "rotation_harmonics", "ground_force", "ground_couple")


def signal(quantity: Quantity, angles: np.ndarray = ANGLES) -> np.ndarray:
    """Re sum X_n exp(i n a) (angles, directions) of harmonics (orders, directions)."""
    orders = quantity.axes[0].values
    return np.asarray((np.exp(1j * np.outer(angles, orders)) @ quantity.values).real)


def six(record: Record, first: str = "translation_harmonics", second: str = "rotation_harmonics"):
    """Amplitudes (orders, 6) of a pair of results."""
    return np.hstack([record[f"response/{first}"].values, record[f"response/{second}"].values])


def excited(**excitation: Any) -> Table:
    """The shipped compressor with other ways of running; what it drives takes its torque."""
    table = bare()
    table["excitation"] = {"orders": 80, "driven_machine": "cancels_torque", **excitation}
    return table


def by_hand(table: Table, angle: float, moving: set[str], balanced: set[str]) -> np.ndarray:
    """Force and couple (6,) on the body: minus mass times acceleration of every part."""
    train = validate(copy.deepcopy(table)).machine.crank_train
    assert train.rod is not None and train.rod.crank_pin_to_mass_centre is not None
    share = train.rod.crank_pin_to_mass_centre / train.rod_length
    piston = (train.piston_mass or 0.0) + (train.pin_mass or 0.0) + share * train.rod.mass
    throw = (1.0 - share) * train.rod.mass
    speed, radius = table["machine"]["speed"], train.crank_radius
    speed = float(str(speed).removesuffix(" rad/s"))
    at = exact_motion(mpf(radius), mpf(train.rod_length), mpf(0), None, digits=4).at
    axis, stroke = (np.eye(3)["xyz".index(name)] for name in (train.axis, train.stroke))
    across = np.cross(stroke, axis)
    total = np.zeros(6)
    for cylinder in train.cylinders:
        turned = angle + cylinder.crank_phase
        bank = cylinder.bank_angle
        outward = np.cos(bank) * stroke - np.sin(bank) * across
        pull = np.zeros(3)
        if cylinder.name in moving:
            pull = pull - piston * float(at(mpf(turned - bank))[2]) * outward
        weigh = throw * ((cylinder.name in moving) - 1.0 * (cylinder.name in balanced))
        pull = pull + weigh * radius * (np.cos(turned) * stroke - np.sin(turned) * across)
        place = np.array(train.origin) + cylinder.position * axis
        total += np.concatenate([pull, np.cross(place, pull)]) * speed**2
    return total


@pytest.mark.parametrize("idle", ["stopped", "unloaded"])
@pytest.mark.parametrize("working", [("A", "B"), ("A",), ("B",)])
@pytest.mark.parametrize(
    "balanced",
    [
        pytest.param((), marks=pytest.mark.long),
        pytest.param(("A",), marks=pytest.mark.long),
        pytest.param(("B",), marks=pytest.mark.long),
        ("A", "B"),
    ],
)
def test_forces_are_the_sum_over_what_moves(
    working: tuple[str, ...], balanced: tuple[str, ...], idle: str
) -> None:
    options: Table = {"working": list(working), "idle": idle}
    if balanced:
        options["balanced_for"] = list(balanced)
    table = excited(**options)
    del table["response"], table["machine"]["body"], table["machine"]["mounts"]
    record = run(table)
    moving = {"A", "B"} if idle == "unloaded" else set(working)
    ours = np.hstack([signal(record[f"excitation/{name}"]) for name in ("force", "couple")])
    hand = np.array([by_hand(table, float(a), moving, set(balanced)) for a in ANGLES])
    assert np.max(np.abs(hand)) > 100.0
    assert ours == pytest.approx(hand, abs=1e-12 * np.max(np.abs(hand)))


def test_unloaded_cylinders_move_as_working_ones_do_and_stopped_ones_do_not() -> None:
    force = {
        name: run(excited(**options))["excitation/force"].values
        for name, options in {
            "all": {},
            "unloaded": {"working": ["A"], "idle": "unloaded"},
            "stopped": {"working": ["A"], "idle": "stopped"},
        }.items()
    }
    assert np.array_equal(force["unloaded"], force["all"])
    # half a turn apart: odd orders of both are zero, those of one are not
    assert np.abs(force["all"][0]).max() < 1e-12 * np.abs(force["stopped"][0]).max()


def test_weights_take_away_all_that_the_throws_do() -> None:
    cancelled = run(excited(balanced_for=["A", "B"]))
    train = (lighter := excited())["machine"]["crank_train"]
    masses = cancelled["excitation/mass/reciprocating"].values
    for key in ("piston_mass", "pin_mass", "rod"):
        del train[key]
    train["reciprocating_mass"] = float(masses[0])
    without = run(lighter)
    assert np.all(without["excitation/mass/rotating"].values == 0.0)
    for name in ("force", "couple"):
        ours, other = cancelled[f"excitation/{name}"], without[f"excitation/{name}"]
        assert np.abs(ours.values - other.values).max() <= ours.error_estimate
        assert ours.error_estimate < 1e-13 * np.abs(ours.values).max()


def test_opposed_cylinders_cancel_every_order_and_cranks_half_a_turn_apart_the_odd_ones() -> None:
    table = excited(orders=12)
    first, second = table["machine"]["crank_train"]["cylinders"]
    in_line = run(table)["excitation/force"].values[:, 1]
    working = copy.deepcopy(table)
    working["excitation"]["working"] = ["A"]
    alone = run(working)["excitation/force"].values[:, 1]
    even = np.arange(1, 13) % 2 == 0
    assert in_line[even] == pytest.approx(2.0 * alone[even], rel=1e-13)
    assert np.abs(in_line[~even]).max() < 1e-13 * np.abs(alone).max()
    # opposite and on one throw pin angle: the same motion, the other way
    second["position"], second["bank_angle"] = first["position"], "180 deg"
    record = run(table)
    for name in ("excitation/force", "excitation/couple", "response/translation_harmonics"):
        quantity = record[name]
        assert np.abs(quantity.values).max() <= quantity.error_estimate
    assert record["excitation/force"].error_estimate < 1e-13 * np.abs(alone).max()


def with_rod(inertia: float | None, **excitation: Any) -> Table:
    table = excited(**excitation)
    train = table["machine"]["crank_train"]
    train["cylinders"][1]["crank_phase"] = "100 deg"  # opposed rods have no couple together
    if inertia is not None:
        train["rod"]["inertia"] = inertia
    return table


@pytest.mark.parametrize(
    ("driven", "working"), [("cancels_torque", ["B"]), ("on_body", ["A", "B"])]
)
def test_the_rods_own_moment_is_what_three_masses_have_beyond_two(
    driven: str, working: list[str]
) -> None:
    options = {"driven_machine": driven, "working": working}
    inertia = 3e-5
    found, plain = (run(with_rod(value, **options)) for value in (inertia, None))
    assert np.array_equal(found["excitation/force"].values, plain["excitation/force"].values)
    ours = signal(found["excitation/couple"]) - signal(plain["excitation/couple"])
    assert np.abs(ours[:, :2]).max() < 1e-12 * np.abs(ours[:, 2]).max()
    train = validate(with_rod(inertia)).machine.crank_train
    assert train.rod is not None
    mass, first = mpf(train.rod.mass), mpf(train.rod.crank_pin_to_mass_centre or 0.0)
    lengths = (mpf(train.crank_radius), mpf(train.rod_length), mpf(0))
    rods = (three_masses(mass, first, mpf(inertia), *lengths), two_masses(mass, first, *lengths))

    def beyond(angle: mpf) -> mpf:
        couple = couple_of(rods[0], angle) - couple_of(rods[1], angle)
        if driven == "on_body":  # the power that goes into the rod has to be held on the body
            couple += mpmath.diff(lambda a: energy_of(rods[0], a) - energy_of(rods[1], a), angle)
        return couple

    with mpmath.workdps(40):
        hand = [
            sum(beyond(mpf(a) + mpf(c.crank_phase)) for c in train.cylinders if c.name in working)
            for a in ANGLES.tolist()
        ]
    truth = 361.0**2 * np.array([float(value) for value in hand])
    assert np.abs(truth).max() > 0.1
    slack = 81 * plain["excitation/couple"].error_estimate
    assert ours[:, 2] == pytest.approx(truth, abs=1e-12 * np.abs(truth).max() + slack)


def test_the_rods_couple_reaches_the_body() -> None:
    options = {"balanced_for": ["A", "B"], "working": ["A"]}
    found, plain = (run(with_rod(value, **options)) for value in (3e-5, None))
    load = found["excitation/couple"].values - plain["excitation/couple"].values
    assert found["excitation/rod/couple"].values[1:, None] * np.eye(3)[2] == pytest.approx(
        load, abs=1e-12 * np.abs(found["excitation/couple"].values).max()
    )
    moved = six(found) - six(plain)
    mass, stiffness = matrices_of(bare())[:2]
    want = solve_orders(mass, stiffness, 0.0, np.hstack([0.0 * load, load]), 361.0)
    assert moved == pytest.approx(want, abs=1e-11 * np.abs(six(found)).max())
    assert np.abs(moved).max() > 1e-3 * np.abs(six(found)).max()


def matrices_of(table: Table) -> tuple[np.ndarray, np.ndarray]:
    return (
        si_matrix(table, "body", "mass_matrix"),
        si_matrix(table, "mounts", "stiffness_matrix"),
    )


def solve_orders(
    mass: np.ndarray, stiffness: np.ndarray, damping: Any, load: np.ndarray, speed: float
) -> np.ndarray:
    """X (orders, 6) of loads (orders, 6) by one solve per order; K may be complex."""
    rate = np.arange(1, len(load) + 1) * speed
    rows = [
        np.linalg.solve(stiffness + 1j * w * np.asarray(damping) * np.ones((6, 6)) - w**2 * mass, f)
        for w, f in zip(rate, load, strict=True)
    ]
    return np.array(rows)


@pytest.mark.parametrize("seed", long_but(range(4), 0, 1))
def test_sums_of_modes_are_single_solves(seed: int) -> None:
    table = random_compressor(seed)
    for key in ("operations", "balances", "run_up"):
        table["response"].pop(key, None)
    records = []
    for method in ("modal", "direct"):
        table["response"]["method"] = method
        records.append(run(table))
    for path, one in records[0].items():
        other = records[1][path]
        size = np.abs(other.values).max()
        apart = np.abs(one.values - other.values).max()
        assert apart <= one.error_estimate + other.error_estimate, path
        if path.startswith("response/"):
            assert one.error_estimate <= 1e3 * other.error_estimate + 64.0 * UNIT * size, path


@pytest.mark.parametrize("seed", range(4))
def test_parts_move_as_the_isolation_stage_says(seed: int) -> None:
    table = random_machine(seed, "rigid_body")
    del table["isolation"]["run_up"]
    table["response"] = {"method": "direct", "energies": True}
    record = run(table)
    pairs = {
        "modes/natural_frequency": "modes/natural_frequency",
        "modes/shape": "modes/shape",
        "modes/energy_fraction": "modes/energy_fraction",
        "modes/damping_ratio": "modes/damping_ratio",
        "translation_harmonics": "body/translation_harmonics",
        "rotation_harmonics": "body/rotation_harmonics",
    }
    for ours, other in pairs.items():
        one, two = record[f"response/{ours}"], record[f"isolation/{other}"]
        off = np.abs(one.values - two.values).max()
        assert off <= one.error_estimate + two.error_estimate, ours
    # [mount, direction, order]
    supports = record["isolation/support_force/steady_harmonics"]
    mounts = validate(copy.deepcopy(table)).machine.mounts
    assert mounts is not None
    places = mounts.positions or [mount.position for mount in mounts.individual or ()]
    force = supports.values.sum(axis=0).T
    couple = sum(
        np.cross(np.array(place), row.T) for place, row in zip(places, supports.values, strict=True)
    )
    for name, want in (("force", force), ("couple", couple)):
        ground = record[f"response/ground_{name}"]
        slack = len(places) * supports.error_estimate * (1.0 + np.abs(places).max())
        assert np.abs(ground.values - want).max() <= ground.error_estimate + slack, name


@pytest.mark.parametrize("seed", range(2))
def test_a_matrix_is_one_in_any_unit(seed: int) -> None:
    table = random_compressor(seed, "damping_matrix")
    del table["response"]["run_up"]
    other = copy.deepcopy(table)
    for part, key in (
        ("body", "mass_matrix"),
        ("mounts", "stiffness_matrix"),
        ("mounts", "damping_matrix"),
    ):
        matrix = si_matrix(table, part, key)
        table["machine"][part][key] = {"values": matrix.tolist(), "units": SI[key]}
        back = matrix / blocks(POUND_FORCE / INCH, POUND_FORCE, POUND_FORCE * INCH)
        other["machine"][part][key] = {"values": back.tolist(), "units": IMPERIAL[key]}
    one, two = run(table), run(other)
    for path, quantity in one.items():
        size = np.abs(quantity.values).max()
        off = np.abs(quantity.values - two[path].values).max()
        assert off <= 2.0 * (quantity.error_estimate + two[path].error_estimate) + 1e-15 * size, (
            path
        )


def test_every_block_has_its_own_unit() -> None:
    table = bare()
    mass = validate(table).machine.body
    assert mass is not None and mass.mass_matrix is not None
    ours = block_matrix(mass.mass_matrix)
    # slug inches are lbf s^2 / in: 175.13 kg
    assert ours[0, 0] == pytest.approx(0.206 * 175.12683524647636, rel=1e-15)
    assert ours[3, 3] == pytest.approx(3.37 * 0.1129848290276167, rel=1e-15)
    mounts = validate(bare()).machine.mounts
    assert mounts is not None and mounts.stiffness_matrix is not None
    stiffness = block_matrix(mounts.stiffness_matrix)
    assert stiffness[0, 4] == pytest.approx(-2123 * 4.4482216152605, rel=1e-15)
    assert stiffness[4, 0] == stiffness[0, 4]


@cache
def damped(kind: str) -> tuple[Record, Table]:
    table = bare("compressor_a")
    mounts = table["machine"]["mounts"]
    mass, stiffness = matrices_of(table)
    if kind == "damping_matrix":
        damping = 2e-4 * stiffness + 3.0 * mass
        mounts["damping_matrix"] = {"values": (0.5 * (damping + damping.T)).tolist()}
    else:
        mounts[kind] = 0.05
    return run(table), table


@pytest.mark.parametrize("kind", ["loss_factor", "modal_damping", "damping_matrix"])
def test_damping_given_in_three_ways(kind: str) -> None:
    record, table = damped(kind)
    mass, stiffness = matrices_of(table)
    load = six_load(record)
    square, shape = eigh(stiffness, mass)
    natural = np.sqrt(square)
    damping, held = np.zeros((6, 6)), stiffness.astype(complex)
    if kind == "loss_factor":
        held, ratio = stiffness * (1.0 + 0.05j), np.full(6, 0.025)
    elif kind == "modal_damping":
        ratio = np.full(6, 0.05)
        damping = mass @ shape @ np.diag(2.0 * 0.05 * natural) @ shape.T @ mass
    else:
        damping = np.array(table["machine"]["mounts"]["damping_matrix"]["values"])
        ratio = 0.5 * (2e-4 * natural + 3.0 / natural)
    want = solve_orders(mass, held, damping, load, 361.0)
    assert six(record) == pytest.approx(want, abs=1e-12 * np.abs(want).max())
    assert record["response/modes/damping_ratio"].values == pytest.approx(ratio, rel=1e-10)


def six_load(record: Record) -> np.ndarray:
    return np.hstack([record["excitation/force"].values, record["excitation/couple"].values])


@pytest.mark.parametrize("kind", ["loss_factor", "modal_damping", "damping_matrix"])
def test_what_drives_the_body_moves_it_and_the_rest_reaches_the_ground(kind: str) -> None:
    """Load = M x'' + force on the ground at every instant, that force being K x + C x'."""
    record, table = damped(kind)
    mass, stiffness = matrices_of(table)
    orders = np.arange(1, 81)[:, None]
    moved, ground = six(record), six(record, "ground_force", "ground_couple")
    inertia = (-((orders * 361.0) ** 2) * moved) @ mass
    load = six_load(record)
    assert ground == pytest.approx(load - inertia, abs=1e-12 * np.abs(load).max())
    if kind == "damping_matrix":
        damping = np.array(table["machine"]["mounts"]["damping_matrix"]["values"])
        wave = np.exp(1j * np.outer(ANGLES, orders))
        place, pace = (wave @ moved).real, (wave @ (1j * orders * 361.0 * moved)).real
        held = place @ stiffness + pace @ damping
        assert (wave @ ground).real == pytest.approx(held, abs=1e-12 * np.abs(held).max())


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_energies_are_those_of_the_motion_in_time(seed: int) -> None:
    table = random_compressor(seed, "modal_damping")
    for key in ("operations", "balances", "run_up"):
        table["response"].pop(key, None)
    table["accuracy"] = {"rtol": 1e-12}
    table["excitation"].pop("orders", None)
    record = run(table)
    moved, speed = six(record), table["machine"]["speed"]
    orders = np.arange(1, len(moved) + 1)
    angle = np.arange(4096) * (2.0 * np.pi / 4096)
    wave = np.exp(1j * np.outer(angle, orders))
    place, pace = (wave @ moved).real, (wave @ (1j * speed * orders[:, None] * moved)).real
    mass, stiffness = matrices_of(table)
    for name, state, weight in (("kinetic", pace, mass), ("potential", place, stiffness)):
        energy = 0.5 * np.einsum("ti,ij,tj->t", state, weight, state)
        stem = f"response/{name}_energy"
        # equal weights are exact for a sum of twice these orders
        assert float(record[f"{stem}/mean"].values) == pytest.approx(energy.mean(), rel=1e-11)
        peak = float(record[f"{stem}/peak"].values)
        assert energy.max() <= peak * (1.0 + 1e-12)
        assert peak == pytest.approx(energy.max(), rel=1e-4)
        by_order = record[f"{stem}/mean_by_order"].values
        assert by_order.sum() == pytest.approx(energy.mean(), rel=1e-11)


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_a_body_that_nothing_holds_in_one_direction(method: str) -> None:
    table = bare(method=method, run_up={"from": 0.0, "to": 400.0})
    table["excitation"] = {"working": ["A"], "driven_machine": "cancels_torque"}
    values = table["machine"]["mounts"]["stiffness_matrix"]["values"]
    free = 1
    for n in range(6):
        values[free][n] = values[n][free] = 0.0
    record = run(table)
    natural = record["response/modes/natural_frequency"]
    assert natural.values[0] <= natural.error_estimate
    assert np.all(natural.values[1:] > 50.0)
    assert "response/modes/damping_ratio" not in record
    mass, stiffness = matrices_of(table)
    want = solve_orders(mass, stiffness, 0.0, six_load(record), 361.0)
    assert six(record) == pytest.approx(want, abs=1e-12 * np.abs(want).max())
    assert np.abs(record["response/ground_force"].values[:, free]).max() == 0.0
    curve = record["response/run_up/kinetic_energy"]
    assert curve.axes[0].values[0] == 0.0 and curve.values[0] == 0.0
    speed, load = float(curve.axes[0].values[1]), six_load(record) / 361.0**2
    slow = solve_orders(mass, stiffness, 0.0, speed**2 * load, speed)
    rates = speed * np.arange(1, len(slow) + 1)[:, None] * slow
    assert curve.values[1] == pytest.approx(
        np.sum((rates.conj() * (rates @ mass)).real) / 4.0, rel=1e-9
    )


def diagonal(order: int, coordinate: int, away: float = 0.0, **response: Any) -> Table:
    """A body whose mode along one coordinate is where an order is at 100 rad/s times 1 + away."""
    table = bare(**response)
    table["machine"]["speed"] = 100.0 * (1.0 + away)
    table["excitation"] = {"working": ["A"], "driven_machine": "cancels_torque"}
    mass = np.array([4.0, 4.0, 4.0, 0.5, 0.5, 0.5])
    natural = np.array([310.0, 330.0, 350.0, 370.0, 390.0, 415.0])
    natural[coordinate] = 100.0 * order
    table["machine"]["body"] = {"mass_matrix": {"values": np.diag(mass).tolist()}}
    stiffness = np.diag(mass * natural**2)
    table["machine"]["mounts"] = {"stiffness_matrix": {"values": stiffness.tolist()}}
    return table


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_an_order_on_an_undamped_natural_frequency_is_refused_by_name(method: str) -> None:
    with pytest.raises(NumericalFailure) as failure:
        run(diagonal(2, 1, method=method))
    words = str(failure.value)
    assert "order 2 at 100 rad/s" in words and "mode 1, 200 rad/s" in words
    assert failure.value.exit_code == 3
    with_operations = diagonal(2, 1, method=method)
    with_operations["response"]["operations"] = [{"name": "A", "working": ["A"]}]
    with_operations["excitation"] = {"working": ["A"], "idle": "unloaded"}
    with pytest.raises(NumericalFailure, match="order 2 at 100 rad/s"):
        run(with_operations)


@pytest.mark.parametrize(
    ("method", "away"),
    [
        ("modal", 1e-9),
        ("direct", 1e-7),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in (("modal", 1e-7), ("modal", -1e-7), ("direct", -1e-7), ("direct", 1e-9))
        ),
    ],
)
def test_next_to_it_the_error_estimates_hold(method: str, away: float) -> None:
    table = diagonal(2, 1, away, method=method)
    case = validate(copy.deepcopy(table))
    record = run_case(case)
    checked = 0
    with mpmath.workdps(50):
        for path, values, exact in response_results(case, record):
            truth = np.array(exact, dtype=object).reshape(np.shape(values))
            error = max(map(abs, np.ravel(truth - values).tolist()))
            assert error <= 10.0 * record[path].error_estimate, path
            checked += 1
    assert checked >= 20
    moved = record["response/translation_harmonics"]
    worse = moved.error_estimate / np.abs(moved.values).max()
    assert 1e-2 * UNIT / abs(away) < worse < 1e2 * UNIT / abs(away)


@pytest.mark.parametrize("method", ["modal", "direct"])
def test_a_mode_that_is_met_and_not_driven_is_a_warning(method: str) -> None:
    table = diagonal(2, 2, method=method, run_up={"from": 50.0, "to": 150.0})
    record = run(table)
    (warning,) = [text for text in record.warnings if "order 2 at 100 rad/s" in text]
    assert "does not drive it" in warning and "mode 1" in warning
    assert np.abs(record["response/translation_harmonics"].values[:, 2]).max() < 1e-25
    mass, stiffness = matrices_of(table)
    stiffness[2, 2] *= 2.0
    want = solve_orders(mass, stiffness, 0.0, six_load(record), 100.0)
    assert six(record) == pytest.approx(want, abs=1e-12 * np.abs(want).max())


def test_the_order_next_to_a_mode() -> None:
    record = run(diagonal(2, 1, 1e-3))
    natural = record["response/modes/natural_frequency"].values
    nearest = record["response/modes/nearest_order"].values
    orders = np.array([1, *range(2, 12, 2)])  # one cylinder with its throw: 1 and the even ones
    ratio = orders * 100.1 / natural[:, None]
    best = np.argmin(np.abs(np.log(ratio)), axis=1)
    assert np.array_equal(nearest, orders[best])
    assert record["response/modes/distance"].values == pytest.approx(
        ratio[np.arange(6), best] - 1.0, abs=1e-12
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_run_holds_what_its_plan_says(seed: int) -> None:
    table = random_compressor(seed)
    speed = table["machine"]["speed"]
    table["response"]["run_up"] = {"from": 0.99 * speed, "to": speed}
    assert set(run(table)) == set(planned_quantities(validate(copy.deepcopy(table))))


def test_speeds_of_a_run_up_are_single_runs() -> None:
    table = bare(run_up={"from": 50.0, "to": 400.0})
    table["machine"]["mounts"]["modal_damping"] = 0.01
    del table["excitation"]["orders"]
    record = run(table)
    speeds = record["response/run_up/kinetic_energy"].axes[0].values
    table["response"].pop("run_up")
    for index in (0, 137, int(np.argmax(record["response/run_up/kinetic_energy"].values)), -1):
        table["machine"]["speed"] = float(speeds[index])
        single = run(table)
        for name in ("kinetic", "potential"):
            ours, other = (
                record[f"response/run_up/{name}_energy"],
                single[f"response/{name}_energy/mean"],
            )
            off = abs(ours.values[index] - float(other.values))
            assert off <= ours.error_estimate + other.error_estimate
            assert off <= 1e-8 * float(other.values)


def test_a_run_up_leaves_out_undamped_resonances_and_lists_them() -> None:
    table = diagonal(2, 1, 1e-3, run_up={"from": 60.0, "to": 250.0})
    record = run(table)
    masked = {
        name: record[f"response/masked/{name}"].values
        for name in ("low", "centre", "high", "order", "mode")
    }
    listed = set(zip(masked["order"].tolist(), masked["mode"].tolist(), strict=True))
    natural = record["response/modes/natural_frequency"].values
    # the piston drives y and rx, by its lever; the throw x and ry too
    coordinate = np.argmax(record["response/modes/energy_fraction"].values, axis=1)
    expected = {
        (order, mode)
        for order, allowed in {1: (0, 1, 3, 4), 2: (1, 3), 4: (1, 3), 6: (1, 3)}.items()
        for mode in range(1, 7)
        if coordinate[mode - 1] in allowed and 60.0 <= natural[mode - 1] / order <= 250.0
    }
    assert len(expected) == 5 and listed == expected
    assert masked["centre"] == pytest.approx(
        natural[masked["mode"].astype(int) - 1] / masked["order"], rel=1e-12
    )
    speeds = record["response/run_up/kinetic_energy"].axes[0].values
    for low, high in zip(masked["low"], masked["high"], strict=True):
        assert not np.any((speeds > low) & (speeds < high))
        assert low in speeds and high in speeds


def test_orders_that_are_not_kept_are_in_the_error_of_a_run_up() -> None:
    """Kept to the second order, the curve lacks the resonances of the fourth."""
    table = bare(run_up={"from": 10.0, "to": 30.0})
    table["machine"]["mounts"]["modal_damping"] = 0.02
    table["excitation"] = {"working": ["A"], "orders": 2}
    cut = run(table)["response/run_up/kinetic_energy"]
    del table["excitation"]["orders"]
    whole = run(table)["response/run_up/kinetic_energy"]
    there = np.interp(cut.axes[0].values, whole.axes[0].values, whole.values)
    lacking = np.max(np.abs(there - cut.values))
    assert lacking > 1e-3 * np.max(whole.values)
    assert 0.5 * lacking < cut.error_estimate < 5.0 * lacking


@pytest.mark.long
def test_a_weak_order_costs_no_points() -> None:
    """Each order has six resonances; a curve shows those of the few that can be seen."""
    few, many = (
        run(bare(run_up={"from": 3.0, "to": 80.0}) | {"excitation": {"orders": orders}})
        for orders in (10, 24)
    )
    points = [len(record["response/run_up/kinetic_energy"].values) for record in (few, many)]
    masked = [len(record["response/masked/centre"].values) for record in (few, many)]
    assert masked[1] > masked[0] + 30
    assert points[1] - points[0] <= 2 * (masked[1] - masked[0]) + 6 * 73
