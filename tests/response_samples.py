"""Results for the tests of the report: a compressor on its suspension, made up by closed forms."""

from typing import Any

import numpy as np
from report_samples import DIRECTIONS, golden, quantity, result_of

from vibecalc.core.results.record import Axis, Quantity, Record, Result

SPEED, RADIUS, LENGTH = 361.0, 0.0127, 0.060325
ORDERS = Axis(name="order", values=np.arange(1, 201))
CLEARANCES = Axis(name="clearance", values=np.array([2.54e-6, 3.81e-5, 2.54e-4]), unit="m")
IMPACT_ORDERS = Axis(name="order", values=np.arange(0, 101))
CONTACTS = Axis(name="contact", values=np.arange(1, 9))
TURN = Axis(name="crank_angle", values=np.linspace(0.0, 2.0 * np.pi, 721), unit="rad")


def compressor(*parts: list[Quantity], **tables: Any) -> Result:
    """A result of some parts, all of them unless named."""
    record = Record()
    chosen = parts or (motion(), modes(), response(), operations(), switching(), impact())
    for item in (item for part in chosen for item in part):
        record.add(item)
    switched = {"between": ["A+B", "A"], "settling_tolerance": 0.05}
    study = {"method": "event_exact", "members": 64, "revolutions": 30, "discard": 10}
    case = {
        "schema": 1,
        "title": "Convertible compressor",
        "machine": {"kind": "compressor", "speed": SPEED},
        "response": {"switching": switched, "impact": {**study, "pressure": "towards_crank"}},
        "accuracy": {"rtol": 1e-9},
        **tables,
    }
    return result_of(record, case, name="compressor")


def _of(*roots: str, of: str = "compressor") -> list[Quantity]:
    """What a compressor really has below some roots."""
    found = golden(of).record.items()
    return [quantity for path, quantity in found if path.startswith(roots)]


def motion() -> list[Quantity]:
    """Motion of the pistons, masses and the rod's inertia."""
    return _of("kinematics/acceleration", "excitation/mass/", "excitation/rod/")


def modes() -> list[Quantity]:
    """Modes of the body."""
    return _of("response/modes/")


def operations() -> list[Quantity]:
    """Energies of three operations with three balances."""
    return _of("response/operations/")


def switching() -> list[Quantity]:
    """Two changes, at once and through rest."""
    return _of("response/switching/", of="compressor_switching")


def by_order(first: float) -> np.ndarray:
    """Energies of 200 orders: odd ones vanish but the first; they underflow near order 150."""
    order = ORDERS.values
    with np.errstate(under="ignore"):
        values = first * 10.0 ** (-2.1 * (order - 1.0))
    return np.where((order % 2 == 0) | (order == 1), values, 0.0)


def response() -> list[Quantity]:
    """Motion of the body, forces on the ground, energies."""
    nothing = np.zeros((200, 3), complex)
    found = [
        quantity("response/translation_harmonics", nothing, "m", ORDERS, DIRECTIONS),
        quantity("response/ground_force", nothing, "N", ORDERS, DIRECTIONS),
        quantity("response/translation_peak", [0.0, 1.46e-5, 6.5e-8], "m", DIRECTIONS),
        quantity("response/rotation_peak", [7.4e-4, 1e-19, 9.3e-7], "rad", DIRECTIONS),
        quantity("response/ground_force_peak", [0.41, 10.8244, 0.31], "N", DIRECTIONS),
        quantity("response/ground_couple_peak", [2.0648, 0.09, 0.04], "N*m", DIRECTIONS),
    ]
    for kind, size in (("kinetic", 0.016), ("potential", 8.4e-4)):
        stem = f"response/{kind}_energy/"
        found += [
            quantity(stem + "mean_by_order", 0.4 * by_order(size), "J", ORDERS),
            quantity(stem + "peak_by_order", by_order(size), "J", ORDERS),
            quantity(stem + "mean", 0.41 * size, "J"),
            quantity(stem + "peak", 1.02 * size, "J"),
        ]
    return found


def impact(count: int = 3) -> list[Quantity]:
    """Statistics of impacts for the first `count` of three clearances."""
    play = Axis(name="clearance", values=CLEARANCES.values[:count], unit="m")
    force = np.array([14.3, 93.9, 1830.0])[:count]
    order = IMPACT_ORDERS.values
    wave = 1.0 + 0.35 * np.sin(1.7 * order) * np.cos(0.31 * order)
    spectrum = force[:, None] * wave / (1.0 + order / 30.0)
    shaking_orders = Axis(name="order", values=np.arange(1, 101))
    with np.errstate(under="ignore"):
        shaking = 580.0 * 10.0 ** (-1.05 * (shaking_orders.values - 1.0))
    shaking = np.where((shaking_orders.values % 2 == 0) | (shaking_orders.values == 1), shaking, 0)
    motor_orders = Axis(name="order", values=np.arange(1, 41))
    motor = 1.2 * np.abs(np.sin(3.0 * motor_orders.values)) + 0.01
    angle = TURN.values
    phase = np.array([0.0, 0.7, 1.9])[:count, None]
    first = 40.0 * force[:, None] * np.maximum(np.cos(23.0 * angle + phase) - 0.93, 0.0)
    first = first * np.sign(np.cos(angle))
    contacts = 0.2 + np.outer(1.0 + np.arange(count), 0.11 * np.arange(8))
    contacts[-1, 6:] = np.inf
    stem = "response/impact/"
    error = float(0.02 * force[-1])
    return [
        quantity(stem + "mean_force", force, "N", play, standard_error=error),
        quantity(stem + "mean_force_low", 0.5 * force, "N", play),
        quantity(stem + "mean_force_high", 1.8 * force, "N", play),
        quantity(stem + "spectrum", spectrum, "N", play, IMPACT_ORDERS),
        quantity(stem + "spectrum_low", 0.2 * spectrum, "N", play, IMPACT_ORDERS),
        quantity(stem + "spectrum_high", 2.3 * spectrum, "N", play, IMPACT_ORDERS),
        quantity(stem + "added_force", 0.5 * spectrum[:, 1:], "N", play, shaking_orders),
        quantity(stem + "average_amplitude", spectrum[:, 1:].mean(axis=1), "N", play),
        quantity(stem + "peak_force", 30.0 * force, "N", play),
        quantity(stem + "peak_force_high", 60.0 * force, "N", play),
        quantity(stem + "impacts", np.array([210.0, 48.5, 7.2])[:count], "", play),
        quantity(stem + "contact_share", np.array([0.62, 0.21, 0.03])[:count], "", play),
        quantity(stem + "dissipated", 1e-3 * force, "J", play),
        quantity(stem + "energy_residual", np.array([3e-13, 2e-12, 0.0])[:count], "", play),
        quantity(stem + "parting", np.array([7.0, 4.0, np.inf])[:count], "", play),
        quantity(stem + "first_contacts", contacts, "rad", play, CONTACTS),
        quantity(stem + "first_turn_force", first, "N", play, TURN),
        quantity(stem + "crank_pin/mean_force", 1.1 * force, "N", play, standard_error=error),
        quantity(stem + "crank_pin/impacts", np.array([200.0, 40.0, 5.0])[:count], "", play),
        quantity(stem + "bore/mean_force", 0.1 * force, "N", play),
        quantity(stem + "bore/impacts", np.array([12.0, 9.0, 2.0])[:count], "", play),
        quantity(stem + "shaking", shaking, "N", shaking_orders),
        quantity(stem + "motor", motor, "N", motor_orders),
        quantity(stem + "dominant_from", np.array([0, 3, 2])[:count], "", play),
    ]
