"""The stages that [response] asks for."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import StagePlan, below, orders_words

if TYPE_CHECKING:
    from vibecalc.schema import Case

_APART = (
    *("_energy/", "/operations/", "/run_up/", "/masked/", "/switching/", "/impact/"),
    *("/roll/", "/start_up/", "/control/", "/absorber/", "/pendulum/", "/torsion/"),
)


def plan_response(case: "Case") -> Iterator[StagePlan]:
    """Motion of the body, then what is made from it: operations, run-up, switching, impacts."""
    options = case.response
    if options is None:
        return
    if case.machine.body is not None and case.machine.mounts is not None:
        yield _motion(case)
        if options.operations:
            yield _operations(case)
        if options.run_up is not None:
            yield _run_up(case)
        if options.switching is not None:
            yield _switching(case)
    if options.impact is not None:
        yield _impact(case)


def _motion(case: "Case") -> StagePlan:
    options = case.response
    assert options is not None
    energies = below("response/", without=("/operations/", "/run_up/"))
    energies = tuple(
        path
        for path in energies
        if path.startswith(("response/kinetic_energy/", "response/potential_energy/"))
    )
    return StagePlan(
        stage="response",
        adapter="vibecalc.response.adapters.response:run_response",
        why=f'[response] is in the case, method = "{options.method}"',
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve per order at {case.machine.speed:.6g} rad/s",
        quantities=(*below("response/", without=_APART), *(energies if options.energies else ())),
        is_last=True,
    )


def _operations(case: "Case") -> StagePlan:
    options = case.response
    assert options is not None
    balances = max(len(options.balances), 1)
    return StagePlan(
        stage="operations",
        adapter="vibecalc.response.adapters.operations:run_operations",
        why="[response] operations are in the case",
        parts=("crank_train", "body", "mounts"),
        orders=orders_words(case),
        cost=f"{len(options.operations)} operations x {balances} balances in one batch",
        quantities=below("response/operations/"),
        is_last=True,
    )


def _run_up(case: "Case") -> StagePlan:
    options = case.response
    assert options is not None and options.run_up is not None
    first, last = options.run_up.start, options.run_up.stop
    return StagePlan(
        stage="speeds",
        adapter="vibecalc.response.adapters.response:run_speeds",
        why="[response] run_up is in the case",
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=below("response/run_up/") + below("response/masked/"),
        is_last=True,
    )


def _switching(case: "Case") -> StagePlan:
    options = case.response
    assert options is not None and options.switching is not None
    there, back = options.switching.between
    return StagePlan(
        stage="switching",
        adapter="vibecalc.response.adapters.switching:run_switching",
        why="[response.switching] is in the case",
        parts=("crank_train", "body", "mounts"),
        orders=orders_words(case),
        cost=f"exact modal motion from {there} to {back} and back, at once and by reversal",
        quantities=below("response/switching/"),
        is_last=True,
    )


def _impact(case: "Case") -> StagePlan:
    options, machine = case.response, case.machine
    assert options is not None and options.impact is not None
    study, joints = options.impact, machine.joints
    left_out = tuple(
        f"/impact/{part}"
        for part, given in (
            ("crank_pin/", joints is not None and joints.crank_pin is not None),
            ("bore/", joints is not None and joints.bore is not None),
            ("motor", machine.motor is not None and case.excitation is not None),
        )
        if not given
    )
    from vibecalc.impact.checks import impact_work  # loads what follows the contacts

    work = impact_work(case)
    steps = "" if work is None else f", about {work.steps:.2g} steps per turn"
    turns = study.discard + study.revolutions
    runs = study.members * max(len(study.clearances), 1)
    return StagePlan(
        stage="impact",
        adapter="vibecalc.impact.adapter:run_impact",
        why="[response.impact] is in the case",
        parts=("crank_train", "joints"),
        orders=f"1 to {study.orders} of the joint force",
        cost=f"{runs} runs of {turns} turns in one batch{steps}",
        quantities=below("response/impact/", without=left_out),
        is_last=True,
    )
