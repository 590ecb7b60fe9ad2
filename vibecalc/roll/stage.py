"""The stages of a machine whose motor finds its speed: roll, start-up, control."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import StagePlan, below

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
_WAYS = {
    "collocation": "Gauss collocation over the crank angle, panels split at every kink",
    "fourier": "Fourier collocation over the crank angle",
    "shooting": "one turn at a time and Newton on its start",
    "dop853": "scipy's DOP853 in time until the turns repeat",
    "rk4": "fixed steps in time until the turns repeat",
    "euler": "fixed steps in time until the turns repeat",
}


def plan_roll(case: "Case") -> Iterator[StagePlan]:
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


def _roll(case: "Case") -> StagePlan:
    assert case.response is not None and case.response.roll is not None
    options = case.response.roll
    left_out = [path for key, path in _OPTIONAL.items() if not getattr(options, key)]
    left_out += [] if options.classical else ["response/roll/shaking/"]
    motor = case.machine.motor
    dynamic = motor is not None and motor.kind == "dynamic"
    left_out += [] if dynamic else ["response/roll/motor/"]
    runs = 1 + 4 * options.interpolations + len(options.compare) + 2 * options.sensitivity
    runs += 2 * dynamic
    return StagePlan(
        stage="roll",
        adapter="vibecalc.roll.adapters.running:run_roll",
        why=f'[response.roll] is in the case, method = "{options.method}"',
        parts=_PARTS,
        orders=f"1 to {options.orders}, as the case asks",
        cost=_WAYS[options.method] + (f", {runs} such problems" if runs > 1 else ""),
        quantities=below("response/roll/", without=tuple(left_out)),
        is_last=True,
    )


def _start_up(case: "Case") -> StagePlan:
    assert case.response is not None and case.response.start_up is not None
    options = case.response.start_up
    left_out: tuple[str, ...] = () if options.load is not None else ("/load/",)
    cost = f"{options.duration:.6g} s followed twice, with a step or more between table nodes"
    if options.angles is None:
        left_out = (*left_out, "/start_angles/")
    else:
        cost += f"; starts from {options.angles} angles, and more towards each border"
    return StagePlan(
        stage="start-up",
        adapter="vibecalc.roll.adapters.start_up:run_start_up",
        why="[response.start_up] is in the case",
        parts=_PARTS,
        orders="none: it runs in time",
        cost=cost,
        quantities=below("response/start_up/", without=left_out),
        is_last=True,
    )


def _control(case: "Case") -> StagePlan:
    assert case.response is not None and case.response.control is not None
    options = case.response.control
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
    return StagePlan(
        stage="control",
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
    )
