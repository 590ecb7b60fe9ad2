"""Claim: forces and couples of whole crank trains are those of Newton's and Euler's laws in time.

Nothing of vibecalc takes part in the truth. Every moving part is a point mass whose place follows
from circles and right triangles; its momentum is differentiated. What that does to the body at each
instant is what the complex amplitudes of the result say, phases and all.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest
from long_but import long_but
from random_machines import Table, random_machine
from scipy.spatial.transform import Rotation

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case

Array = np.ndarray[Any, np.dtype[Any]]
AXES = dict(zip("xyz", np.eye(3), strict=True))
SAMPLES = 2048


def machine(seed: int) -> Table:
    """A random machine with every kind of moving part."""
    case = random_machine(seed, "rigid_body")
    del case["isolation"]["run_up"], case["accuracy"]
    case.pop("kinematics", None)
    case["excitation"] = {"driven_machine": ["cancels_torque", "on_body"][seed % 2]}
    generator, train = np.random.default_rng(seed), case["machine"]["crank_train"]
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


def signal(record: Record, path: str, angle: Array) -> Array:
    """A result over orders as a signal (instants, ...) of the crank angle."""
    quantity = record[path]
    place = [axis.name for axis in quantity.axes].index("order")
    turn = np.exp(1j * np.multiply.outer(angle, quantity.axes[place].values))
    values = np.moveaxis(quantity.values, place, 0)
    found: Array = np.tensordot(turn, values, axes=1).real
    return found


@pytest.mark.parametrize("seed", long_but(range(8), 0, 1, 2))
def test_forces_and_couples_of_the_moving_parts(seed: int) -> None:
    case = machine(seed)
    record = run_case(validate(case), wanted=frozenset({"excitation/force", "excitation/couple"}))
    angle = np.arange(SAMPLES) * (2.0 * np.pi / SAMPLES)
    for name, true in load_of(case)._asdict().items():
        true = true - true.mean(axis=0)
        off = np.max(np.abs(signal(record, f"excitation/{name}", angle) - true))
        assert off <= 1e-7 * np.max(np.abs(true)), name
