"""Accuracy of a machine on a foundation that moves: closed form, matrices, modes."""

from typing import Any

import numpy as np

from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.foundation.adapter import two_masses
from vibecalc.foundation.two_masses import TwoMasses, motion
from vibecalc.numerics.rounding import ComplexArray, FloatArray


def foundation_topics(scene: Scene) -> list[Topic]:
    """The force on the ground by order; none where no order of the forces acts up or down."""
    forcing: Forcing = scene.handed_on["forcing"]
    system, up = two_masses(scene)
    speed, kept = scene.case.machine.speed, forcing.retained
    force = forcing.per_speed_squared.force[:kept, up] * speed**2
    frequency = forcing.orders[:kept] * speed
    if not np.any(np.abs(force) > 0.0):
        return []

    def closed(_: float) -> Answer:
        found = motion(system, force, np.zeros(kept), frequency)
        return Answer(found.ground_force.value, float(kept))

    def by_matrices(_: float) -> Answer:
        return Answer(_ground_force_of_matrices(system, force, frequency), 4.0 * kept)

    return [
        Topic(
            stage="foundation",
            name="force on the ground",
            words="force of each order on what carries the foundation",
            quantity="foundation/ground_force",
            unit="N",
            work="solves",
            reference=lambda: _reference(system, force, frequency),
            solvers=(
                Solver(
                    "closed form", "determinant of two masses", "", NOTHING_TO_SET, closed, 1.0,
                    citation="Den Hartog, Mechanical Vibrations, section 3.2",
                ),
                Solver("matrices", "2 x 2 by LU", "", NOTHING_TO_SET, by_matrices),
            ),
        )
    ]  # fmt: skip


def _ground_force_of_matrices(
    system: TwoMasses, force: ComplexArray, frequency: FloatArray
) -> np.ndarray:
    one, w = system, frequency
    mounts = one.mount_stiffness + 1j * (one.mount_structural + w * one.mount_damping)
    below = one.stiffness + 1j * (one.structural + w * one.damping)
    dynamic = np.empty((len(w), 2, 2), dtype=complex)
    dynamic[:, 0, 0] = mounts - w**2 * one.machine_mass
    dynamic[:, 0, 1] = dynamic[:, 1, 0] = -mounts
    dynamic[:, 1, 1] = mounts + below - w**2 * one.foundation_mass
    load = np.stack([force, np.zeros_like(force)], axis=-1)[..., None]
    return np.asarray(below * np.linalg.solve(dynamic, load)[:, 1, 0])


def _reference(system: TwoMasses, force: ComplexArray, frequency: FloatArray) -> Reference:
    """In 40 digits; the stated agreement is that of rounding the result."""
    import mpmath

    with mpmath.workdps(40):
        m1, k1, c1, h1, m2, k2, c2, h2 = (mpmath.mpf(float(value)) for value in system)
        values: list[Any] = []
        for f, w in zip(force, frequency, strict=True):
            turn = mpmath.mpf(float(w))
            mounts = mpmath.mpc(k1, h1 + turn * c1)
            below = mpmath.mpc(k2, h2 + turn * c2)
            whole = (mounts - turn**2 * m1) * (below - turn**2 * m2) - turn**2 * m1 * mounts
            values.append(complex(mpmath.mpc(complex(f)) * mounts * below / whole))
    return Reference(np.array(values), 1e-15, "40 digits, rounded")
