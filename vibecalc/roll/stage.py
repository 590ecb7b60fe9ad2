"""The stages of a machine whose motor finds its speed: roll, start-up, control."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.core.run.stage import (
    Entries,
    Harmonics,
    Leading,
    Stage,
    Subject,
    Unit,
    Work,
    below,
    first_orders,
)
from vibecalc.kinds import asks_roll, finds_speed, has_crank_train
from vibecalc.parts.array_keys import MOVING_KEYS
from vibecalc.roll.results import FORCES, ROLL, VARIABLES

if TYPE_CHECKING:
    from vibecalc.schema import Case

_PARTS = ("crank_train", "rotor", "shell", "motor")
#: results that only an option asks for
_OPTIONAL = {
    "interpolations": "response/roll/interpolation/",
    "compare": "response/roll/method/",
    "sensitivity": "response/roll/sensitivity/",
    "classical": "response/roll/classical/",
}
_METHODS = {
    "collocation": "Gauss collocation over the crank angle, panels split at every kink",
    "fourier": "Fourier collocation over the crank angle",
    "shooting": "one turn at a time and Newton on its start",
    "dop853": "scipy's DOP853 in time until the turns repeat",
    "rk4": "fixed steps in time until the turns repeat",
    "euler": "fixed steps in time until the turns repeat",
}


def plan_roll(case: "Case") -> Iterator[Stage]:
    """Steady motion, then start-up, then control; each only where the case asks for it."""
    options = case.response
    if options is None:
        return
    if options.roll is not None:
        yield _roll(case)
    if options.start_up is not None:
        yield _start_up(case)
    if options.control is not None:
        yield _control(case)


def _roll(case: "Case") -> Stage:
    options, dynamic = _options(case, "roll"), _dynamic(case)
    left_out = [path for key, path in _OPTIONAL.items() if not getattr(options, key)]
    left_out += [] if options.classical else ["response/roll/shaking/"]
    left_out += [] if dynamic else ["response/roll/motor/"]
    runs = 1 + 4 * options.interpolations + len(options.compare) + 2 * options.sensitivity
    runs += 2 * dynamic
    return Stage(
        name="roll",
        adapter="vibecalc.roll.adapters.running:run_roll",
        why=f'[response.roll] is in the case, method = "{options.method}"',
        parts=_PARTS,
        orders=f"1 to {options.orders}, as the case asks",
        cost=_METHODS[options.method] + (f", {runs} such problems" if runs > 1 else ""),
        quantities=below("response/roll/", without=tuple(left_out)),
        is_last=True,
        harmonics=_orders_of_roll,
        work=_work_of_roll,
        topics=("vibecalc.roll.accuracy:roll_topics",),
        leading=Leading(
            keys=ROLL_KEYS,
            only=TOGETHER,
            why_not=_one_by_one(case),
            most=128,
            adapter="vibecalc.roll.arrays:run_roll_at_points",
        ),
    )


#: numbers of rotor, pistons and shell over which running states are found together
ROLL_KEYS = MOVING_KEYS | frozenset(
    [
        "machine.rotor.inertia",
        *(f"machine.shell.{name}" for name in ("inertia", "stiffness", "damping")),
        *(f"machine.friction.{name}" for name in ("torque", "viscous", "piston_force")),
        "response.roll.started_at",
    ]
)
#: and the results of it
TOGETHER = (
    *(f"{ROLL}/{name}" for name in ("speed", "mean_slip", "shell_drift", "largest_multiplier")),
    *(
        path
        for name in (*VARIABLES, *FORCES)
        for path in (f"{ROLL}/{name}", f"{ROLL}/level/{name}", f"{ROLL}/phase_lag/{name}")
    ),
)


def _one_by_one(case: "Case") -> str:
    """Why running states of this case are not found together."""
    if _options(case, "roll").method != "collocation":
        return "this method is run point by point"
    return "a dynamic motor is run point by point" if _dynamic(case) else ""


def _start_up(case: "Case") -> Stage:
    options = _options(case, "start_up")
    left_out: tuple[str, ...] = () if options.load is not None else ("/load/",)
    cost = f"{options.duration:.6g} s followed twice, with a step or more between table nodes"
    if options.angles is None:
        left_out = (*left_out, "/start_angles/")
    else:
        cost += f"; starts from {options.angles} angles, and more towards each border"
    return Stage(
        name="start-up",
        adapter="vibecalc.roll.adapters.start_up:run_start_up",
        why="[response.start_up] is in the case",
        parts=_PARTS,
        orders="none: it runs in time",
        cost=cost,
        quantities=below("response/start_up/", without=left_out),
        is_last=True,
        work=_work_of_start_up,
        topics=("vibecalc.roll.accuracy:start_up_topics",),
    )


def _control(case: "Case") -> Stage:
    options = _options(case, "control")
    parts = {
        "motor_gains": options.motor_gains,
        "grid": options.gains or options.feedbacks,
        "tuned": options.tune is not None,
        "full": options.full_model,
    }
    loops = (len(options.gains) or 1) * (len(options.feedbacks) or 1) if parts["grid"] else 1
    cost = f"closed forms for {loops} pairs of gain and feedback; two periodic problems"
    cost += ", one more under control" if options.full_model else ""
    cost += ", a search of some 40,000 loops" if options.tune is not None else ""
    return Stage(
        name="control",
        adapter="vibecalc.roll.adapters.control:run_control",
        why="[response.control] is in the case",
        parts=_PARTS,
        orders=f"1 to {options.orders}, as the case asks",
        cost=cost,
        quantities=below(
            "response/control/",
            without=tuple(f"/control/{name}/" for name, there in parts.items() if not there),
        ),
        is_last=True,
        harmonics=_orders_of_control,
        work=_work_of_control,
        topics=("vibecalc.roll.accuracy:control_topics",),
    )


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------

_TURN = 2.0 * math.pi


def _orders_of_roll(case: "Case") -> Harmonics:
    return first_orders(
        _options(case, "roll").orders, "[response.roll] orders, of the steady motion"
    )


def _orders_of_control(case: "Case") -> Harmonics:
    return first_orders(_options(case, "control").orders, "[response.control] orders")


def _work_of_roll(case: "Case", orders: int) -> Work:
    options, dynamic = _options(case, "roll"), _dynamic(case)
    problems = 2 + 1 + 4 * options.interpolations + 2 * options.sensitivity + 2 * dynamic
    marches = len(options.compare) + (options.method not in ("collocation", "fourier"))
    return (problems, "periodic_motor" if dynamic else "periodic"), (marches, "march")


def _work_of_start_up(case: "Case", orders: int) -> Work:
    options, motor = _options(case, "start_up"), case.machine.motor
    speed = (motor.synchronous_speed if motor is not None else None) or 100.0
    turns = math.ceil(options.duration * speed / _TURN)
    return (turns, "turn_of_start"), (options.angles or 0, "start_angle")


def _work_of_control(case: "Case", orders: int) -> Work:
    options = _options(case, "control")
    loops = (len(options.gains) or 1) * (len(options.feedbacks) or 1) + len(options.motor_gains)
    return (
        (2 + options.full_model, "periodic"),
        (loops, "loop"),
        (options.tune is not None, "tuning_loops"),
    )


def _options(case: "Case", name: str) -> Any:
    """The table of a stage, which a case that has the stage has."""
    return getattr(case.response, name)


def _dynamic(case: "Case") -> bool:
    motor = case.machine.motor
    return motor is not None and motor.kind == "dynamic"


def names_of(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    if case.response is None or case.response.roll is None or not has_crank_train(case.machine):
        return {}
    from vibecalc.roll.model import gas_tables, interpolations

    options = case.response.roll
    return {
        "method": tuple(dict.fromkeys((options.method, *options.compare))),
        "interpolant": interpolations(gas_tables(case)),
    }


def concerns(case: "Case") -> bool:
    """Whether a case asks for the roll of its machine, or has parts that serve nothing else."""
    machine = case.machine
    parts = (machine.rotor, machine.shell, machine.friction)
    return (
        asks_roll(case)
        or finds_speed(machine)
        or any(part is not None for part in parts)
        or (
            has_crank_train(machine)
            and any(cylinder.gas_force for cylinder in machine.crank_train.cylinders)
        )
    )


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    options = case.response
    for name in ("roll", "control"):
        table = getattr(options, name, None)
        if axis == "order" and table and path.startswith(f"response/{name}/"):
            return Entries.up_to(table.orders, f"orders of [response.{name}] is the highest")
    return None


SUBJECT = Subject(
    stages=(plan_roll,),
    entries=_entries,
    names=names_of,
    concerns=concerns,
    units={
        "periodic": Unit(5.0e-2, "periodic problems"),
        "periodic_motor": Unit(
            2.5e-1, "periodic problems with a motor's currents", "scipy.interpolate", holds=80.0
        ),
        "march": Unit(1.0e-1, "marches until the turns repeat"),
        "turn_of_start": Unit(2.0e-2, "turns followed"),
        "start_angle": Unit(5.0e-2, "starts from other angles"),
        "loop": Unit(1.0e-3, "loops closed"),
        "tuning_loops": Unit(2.0e-1, "searches over loops", "scipy.optimize"),
    },
    checks=(
        "vibecalc.roll.motor_checks:slip_problems",
        "vibecalc.roll.checks:roll_problems",
        "vibecalc.roll.motor_checks:control_problems",
        "vibecalc.roll.motor_checks:dynamic_problems",
    ),
    suspects={"vibecalc.roll.checks:roll_problems": "vibecalc.roll.checks:roll_suspects"},
    cautions=("vibecalc.roll.checks:roll_cautions",),
    sections=(
        "vibecalc.roll.report.running:roll",
        "vibecalc.roll.report.start_up:start_up",
        "vibecalc.roll.report.motor:roll_motor",
        "vibecalc.roll.report.control:roll_control",
    ),
    pictures={
        "roll_levels": "vibecalc.roll.pictures.running:ROLL_LEVELS",
        "roll_cycle": "vibecalc.roll.pictures.running:draw_roll_cycle",
        "roll_sensitivity": "vibecalc.roll.pictures.running:draw_roll_sensitivity",
        "roll_control": "vibecalc.roll.pictures.control:draw_roll_control",
        "roll_motor_gain": "vibecalc.roll.pictures.control:ROLL_MOTOR_GAIN",
        "roll_locus": "vibecalc.roll.pictures.control:draw_roll_locus",
        "roll_start_up": "vibecalc.roll.pictures.start_up:ROLL_START_UP",
        "motor_curve": "vibecalc.roll.pictures.motor:draw_dynamic_motor",
    },
    assumes=(
        "The shell is one rigid body that turns about the fixed crank axis; its weight "
        "and translation are left out. The motion is exact and non-linear in the crank "
        "angle.",
    ),
)
