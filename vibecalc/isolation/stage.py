"""The stages of a body on its mounts: steady, in run-up, under the torque of the cylinders."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Entries, Leading, Stage, Subject, Unit, Work, below
from vibecalc.isolation.results import (
    AT_REST,
    BY_ORDER,
    MOVING,
    NEAREST,
    OF_RUN_UP,
    OF_STOPS,
    OF_TORQUE,
    STEADY,
    STEADY_AT_SUPPORTS,
    LeverForce,
    SupportForce,
)
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.firing import with_torque
from vibecalc.parts.mount_needs import (
    foundation_kind,
    frequency_counts,
    has_stops,
    loads_count,
    moves_with_machine,
    run_up_on_foundation,
    why_alone,
)
from vibecalc.response.stage import entries_of_loads, loads_on

if TYPE_CHECKING:
    from vibecalc.schema import Case


def _of_mounts(case: "Case") -> tuple[str, ...]:
    """Results of mounts whose load or frequency counts, at rest and in motion."""
    mounts = case.machine.mounts
    if mounts is None:
        return ()
    return (
        *(AT_REST if loads_count(mounts) else ()),
        *(OF_STOPS if has_stops(mounts) else ()),
        *(BY_ORDER if frequency_counts(mounts) else ()),
    )


def of_operating_speed(case: "Case") -> tuple[str, ...]:
    """Results of a rigid body and its supports at speed, on whatever the mounts stand on."""
    mounts = case.machine.mounts
    stops = mounts is not None and has_stops(mounts)
    return (*STEADY, *(MOVING * stops), *(OF_TORQUE * ("isolation" in with_torque(case))))


_PITCH_ONLY = (
    "isolation/pitch/",
    "isolation/couple_over_lever/",
    "support_force/blocked_peak",
)
CURVE = "isolation/pitch/transmissibility_curve"
#: of the run-up, without its curves
PEAKS = [paths_of(one, "run_up_peak", "run_up_peak_speed") for one in (SupportForce, LeverForce)]
_BODY_ONLY = ("isolation/modes/", "isolation/body/")
#: of the stages next to it
_OTHERS = ("run_up", "skipped", "efficiency", "isolation/mounts/")


def plan_isolation(case: "Case") -> Iterator[Stage]:
    options = case.isolation
    if options is None:
        return
    pitch, torque = options.model == "pitch", "isolation" in with_torque(case)
    speed = f"{case.machine.speed:.6g} rad/s"
    without = (*_OTHERS, *(_BODY_ONLY if pitch else _PITCH_ONLY), *STEADY, *OF_TORQUE, *NEAREST)
    quantities = below("isolation/", without=without) + _of_mounts(case)
    if pitch:
        quantities += STEADY_AT_SUPPORTS
    elif not moves_with_machine(case):
        quantities += of_operating_speed(case)
    if not pitch and foundation_kind(case) in ("", "mass"):
        quantities += NEAREST * torque
    yield Stage(
        name="isolation",
        adapter="vibecalc.isolation.adapters.body:run_isolation",
        why=f'[isolation] is in the case, model = "{options.model}"'
        + loads_on(case, "isolation").why,
        cost="one solve per order at " + speed,
        quantities=quantities,
        work=_work_of_isolation,
        topics=("vibecalc.isolation.accuracy:isolation_topics",),
        leading=Leading(
            keys=MOUNT_KEYS | {"isolation.gravity", "isolation.lever"},
            takes_all=not torque,
            only=tuple(path for path in quantities if path not in (CURVE, *OF_TORQUE, *NEAREST)),
            why_not="motions in a plane are examined point by point"
            if options.model == "planar"
            else why_alone(case),
            most=2048 if pitch else 1024,
        ),
        **_of_loads(case),
    )
    if not run_up_on_foundation(case):
        yield from run_up_stage(case)
    if not moves_with_machine(case):
        yield from efficiency_stage(case)


def run_up_stage(case: "Case") -> Iterator[Stage]:
    """The run-up on what the mounts stand on; tables of a foundation count at the speed only."""
    options = case.isolation
    if options is None or options.run_up is None:
        return
    pitch, mounts = options.model == "pitch", case.machine.mounts
    stops = mounts is not None and has_stops(mounts)
    first, last = options.run_up.start, options.run_up.stop
    torque = "isolation" in with_torque(case)
    yield Stage(
        name="run_up",
        adapter="vibecalc.isolation.adapters.run_up:run_run_up",
        why="[isolation] run_up is in the case" + loads_on(case, "isolation").why,
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=tuple(
            path
            for path in below("isolation/", without=() if pitch else ("couple_over_lever",))
            if ("run_up" in path or "skipped" in path)
            and (stops or path not in OF_RUN_UP)
            and (options.run_up_maxima is not None or "/maxima/" not in path)
        ),
        is_last=True,
        work=lambda case, orders: ((orders * _RUN_UP, f"{'pitch' if pitch else 'body'}_solve"),),
        topics=("vibecalc.isolation.accuracy:run_up_topics",),
        leading=None
        if torque or run_up_on_foundation(case)
        else Leading(
            keys=MOUNT_KEYS,
            only=(*PEAKS[0], *PEAKS[1] * pitch),
            most=1024,
            adapter="vibecalc.isolation.adapters.run_up:run_up_of_points",
        ),
        **_of_loads(case),
    )


def efficiency_stage(case: "Case") -> Iterator[Stage]:
    """What reaches the ground, through the foundation where that moves with the machine."""
    if case.isolation is None or not case.isolation.efficiency:
        return
    yield Stage(
        name="isolation efficiency",
        adapter="vibecalc.isolation.adapters.efficiency:run_efficiency",
        why="[isolation] efficiency is in the case" + loads_on(case, "isolation").why,
        cost="one solve per order and at some hundred frequencies",
        quantities=below("isolation/efficiency/"),
        is_last=True,
        work=lambda case, orders: ((2 * orders + 6 * _CURVE, "body_solve"), (1, "modes")),
        **_of_loads(case),
    )


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------

#: speeds that a run-up takes, refined where its curves bend
_RUN_UP = 300
#: frequencies of a transmissibility
_CURVE = 380


def _of_loads(case: "Case") -> dict[str, Any]:
    """What stages under all loads have in common."""
    loads = loads_on(case, "isolation")
    return {"parts": loads.parts, "orders": loads.words, "harmonics": loads.harmonics}


def _work_of_isolation(case: "Case", orders: int) -> Work:
    if case.isolation and case.isolation.model == "pitch":
        return ((orders, "pitch_solve"), (1, "modes"))
    if "isolation" in with_torque(case):  # as many orders again, and each cause alone
        return ((6 * orders, "body_solve"), (1, "modes"), (2 * orders, "order"))
    return ((orders, "body_solve"), (1, "modes"))


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    options = case.isolation
    if axis == "mode" and path.startswith(("isolation/modes/", "isolation/torque_reaction/")):
        planar = options is not None and options.model == "planar"
        most, body = (3, "a body in the plane") if planar else (6, "a rigid body")
        return Entries.up_to(most, f"{body} has {most} degrees of freedom")
    return entries_of_loads(case, axis, "isolation")


SUBJECT = Subject(
    stages=(plan_isolation,),
    concerns=lambda case: case.isolation is not None,
    units={
        "body_solve": Unit(2.5e-5, "solves of 6 x 6"),
        "pitch_solve": Unit(1.0e-5, "solves of the pitch model"),
        "modes": Unit(3.0e-3, "sets of modes"),
    },
    entries=_entries,
    last_checks=("vibecalc.isolation.model:isolation_problems",),
    suspects={
        "vibecalc.isolation.model:isolation_problems": "vibecalc.isolation.model:isolation_suspects"
    },
    sections=(
        "vibecalc.isolation.report:isolation",
        "vibecalc.isolation.report:run_up_maxima",
        "vibecalc.isolation.report:torque_reaction",
        "vibecalc.isolation.efficiency_report:isolation_efficiency",
        "vibecalc.isolation.mount_report:mounts",
    ),
    pictures={
        "force_over_cycle": "vibecalc.isolation.pictures:FORCE_OVER_CYCLE",
        "run_up": "vibecalc.isolation.pictures:RUN_UP",
        "transmissibility": "vibecalc.isolation.pictures:TRANSMISSIBILITY",
        "modal_energy": "vibecalc.isolation.pictures:MODAL_ENERGY",
        "mode_shapes": "vibecalc.isolation.pictures:draw_mode_shapes",
        "mounts": "vibecalc.isolation.pictures:MOUNTS",
        "engine_mounts": "vibecalc.isolation.pictures:ENGINE_MOUNTS",
        "efficiency": "vibecalc.isolation.pictures:EFFICIENCY",
    },
    assumes=(
        "The machine is a rigid body with small motions about its rest position; mounts "
        "are linear there.",
        "A run-up is a series of steady states. Flexibility of the frame, contact with "
        "stops and the effect of the motion on the crank train are left out.",
    ),
)
