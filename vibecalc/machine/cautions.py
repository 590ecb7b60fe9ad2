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
from vibecalc.machine.plausibility import implausible
from vibecalc.machine.roll_cautions import asks_roll, roll_cautions
from vibecalc.torsion.checks import torsion_cautions
from vibecalc.torsion.model import throw_cautions

Array = NDArray[np.float64]
NOTICEABLE = 1e-6
#: results of [isolation] that have the shaking alone
SHAKING = ("isolation/support_force/", "isolation/support_displacement/", "isolation/body/")


def machine_warnings(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    if not has_crank_train(case.machine):
        return [*implausible(case), *_without_effect(case), *roll_cautions(case)]
    return [
        *implausible(case),
        *_places(case),
        *_orders(case),
        *_pitch_coupling(case),
        *_without_effect(case),
        *_rod(case),
        *_shaking_alone(case),
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


def _shaking_alone(case: Case) -> list[str]:
    """Targets that hold the shaking alone although the torque of the gas reaches the mounts."""
    if not torque_reaches_mounts(case):
        return []
    named = dict.fromkeys(limit.quantity for limit in case.limit)
    if case.optimisation is not None and case.optimisation.objective is not None:
        named[case.optimisation.objective.quantity] = None
    return [
        f"{quantity} is of the shaking and the inertia torque, without the torque of the gas: "
        "isolation/torque_reaction/ has all of it"
        for quantity in named
        if quantity.startswith(SHAKING)
        and "run_up" not in quantity
        and not quantity.endswith(("/sag", "/static"))
    ]


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
