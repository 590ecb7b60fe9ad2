"""The machine and what it stands on, and the motion of the base at its reference point."""

import numpy as np

from vibecalc.base_motion.tables import BaseHarmonic, BaseMotion, BaseSpectrum
from vibecalc.errors import Problem
from vibecalc.foundation.model import on_body
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import Mounts
from vibecalc.schema import Case


def on_base(case: Case, body: RigidBody, mounts: Mounts) -> OnMounts:
    """A body with all six freedoms on its mounts, on the base or on a body that stands on it."""
    if case.foundation is not None and case.foundation.body is not None:
        return on_body(case.foundation, body, mounts)
    return on_mounts(body, mounts, np.arange(6))


def at_reference(point: tuple[float, float, float]) -> np.ndarray:
    """Matrix (6, 6) that takes the motion of a point of the base to that of the reference point.

    The base turns as a rigid body: u = u_p + r x (0 - p).
    """
    moved = np.eye(6)
    moved[:3] = displacement_at(-np.asarray(point))
    return moved


def frequency_of(one: BaseHarmonic, case: Case) -> float:
    """Frequency in rad/s, said or as a multiple of the speed."""
    return one.frequency if one.frequency is not None else (one.order or 0.0) * case.machine.speed


def amplitude_of(one: BaseHarmonic, frequency: float) -> np.ndarray:
    """Displacement and rotation (6,) of the point in complex amplitude, m and rad, 0 to peak."""
    parts = []
    for given, phase in (
        ((one.displacement, one.velocity, one.acceleration), one.phase),
        ((one.angle, one.angular_velocity, one.angular_acceleration), one.angular_phase),
    ):
        value = np.zeros(3, dtype=complex)
        for power, amplitude in enumerate(given):
            if amplitude is not None:
                value = np.asarray(amplitude) / (1j * frequency) ** power
        parts.append(value * np.exp(1j * np.asarray(phase)))
    return np.concatenate(parts)


def densities_of(one: BaseSpectrum) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in rad/s and density of the acceleration, or of the velocity times w^2, there.

    Straight lines of a velocity density in logarithmic scales are straight for the acceleration.
    """
    given = one.acceleration or one.velocity or one.angular_acceleration
    assert given is not None
    return np.asarray(given.frequency), np.asarray(given.density)


def base_motion_problems(case: Case) -> list[Problem]:
    """Problems of a base motion on a machine without other problems."""
    motion, machine = case.base_motion, case.machine
    if motion is None or machine.body is None or machine.mounts is None:
        return []
    if machine.body.mass_matrix is not None or machine.mounts.stiffness_matrix is not None:
        return []  # the rules of the table say so
    return [*_not_held(case), *_logarithms(motion), *_still(motion), *_on_what(case)]


def _not_held(case: Case) -> list[Problem]:
    motions = never_held(case)
    if not motions:
        return []
    return [
        Problem(
            path=("machine", "mounts"),
            message="the mounts leave the body free: a base that moves would not carry it along",
            found="nothing resists " + ", ".join(motions),
            allowed="a stiffness against each of the six motions",
            hint="give stiffness in three directions, and spread the mounts",
            also=("base_motion",),
        )
    ]


def _on_what(case: Case) -> list[Problem]:
    if case.foundation is None or case.foundation.body is not None:
        return []
    return [
        Problem(
            path=("base_motion",),
            message="a base that moves carries the mounts, or a foundation that is a body",
            found="a foundation of one mass, or of flexibilities",
            allowed="[foundation] with a body, or none",
            also=("foundation",),
        )
    ]


def _logarithms(motion: BaseMotion) -> list[Problem]:
    if motion.interpolation == "linear":
        return []
    found = []
    for place, one in enumerate(motion.spectra):
        _, density = densities_of(one)
        if np.any(density == 0.0):
            name = next(
                key
                for key in ("acceleration", "velocity", "angular_acceleration")
                if getattr(one, key) is not None
            )
            row = int(np.argmin(density))
            found.append(
                Problem(
                    path=("base_motion", "spectra", place, name, "density", row),
                    message="a density of zero has no logarithm",
                    found=f"0 in row {row + 1}",
                    allowed="> 0, or interpolation = 'linear'",
                    also=("base_motion", "interpolation"),
                )
            )
    return found


def _still(motion: BaseMotion) -> list[Problem]:
    found = []
    for place, one in enumerate(motion.harmonics):
        given = (one.displacement, one.velocity, one.acceleration)
        turns = (one.angle, one.angular_velocity, one.angular_acceleration)
        if not any(np.any(part) for part in (*given, *turns) if part is not None):
            found.append(
                Problem(
                    path=("base_motion", "harmonics", place),
                    message=f"harmonic {one.name!r} does not move the base",
                    found="zero along and about all axes",
                    allowed="an amplitude other than zero",
                )
            )
    return found
