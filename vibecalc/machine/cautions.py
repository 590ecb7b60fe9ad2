"""What is possible but unlikely, or less exact than it looks."""

import math

import numpy as np
from numpy.typing import NDArray

from vibecalc.case.schema import Case
from vibecalc.machine.body import build_body
from vibecalc.machine.crank_train import build_crank_train
from vibecalc.machine.frame import build_frame
from vibecalc.machine.mounts import Mounts, build_mounts

Array = NDArray[np.float64]
#: m/s, m and a share: beyond these a case gets a sentence in its report.
FASTEST_PISTON = 60.0
DEEPEST_SAG = 0.5
NOTICEABLE = 1e-6


def machine_warnings(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    return [
        *_units(case),
        *_places(case),
        *_orders(case),
        *_pitch_coupling(case),
    ]


def _units(case: Case) -> list[str]:
    machine, train = case.machine, case.machine.crank_train
    texts = []
    mean = 2.0 * train.crank_radius * machine.speed / math.pi
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
    if case.isolation is not None and machine.body is not None and machine.mounts is not None:
        stiffness = build_mounts(machine.mounts).stiffness.sum(axis=0)
        up = "xyz".index(case.isolation.up)
        weight = build_body(machine.body).mass * case.isolation.gravity
        if weight > DEEPEST_SAG * stiffness[up, up] > 0.0:
            texts.append(
                f"under its weight the machine sinks by about {weight / stiffness[up, up]:.3g} m: "
                "is the stiffness of the mounts in N/m ('10 kN/m', '10 N/mm' otherwise)?"
            )
    return texts


def _places(case: Case) -> list[str]:
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


def _pitch_coupling(case: Case) -> list[str]:
    """What the pitch model leaves out of the body's other five motions, as shares."""
    machine = case.machine
    if case.isolation is None or case.isolation.model != "pitch":
        return []
    if machine.body is None or machine.mounts is None:
        return []
    body, mounts = build_body(machine.body), build_mounts(machine.mounts)
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
