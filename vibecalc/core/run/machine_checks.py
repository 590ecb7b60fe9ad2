"""Checks of physics on a validated case, all problems and warnings at once."""

from collections.abc import Callable

from vibecalc.absorber.checks import absorber_part_problems, absorber_problems, pendulum_problems
from vibecalc.core.case.number_range import range_problems
from vibecalc.errors import Problem
from vibecalc.excitation.checks import engine_problems, pump_problems
from vibecalc.impact.checks import joint_problems
from vibecalc.isolation.model import isolation_problems
from vibecalc.measurement.checks import measurement_problems
from vibecalc.parts.body import body_problems
from vibecalc.parts.cautions import machine_warnings
from vibecalc.parts.crank_train import crank_train_problems
from vibecalc.parts.drive_checks import drive_problems, gas_problems
from vibecalc.response.checks import operation_problems
from vibecalc.roll.checks import roll_problems
from vibecalc.roll.motor_checks import control_problems, dynamic_problems, slip_problems
from vibecalc.schema import Case
from vibecalc.torsion.checks import torsion_problems
from vibecalc.torsion.shaft_line_checks import shaft_line_problems
from vibecalc.torsion.stage import transient_problems

__all__ = ["CHECKS", "check_machine", "machine_warnings", "matrices"]


def matrices(case: Case) -> list[Problem]:
    """Problems of matrices, if there are any matrices."""
    body, mounts = case.machine.body, case.machine.mounts
    matrix = None if body is None else body.mass_matrix
    stiffness = None if mounts is None else mounts.stiffness_matrix
    if matrix is None and stiffness is None:
        return []
    from vibecalc.parts.matrices import matrix_problems  # loads what solves the motion

    return matrix_problems(case)


#: all but ranges of numbers; isolation, the last, is judged where the others find nothing
CHECKS: tuple[Callable[[Case], list[Problem]], ...] = (
    crank_train_problems,
    body_problems,
    matrices,
    operation_problems,
    drive_problems,
    joint_problems,
    slip_problems,
    gas_problems,
    roll_problems,
    control_problems,
    dynamic_problems,
    measurement_problems,
    absorber_problems,
    absorber_part_problems,
    pendulum_problems,
    pump_problems,
    engine_problems,
    shaft_line_problems,
    transient_problems,
    torsion_problems,
    isolation_problems,
)


def check_machine(case: Case) -> list[Problem]:
    """What makes a machine impossible or its model meaningless, with key paths into the case.

    Numbers that are out of range come alone, since nothing can be computed with them; the model of
    isolation is judged once its body and crank train are possible.
    """
    problems = range_problems(case)
    if problems:
        return problems
    for check in CHECKS:
        if check is not isolation_problems:
            problems += check(case)
    return problems or isolation_problems(case)
