"""What is possible but unlikely, or less exact than it looks."""

import math

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts
from vibecalc.case.engine_mounted import has_gas, torque_reaches_mounts
from vibecalc.case.kinds import finds_speed, gas_turns, has_crank_train, has_speed
from vibecalc.case.schema import Case, Machine
from vibecalc.machine.body import build_body
from vibecalc.machine.crank_train import build_crank_train, rod_share
from vibecalc.machine.frame import build_frame
from vibecalc.machine.mounts import Mounts, build_mounts
from vibecalc.machine.operation_checks import has_loss_factor
from vibecalc.machine.roll_cautions import asks_roll, roll_cautions
from vibecalc.machine.throw_cautions import throw_cautions
from vibecalc.machine.torsion_cautions import torsion_cautions

Array = NDArray[np.float64]
#: m/s, m and a share: beyond these a case gets a sentence in its report.
FASTEST_PISTON = 60.0
DEEPEST_SAG = 0.5
NOTICEABLE = 1e-6
#: of an engine: bore over stroke or the other way round, and kg/m^3
WIDEST = 6.0
STEEL = 7850.0


def machine_warnings(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    if not has_crank_train(case.machine):
        return [*_without_effect(case), *roll_cautions(case)]
    return [
        *_units(case),
        *_places(case),
        *_orders(case),
        *_pitch_coupling(case),
        *_without_effect(case),
        *_rod(case),
        *_sizes(case),
        *throw_cautions(case),
        *roll_cautions(case),
        *torsion_cautions(case),
    ]


def _placed(machine: Machine) -> tuple[parts.Body, parts.Mounts] | None:
    """Body and mounts, if neither is missing nor a matrix."""
    body, mounts = machine.body, machine.mounts
    if body is None or mounts is None:
        return None
    matrices = body.mass_matrix is not None or mounts.stiffness_matrix is not None
    return None if matrices else (body, mounts)


def _units(case: Case) -> list[str]:
    machine, train = case.machine, case.machine.crank_train
    texts = []
    speed = machine.speed if has_speed(machine) else _synchronous(machine)
    mean = 2.0 * train.crank_radius * speed / math.pi
    if mean > FASTEST_PISTON:
        texts.append(
            f"the mean piston speed is {mean:.3g} m/s, where engines stay below 30: "
            "is the speed in rad/s ('4900 rpm' otherwise) and the crank radius in m?"
        )
    angles = [(f"crank_phase of cylinder '{c.name}'", c.crank_phase) for c in train.cylinders]
    angles += [(f"bank_angle of cylinder '{c.name}'", c.bank_angle) for c in train.cylinders]
    angles += [(f"phase of '{weight.name}'", weight.phase) for weight in train.counterweights]
    angles += [(f"phase of '{shaft.name}'", shaft.phase) for shaft in train.balance_shafts]
    far = [(what, angle) for what, angle in angles if abs(angle) > 4.0 * math.pi + 1e-6]
    texts += [
        f"the {what} is {angle:.6g} rad, more than two turns: "
        f"should it be '{angle:.6g} deg'? Angles without a unit are in radians"
        for what, angle in far
    ]
    placed = _placed(machine)
    if case.isolation is not None and placed is not None:
        own, mounts = placed
        stiffness = build_mounts(mounts).stiffness.sum(axis=0)
        up = "xyz".index(case.isolation.up)
        weight = build_body(own).mass * case.isolation.gravity
        if weight > DEEPEST_SAG * stiffness[up, up] > 0.0:
            texts.append(
                f"under its weight the machine sinks by about {weight / stiffness[up, up]:.3g} m: "
                "is the stiffness of the mounts in N/m ('10 kN/m', '10 N/mm' otherwise)?"
            )
    return texts


def _synchronous(machine: Machine) -> float:
    """Speed in rad/s that the motor stays below; zero where nothing is said to turn."""
    motor = machine.motor
    return motor.synchronous_speed if motor is not None and finds_speed(machine) else 0.0


def _places(case: Case) -> list[str]:
    roll = None if case.response is None else case.response.roll
    if not has_speed(case.machine) and not (roll is not None and roll.classical):
        return []  # no couples are computed
    if case.machine.kind == "engine" and case.machine.body is None and case.excitation is None:
        return []  # only torques on a shaft line
    train = build_crank_train(case.machine.crank_train)
    seen: dict[tuple[float, float], str] = {}
    texts = []
    for name, place, bank in zip(train.names, train.position, train.bank_angle, strict=True):
        spot = (float(place), float(bank))
        if spot in seen:
            texts.append(
                f"cylinders '{seen[spot]}' and '{name}' stand in the same place, at position "
                f"{place:.6g} m and bank angle {bank:.6g} rad: couples between them are zero"
            )
        seen.setdefault(spot, name)
    return texts


def _orders(case: Case) -> list[str]:
    highest = None if case.excitation is None else case.excitation.orders
    if highest is None:
        return []
    return [
        f"balance shaft '{shaft.name}' turns at {abs(shaft.speed_ratio)} times the crank speed "
        f"and is left out, since excitation.orders = {highest}"
        for shaft in case.machine.crank_train.balance_shafts
        if abs(shaft.speed_ratio) > highest
    ]


def _without_effect(case: Case) -> list[str]:
    machine, response = case.machine, case.response
    mounts, switching = machine.mounts, None if response is None else response.switching
    impact = None if response is None else response.impact
    texts = {
        "[machine.motor] has no effect: its axial force is computed where there is an "
        "[excitation]": (
            machine.motor is not None and not finds_speed(machine) and case.excitation is None
        ),
        "[machine.joints] have no effect: their play is for [response.impact]": (
            machine.joints is not None and impact is None
        ),
        "the gas pressure has no effect: only [response.impact] and the roll of the machine use "
        "it": (
            has_crank_train(machine)
            and machine.crank_train.gas_pressure is not None
            and not gas_turns(machine)
            and impact is None
            and not asks_roll(case)
        ),
        "the gas has no effect: without [response.torsion] it reaches the mounts in the model "
        "'rigid_body' or 'planar', of an engine with a firing order, unless driven_machine = "
        "'cancels_torque'": (
            gas_turns(machine)
            and has_gas(case)
            and not torque_reaches_mounts(case)
            and (response is None or response.torsion is None)
        ),
    }
    if mounts is not None:
        texts |= {
            "modal_damping counts in [response] only, not in [isolation]": (
                bool(mounts.modal_damping) and case.isolation is not None
            ),
            "while the machine changes between operations, the loss factor counts as the damping "
            "ratio that it gives each mode at resonance": (
                has_loss_factor(mounts) and switching is not None
            ),
        }
    return [text for text, holds in texts.items() if holds]


def _rod(case: Case) -> list[str]:
    train = case.machine.crank_train
    rod, share = train.rod, rod_share(train)
    if rod is None or rod.inertia is None:
        return []
    between = rod.mass * train.rod_length**2 * share * (1.0 - share)
    if rod.inertia <= between * (1.0 + NOTICEABLE):
        return []
    return [
        f"the rod's moment of inertia is {rod.inertia:.4g} kg*m^2, more than the {between:.4g} "
        "kg*m^2 of a rod whose material lies between its bearings: is it about the mass centre?"
    ]


def _sizes(case: Case) -> list[str]:
    """Parts of an engine that do not fit each other: a wrong unit, or a digit too many."""
    train, rod = case.machine.crank_train, case.machine.crank_train.rod
    if case.machine.kind != "engine":
        return []
    texts, stroke = [], 2.0 * train.crank_radius
    if train.bore is not None and not stroke / WIDEST <= train.bore <= stroke * WIDEST:
        texts.append(
            f"the bore is {train.bore:.3g} m at a stroke of {stroke:.3g} m: engines have the two "
            "nearly alike; are both in m ('76 mm' otherwise)?"
        )
    solid = STEEL * train.rod_length**3
    masses = {
        "the rod": None if rod is None else rod.mass,
        "what moves with a piston": train.reciprocating_mass,
        "a piston": train.piston_mass,
        "a wrist pin": train.pin_mass,
    }
    texts += [
        f"{what} weighs {mass:.3g} kg, more than a cube of steel as long as the rod, {solid:.3g} "
        "kg: is the mass in kg ('1 g' otherwise) and the length in m?"
        for what, mass in masses.items()
        if mass is not None and mass > solid
    ]
    return texts


def _pitch_coupling(case: Case) -> list[str]:
    """What the pitch model leaves out of the body's other five motions, as shares."""
    machine = case.machine
    if case.isolation is None or case.isolation.model != "pitch":
        return []
    placed = _placed(machine)
    if placed is None:
        return []
    body, mounts = build_body(placed[0]), build_mounts(placed[1])
    frame = build_frame(machine.crank_train.axis, machine.crank_train.stroke)
    place = mounts.position - body.centre
    texts = []

    pitch = np.cross(frame.across, place)  # displacement of each mount for a unit of pitch
    heights = (place @ frame.stroke)[:, None] * np.cross(frame.across, frame.stroke)
    exact = _work(mounts, pitch, pitch)
    model = _work(mounts, pitch - heights, pitch - heights)
    if abs(exact - model) > NOTICEABLE * model:
        texts.append(
            f"the pitch model leaves out {100.0 * abs(exact - model) / model:.3g} % of the pitch "
            "stiffness, from mounts above or below the mass centre; rigid_body has it"
        )
    others = [np.broadcast_to(row, place.shape) for row in (frame.axis, frame.across, frame.stroke)]
    others += [np.cross(turn, place) for turn in (frame.axis, frame.stroke)]
    names = [f"motion along {_name(row)}" for row in (frame.axis, frame.across, frame.stroke)]
    names += [f"turning about {_name(row)}" for row in (frame.axis, frame.stroke)]
    coupled = []
    for name, motion in zip(names, others, strict=True):
        scale = math.sqrt(max(exact, model) * _work(mounts, motion, motion))
        if abs(_work(mounts, pitch, motion)) > NOTICEABLE * scale:
            coupled.append(name)
    inertia = body.inertia @ frame.across
    for axis in (frame.axis, frame.stroke):
        share = abs(float(axis @ inertia)) > NOTICEABLE * float(frame.across @ inertia)
        name = f"turning about {_name(axis)}"
        if share and name not in coupled:
            coupled.append(name)
    if coupled:
        texts.append(
            "pitch is coupled with " + ", ".join(coupled) + ": the pitch model is then an "
            "approximation, and rigid_body is exact"
        )
    return texts


def _work(mounts: Mounts, first: Array, second: Array) -> float:
    """Stiffness between two motions given by their displacements (n, 3) at the mounts."""
    return float(np.einsum("ni,nij,nj->", first, mounts.stiffness, second))


def _name(direction: Array) -> str:
    return "xyz"[int(np.argmax(np.abs(direction)))]
