"""Claim: whole machines, followed in time from Newton's and Euler's laws, settle to our results.

Nothing of vibecalc takes part in the truth. Every moving part is a point mass whose place follows
from circles and right triangles; its momentum is differentiated; the body is integrated over many
turns from rest in its mounts. What the mounts then push on the ground, at each instant, is what
the complex amplitudes of the result say, phases and all.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from long_but import long_but
from random_machines import Table, random_machine
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case

Array = np.ndarray[Any, np.dtype[Any]]
AXES = dict(zip("xyz", np.eye(3), strict=True))
SAMPLES, TURNS = 2048, 60
SEEDS = range(8)


def machine(seed: int) -> Table:
    """A random machine whose transients die out within the turns that are followed."""
    case = random_machine(seed, "rigid_body")
    del case["isolation"]["run_up"], case["accuracy"]
    case.pop("kinematics", None)
    case["excitation"] = {"driven_machine": ["cancels_torque", "on_body"][seed % 2]}
    generator, mounts = np.random.default_rng(seed), case["machine"]["mounts"]
    train, speed = case["machine"]["crank_train"], case["machine"]["speed"]
    train["wrist_pin_offset"] = 0.1 * train["crank_radius"]
    train["rod_length"] = train["crank_radius"] / generator.uniform(0.15, 0.35)
    train["rotating_mass"] = 0.4
    train["counterweights"] = [{"name": "weight", "unbalance": 0.01, "phase": 0.7, "position": 0.2}]
    train["balance_shafts"] = [
        {"name": "back", "unbalance": 0.02, "speed_ratio": -1, "phase": -0.4,
         "position": [0.1, -0.2, 0.3]},
        {"name": "fast", "unbalance": 0.005, "speed_ratio": 2, "phase": 1.9,
         "position": [-0.3, 0.1, 0.2]},
    ]  # fmt: skip
    stiffness = case["machine"]["body"]["mass"] * speed**2 * generator.uniform(0.02, 0.6)
    named = mounts.pop("individual", None) or [
        {"name": str(n), "position": place} for n, place in enumerate(mounts.pop("positions"))
    ]
    mounts.clear()
    for mount in named:
        mount["stiffness"] = (stiffness * generator.uniform(0.3, 1.0, 3)).tolist()
        mount["damping"] = (0.3 * stiffness / speed * generator.uniform(0.5, 1.0, 3)).tolist()
        mount["orientation"] = generator.uniform(-3.0, 3.0, 3).tolist()
    mounts["individual"] = named
    return case


class Load(NamedTuple):
    """Forces and couples (samples, 3) on the body over one turn, about its reference point."""

    force: Array
    couple: Array


def derivative(signal: Array, speed: float) -> Array:
    """Derivative by time of a smooth periodic signal (samples, ...), by its Fourier series."""
    orders = np.fft.rfftfreq(SAMPLES, 1.0 / SAMPLES).reshape(-1, *[1] * (signal.ndim - 1))
    found: Array = np.fft.irfft(1j * speed * orders * np.fft.rfft(signal, axis=0), SAMPLES, axis=0)
    return found


def load_of(case: Table) -> Load:
    train, speed = case["machine"]["crank_train"], case["machine"]["speed"]
    axis, stroke = AXES[train["axis"]], AXES[train["stroke"]]
    origin = np.array(train.get("origin", [0.0, 0.0, 0.0]))
    crank = np.arange(SAMPLES) * (2.0 * np.pi / SAMPLES)

    def arm(angle: Any) -> Array:
        """The stroke turned about the shaft, right-handed."""
        turned: Array = Rotation.from_rotvec(np.multiply.outer(angle, axis)).apply(stroke)
        return turned

    force, couple = np.zeros((SAMPLES, 3)), np.zeros((SAMPLES, 3))

    def push(mass: float, place: Array) -> None:
        """What a point mass does to the body: minus the rates of its two momenta."""
        momentum = mass * derivative(place - place.mean(axis=0), speed)
        force[:] -= derivative(momentum, speed)
        couple[:] -= derivative(np.cross(place, momentum), speed)

    rod = train.get("rod", {"mass": 0.0, "reciprocating_fraction": 0.0})
    share = rod.get("reciprocating_fraction", 0.0)
    share = rod.get("crank_pin_to_mass_centre", share * train["rod_length"]) / train["rod_length"]
    common = train.get("piston_mass", 0.0) + train.get("pin_mass", 0.0) + share * rod["mass"]
    common = train.get("reciprocating_mass", common)
    for cylinder in train["cylinders"]:
        base = origin + cylinder["position"] * axis
        pin = base + train["crank_radius"] * arm(crank + cylinder["crank_phase"])
        outward = arm(cylinder["bank_angle"])
        sideways = np.cross(axis, outward)
        foot = base + train["wrist_pin_offset"] * sideways
        lag = (pin - foot) @ sideways
        height = (pin - foot) @ outward + np.sqrt(train["rod_length"] ** 2 - lag**2)
        mass = cylinder.get("reciprocating_mass", common)
        push(mass, foot + height[:, None] * outward)
        push(train["rotating_mass"] + (1.0 - share) * rod["mass"], pin)
        if case["excitation"]["driven_machine"] == "on_body":
            # the torque that keeps the crankshaft at speed comes from outside of the body
            rate = derivative(height - height.mean(), speed)
            couple += (derivative(0.5 * mass * rate**2, speed) / speed)[:, None] * axis
    for weight in train["counterweights"]:
        place = arm(crank + weight["phase"])
        push(weight["unbalance"], place + (origin + weight["position"] * axis))
    for shaft in train["balance_shafts"]:
        centre = origin + np.array(shaft["position"])
        push(shaft["unbalance"], centre + arm(shaft["speed_ratio"] * crank + shaft["phase"]))
    return Load(force, couple)


class Rig(NamedTuple):
    """Mass matrix (6, 6), and of n mounts: place (n, 3), stiffness and damping (n, 3, 3)."""

    mass: Array
    place: Array
    stiffness: Array
    damping: Array


def rig_of(case: Table) -> Rig:
    body = case["machine"]["body"]
    centre, inertia, mass = np.zeros(3), np.zeros((3, 3)), 0.0
    for part in (body, body.get("inertia_block", {"mass": 0.0, "inertia": [0.0, 0.0, 0.0]})):
        own, arm = part["mass"], np.array(part.get("position", [0.0, 0.0, 0.0]))
        if "box" in part:
            square = np.array([part["box"][edge] for edge in ("length", "width", "height")]) ** 2
            inertia += np.diag(own / 12.0 * (np.sum(square) - square))
        else:
            xy, xz, yz = part.get("inertia_products", (0.0, 0.0, 0.0))
            inertia += np.diag(part["inertia"])
            inertia -= np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
        inertia += own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        centre += own * arm
        mass += own
    matrix = np.zeros((6, 6))
    for n, unit in enumerate(np.eye(3)):
        # momentum, and angular momentum, of a unit velocity and of a unit rate of turning
        matrix[:, n] = np.concatenate([mass * unit, np.cross(centre, unit)])
        matrix[:, 3 + n] = np.concatenate([np.cross(unit, centre), inertia @ unit])
    mounts = case["machine"]["mounts"]["individual"]
    turns = Rotation.from_euler("xyz", [m["orientation"] for m in mounts]).as_matrix()

    def along_body(key: str) -> Array:
        own = np.array([mount[key] for mount in mounts])
        found: Array = np.einsum("nij,nj,nkj->nik", turns, own, turns)
        return found

    places = np.array([mount["position"] for mount in mounts])
    return Rig(matrix, places, along_body("stiffness"), along_body("damping"))


def pushed(rig: Rig, state: Array) -> Array:
    """Forces (..., mounts, 3) of the mounts on the ground, of states (..., 12)."""
    shift, turn, drift, rate = (state[..., None, 3 * n : 3 * n + 3] for n in range(4))
    strain = shift + np.cross(turn, rig.place)
    slip = drift + np.cross(rate, rig.place)
    found: Array = np.einsum("nij,...nj->...ni", rig.stiffness, strain)
    return found + np.einsum("nij,...nj->...ni", rig.damping, slip)


def followed(case: Table, instants: Array) -> tuple[Array, Array]:
    """States (instants, 12) in the last turn of many, and the mounts' forces on the ground."""
    rig, speed = rig_of(case), case["machine"]["speed"]
    harmonics = np.fft.rfft(np.concatenate(load_of(case), axis=1), axis=0) * (2.0 / SAMPLES)
    harmonics = harmonics[1:40]
    orders = np.arange(1, len(harmonics) + 1)

    def acceleration(state: Array, load: Array) -> Array:
        reaction = pushed(rig, state)
        net = load - np.concatenate(
            [reaction.sum(axis=0), np.cross(rig.place, reaction).sum(axis=0)]
        )
        found: Array = np.linalg.solve(rig.mass, net)
        return found

    # Newton and Euler for one unit of each state and of each load, since both enter linearly
    by_state = np.array([acceleration(unit, np.zeros(6)) for unit in np.eye(12)]).T
    by_load = np.array([acceleration(np.zeros(12), unit) for unit in np.eye(6)]).T
    driving = by_load @ harmonics.T

    def rate(time: float, state: Array) -> Array:
        driven = (driving @ np.exp(1j * speed * time * orders)).real
        return np.concatenate([state[6:], by_state @ state + driven])

    turn = 2.0 * np.pi / speed
    times = (TURNS + instants) * turn
    # follow the transient with large steps, the last turn with care
    begin = solve_ivp(rate, (0.0, TURNS * turn), np.zeros(12), method="DOP853", rtol=1e-9)
    end = solve_ivp(
        rate, (TURNS * turn, (TURNS + 1) * turn), begin.y[:, -1], method="DOP853",
        t_eval=times, rtol=1e-11, atol=1e-14 * float(np.max(np.abs(begin.y))),
    )  # fmt: skip
    return end.y.T, pushed(rig, end.y.T)


