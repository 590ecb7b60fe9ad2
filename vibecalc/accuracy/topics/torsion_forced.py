"""Torques in all sections of a shaft line at its speed: elimination, matrices, modes, poles."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.shaft_cycles import on_freedoms
from vibecalc.accuracy.yardsticks.shaft_lines import (
    dense_angles,
    exact_angles,
    modal_angles,
    pole_angles,
    transfer_angles,
)
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.curves import stiffness_of
from vibecalc.pipeline.stages.torsion.setup import Setup, build_setup
from vibecalc.response.torsion.forced import forced_masked
from vibecalc.response.torsion.line import Line

#: lines longer than this are taken with their first orders only
ORDERS_OF_LONG, LONG = 12, 16


def topics(scene: Scene) -> list[Topic]:
    """None where damping is given by mode: the equations of motion then have no matrix for it."""
    setup = build_setup(scene.case)
    if by_modes_refused(setup):
        return []
    line = setup.model.at(setup.speed)
    n = len(line.inertia)
    w, torque = orders_and_torque(setup, ORDERS_OF_LONG if n > LONG else None)
    m = len(w)
    if not line.inertia.all():
        ladders = _by_matrices(setup, line, w, torque)
    else:
        ladders = (*_by_matrices(setup, line, w, torque), *_by_modes(setup, line, w, torque))
    if setup.model.modal is not None:
        extra, why = 5.0, "the case asks for a sum over modes"
    elif setup.model.method == "dense":
        extra, why = 6.0 + n**2 / 6.0, "the case asks for full matrices with pivoting"
    else:
        extra, why = 3.0, "no loss of digits in long, stiff lines; an error bound at each order"
    where = f"torques of all sections at {m} orders and {setup.speed:.6g} rad/s"
    return [
        Topic(
            "torsion", "torques by order", where, "response/torsion/torque", "N*m",
            "complex multiplications",
            lambda: Reference(
                section_torques(line, w, exact_angles(line, w, torque)), UNIT_ROUNDOFF,
                "the equations of motion in 40 digits",
            ),
            ladders,
            default_extra=extra,
            default_why=why,
        )
    ]  # fmt: skip


def by_modes_refused(setup: Setup) -> bool:
    """Whether damping is given by mode, for which no matrix is at hand."""
    damping = setup.torsion.damping_model
    return damping is not None and damping.kind == "modal"


def orders_and_torque(setup: Setup, count: int | None = None) -> tuple[FloatArray, ComplexArray]:
    """Frequencies (m,) in rad/s and torques (m, n) on all freedoms at the operating speed."""
    drive = setup.drive
    own = drive.torque(np.array([setup.speed]))[0][:count]
    return setup.speed * drive.order[:count], on_freedoms(setup, own)


def section_torques(line: Line, w: FloatArray, angle: ComplexArray) -> ComplexArray:
    """Torques (m, e) of the elements from angles (m, n)."""
    return np.asarray(stiffness_of(line, w) * (angle[:, line.first] - angle[:, line.second]))


def _by_matrices(
    setup: Setup, line: Line, w: FloatArray, torque: ComplexArray
) -> tuple[Ladder, ...]:
    n, m = len(line.inertia), len(w)
    method = setup.model.method if setup.model.modal is None else "modal"

    def of(angle: ComplexArray, work: float) -> Answer:
        return Answer(section_torques(line, w, angle), work * m)

    def kernel(dense: bool, estimate: bool, work: float) -> Answer:
        found = forced_masked(line, w, torque, dense=dense, estimate=estimate)
        return of(found.angle, work)

    return (
        Ladder(
            "elimination", "along the line, with its error bound", "", NOTHING_TO_SET,
            lambda _: kernel(False, True, 10.0 * n),
            default=1.0 if method == "elimination" else None,
        ),
        Ladder(
            "elimination alone", "the same without the bound", "", NOTHING_TO_SET,
            lambda _: kernel(False, False, 6.0 * n),
        ),
        Ladder(
            "inverse", "full matrix with pivoting, one step of refinement, error bound", "",
            NOTHING_TO_SET, lambda _: kernel(True, True, n**3 + 5.0 * n**2),
            default=1.0 if method == "dense" else None,
        ),
        Ladder(
            "full matrix", "numpy.linalg.solve at each order", "", NOTHING_TO_SET,
            lambda _: of(dense_angles(line, w, torque), n**3 / 3.0 + n**2),
        ),
        Ladder(
            "transfer matrices", "2 x 2, from one end of a row to the other", "", NOTHING_TO_SET,
            lambda _: of(transfer_angles(line, w, torque), 4.0 * n),
            citation="Pestel and Leckie 1963",
        ),
    )  # fmt: skip


def _by_modes(setup: Setup, line: Line, w: FloatArray, torque: ComplexArray) -> tuple[Ladder, ...]:
    n, m, modes = len(line.inertia), len(w), setup.modes
    count = len(modes.frequency)
    kept = np.unique(np.linspace(min(2, count), count, min(count, 7)).astype(int))

    def summed(number: float) -> Answer:
        angle = modal_angles(line, modes, int(number), w, torque)
        # the modes themselves in real multiplications, four to a complex one
        return Answer(section_torques(line, w, angle), 2.5 * n**3 + m * number * (2.0 * n + 1.0))

    def poles(_: float) -> Answer:
        angle = pole_angles(line, w, torque)
        return Answer(section_torques(line, w, angle), 12.5 * (2 * n) ** 3 / 4.0 + m * 4.0 * n**2)

    return (
        Ladder(
            "sum over modes", "undamped modes; what damping couples them by is left out",
            "modes", tuple(float(one) for one in kept), summed,
            default=None if setup.model.modal is None else float(count),
        ),
        Ladder("state matrix", "eigenvalues and vectors with dashpots", "", NOTHING_TO_SET, poles),
    )  # fmt: skip
