"""The machine and what it stands on, and the motion of the base at its reference point."""

from collections.abc import Iterator

import numpy as np

from vibecalc.base_motion.spectrum import Density
from vibecalc.base_motion.tables import BaseHarmonic, BaseSpectrum
from vibecalc.errors import Problem
from vibecalc.foundation.model import on_body
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.numerics.bounded import Bounded, bounded
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import Mounts
from vibecalc.schema import Case


def on_base(case: Case, body: RigidBody, mounts: Mounts) -> OnMounts:
    """A body with six degrees of freedom on its mounts, on the base or on a body on it."""
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


def harmonics_of(case: Case) -> tuple[np.ndarray, Bounded]:
    """Frequencies (m,) in rad/s of the harmonics, and the motion (m, 6) of the reference point.

    In complex amplitude, m and rad, 0 to peak.
    """
    given, speed = case.base_motion, case.machine.speed
    assert given is not None
    every = [(one, one.frequency or (one.order or 0.0) * speed) for one in given.harmonics]
    said = bounded(np.array([_amplitude_of(*each) for each in every]))
    return np.array([one for _, one in every]), said @ at_reference(given.point).T


def _amplitude_of(one: BaseHarmonic, frequency: float) -> np.ndarray:
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


def _key(one: BaseSpectrum) -> str:
    keys = ("acceleration", "velocity", "angular_acceleration")
    return next(key for key in keys if getattr(one, key) is not None)


def density_of(one: BaseSpectrum, interpolation: str) -> Density:
    """The density of the base in one direction.

    Straight lines of a velocity density in logarithmic scales are straight for the acceleration.
    """
    rows, straight_in_logarithms = getattr(one, _key(one)), interpolation == "logarithmic"
    columns = np.asarray(rows.frequency), np.asarray(rows.density)
    return Density(*columns, straight_in_logarithms, one.velocity is not None)


def base_motion_problems(case: Case) -> Iterator[Problem]:
    """Problems of a base motion on a machine without other problems."""
    motion = case.base_motion
    assert motion is not None
    if motions := never_held(case):
        yield Problem(
            path=("machine", "mounts"),
            message="the mounts do not restrain the body: base motion would not move it",
            found="nothing resists " + ", ".join(motions),
            allowed="a stiffness against each of the six motions",
            hint="give stiffness in three directions, and spread the mounts",
            also=("base_motion",),
        )
    for place, spectrum in enumerate(motion.spectra):
        curve = density_of(spectrum, motion.interpolation)
        if curve.logarithmic and np.any(curve.density == 0.0):
            row = int(np.argmin(curve.density))
            yield Problem(
                path=("base_motion", "spectra", place, _key(spectrum), "density", row),
                message="a density of zero has no logarithm",
                found=f"0 in row {row + 1}",
                allowed="> 0, or interpolation = 'linear'",
                also=("base_motion", "interpolation"),
            )
    for place, harmonic in enumerate(motion.harmonics):
        if not np.any(_amplitude_of(harmonic, 1.0)):
            yield Problem(
                path=("base_motion", "harmonics", place),
                message=f"harmonic {harmonic.name!r} does not move the base",
                found="zero along and about all axes",
                allowed="an amplitude other than zero",
            )
    if case.foundation is not None and case.foundation.body is None:
        yield Problem(
            path=("base_motion",),
            message="base motion needs mounts directly on the base or a rigid-body foundation",
            found="a foundation of one mass, or of flexibilities",
            allowed="[foundation] with a body, or none",
            also=("foundation",),
        )
