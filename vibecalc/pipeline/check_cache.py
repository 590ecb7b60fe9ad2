"""The checks of physics for studies that change a case thousands of times, a little each time.

A check that found nothing finds nothing again where all that it reads is the same. As soon as one
finds something, all of them run, so that the problems are those of `machine.checks`, every time.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.errors import Problem
from vibecalc.machine.absorber_checks import absorber_problems
from vibecalc.machine.absorber_part_checks import absorber_part_problems
from vibecalc.machine.absorber_pendulum_checks import pendulum_problems
from vibecalc.machine.body_checks import body_problems
from vibecalc.machine.checks import check_machine
from vibecalc.machine.control_checks import control_problems
from vibecalc.machine.crank_train_checks import crank_train_problems
from vibecalc.machine.drive_checks import drive_problems
from vibecalc.machine.dynamic_checks import dynamic_problems
from vibecalc.machine.engine_checks import engine_problems
from vibecalc.machine.gas_checks import gas_problems
from vibecalc.machine.isolation_checks import isolation_problems
from vibecalc.machine.joint_checks import joint_problems
from vibecalc.machine.measurement_checks import measurement_problems
from vibecalc.machine.operation_checks import operation_problems
from vibecalc.machine.range_checks import ANGLES, LARGEST, LARGEST_ANGLE, SMALLEST
from vibecalc.machine.roll_checks import roll_problems
from vibecalc.machine.shaft_line_checks import shaft_line_problems
from vibecalc.machine.slip_checks import slip_problems
from vibecalc.machine.torsion_checks import torsion_problems
from vibecalc.machine.transient_checks import transient_problems
from vibecalc.pipeline.stage_cache import StageCache

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def matrices(case: "Case") -> list[Problem]:
    """Problems of matrices, if there are any matrices."""
    body, mounts = case.machine.body, case.machine.mounts
    matrix = None if body is None else body.mass_matrix
    stiffness = None if mounts is None else mounts.stiffness_matrix
    if matrix is None and stiffness is None:
        return []
    from vibecalc.machine.matrix_checks import matrix_problems  # loads what solves the motion

    return matrix_problems(case)


#: what ratios of an absorber come from, and its other parts
_ABSORBER = (
    *(f"machine.{part}" for part in ("primary", "secondary", "secondaries", "rod")),
    "tuning",
)
_HARDWARE = tuple(
    f"machine.{part}"
    for part in (
        *("flywheel", "springs", "ring", "gap", "oil"),
        *("stock_springs", "stock_oils", "spring_catalogue", "oil_catalogue"),
    )
)
#: check -> places of the case that it reads
CHECKS: dict[Callable[["Case"], list[Problem]], tuple[str, ...]] = {
    crank_train_problems: ("machine.crank_train", "machine.body", "kinematics"),
    body_problems: ("machine.body",),
    matrices: (
        "machine.body.mass_matrix",
        "machine.mounts.stiffness_matrix",
        "machine.mounts.damping_matrix",
    ),
    operation_problems: (
        "machine.crank_train.cylinders",
        "machine.joints",
        "machine.mounts",
        "excitation",
        "response",
    ),
    drive_problems: (
        "machine.cycle",
        "machine.crank_train.gas_pressure",
        "machine.motor",
    ),
    joint_problems: (
        "machine.crank_train",
        "machine.joints",
        "machine.speed",
        "excitation",
        "response",
    ),
    slip_problems: ("machine.motor", "response.start_up"),
    gas_problems: ("machine.crank_train", "machine.kind"),
    roll_problems: (
        "machine.crank_train",
        "machine.motor",
        "machine.shell",
        "excitation.working",
        "response.roll",
        "response.start_up",
        "response.control",
    ),
    control_problems: ("machine.motor", "response.control"),
    dynamic_problems: ("machine.motor", "response"),
    measurement_problems: ("measurement", "machine.speed", "machine.kind"),
    absorber_problems: (*_ABSORBER, "response.absorber"),
    absorber_part_problems: (*_ABSORBER, *_HARDWARE),
    pendulum_problems: ("machine.pendulum",),
    engine_problems: ("machine.kind", "machine.cycle", "machine.crank_train"),
    shaft_line_problems: ("machine.shaft_line", "machine.crank_train"),
    transient_problems: (
        "machine.cycle",
        "machine.speed",
        "machine.shaft_line",
        "response.torsion",
    ),
    torsion_problems: (
        "machine.cycle",
        "machine.speed",
        "machine.shaft_line",
        "machine.crank_train.gas_cards",
        "machine.crank_train.cylinders",
        "response.torsion",
        "damper_design",
    ),
    isolation_problems: (
        "machine.crank_train.axis",
        "machine.crank_train.stroke",
        "machine.body",
        "machine.mounts",
        "isolation",
    ),
}
#: places whose numbers have a range, each looked at by itself
_RANGES = (
    *(f"machine.{part}" for part in ("speed", "crank_train", "body", "mounts", "motor", "joints")),
    *(f"machine.{part}" for part in ("rotor", "shell", "friction", "pendulum")),
    "machine.shaft_line",
    *(place for place in _ABSORBER if place != "tuning"),
    *_HARDWARE,
    "excitation",
    "isolation",
    "response",
    "damper_design",
)


def check_again(case: "Case", cache: StageCache) -> list[Problem]:
    """`machine.checks.check_machine` with what `cache` knows of earlier cases."""
    now = cache.at(case, None)
    for place in _RANGES:
        key = now.key("range", (place,))
        if cache.find(key) is None:
            name, content = place.rpartition(".")[2], now.content(place)
            if any(_out_of_range(*number) for number in _numbers(content, name)):
                return check_machine(case)
            cache.keep(key, True)
    for check, places in CHECKS.items():
        key = now.key(check.__name__, places)
        if cache.find(key) is None:
            if check(case):
                return check_machine(case)
            cache.keep(key, True)
    return []


def _numbers(content: Any, name: str) -> Iterator[tuple[str, float]]:
    if isinstance(content, float):
        yield name, content
    elif isinstance(content, dict):
        for key, entry in content.items():
            yield from _numbers(entry, key)
    elif isinstance(content, tuple | list):
        for entry in content:
            yield from _numbers(entry, name)


def _out_of_range(name: str, value: float) -> bool:
    """Whether a number may be refused: one that may vanish counts here, too."""
    size = abs(value)
    return size > (LARGEST_ANGLE if name in ANGLES else LARGEST) or 0.0 < size < SMALLEST