@cache
def whole(seed: int) -> tuple[Table, Record]:
    case = machine(seed)
    return case, run_case(validate(case))


def signal(record: Record, path: str, angle: Array) -> Array:
    """A result over orders as a signal (instants, ...) of the crank angle."""
    quantity = record[path]
    place = [axis.name for axis in quantity.axes].index("order")
    turn = np.exp(1j * np.multiply.outer(angle, quantity.axes[place].values))
    values = np.moveaxis(quantity.values, place, 0)
    found: Array = np.tensordot(turn, values, axes=1).real
    return found


@pytest.mark.parametrize("seed", long_but(SEEDS, 0, 1, 2))
def test_forces_and_couples_of_the_moving_parts(seed: int) -> None:
    case, record = whole(seed)
    angle = np.arange(SAMPLES) * (2.0 * np.pi / SAMPLES)
    for name, true in load_of(case)._asdict().items():
        true = true - true.mean(axis=0)
        off = np.max(np.abs(signal(record, f"excitation/{name}", angle) - true))
        assert off <= 1e-7 * np.max(np.abs(true)), name


@pytest.mark.parametrize("seed", long_but([0, 1, 2], 0))
def test_the_body_settles_to_the_steady_state(seed: int) -> None:
    case, record = whole(seed)
    instants = np.linspace(0.05, 0.95, 7)
    state, force = followed(case, instants)
    angle = 2.0 * np.pi * instants
    results = (
        ("isolation/body/translation_harmonics", state[:, :3]),
        ("isolation/body/rotation_harmonics", state[:, 3:6]),
        ("isolation/support_force/steady_harmonics", force),
    )
    for path, true in results:
        found = signal(record, path, angle)
        assert np.max(np.abs(found - true)) <= 1e-6 * np.max(np.abs(true)), path
    longest = np.max(np.linalg.norm(force, axis=2), axis=0)
    peak = record["isolation/support_force/steady_peak"].values
    assert np.all(longest <= peak * (1.0 + 1e-6))
