"""Which stages a case asks for, and why: read from the case alone, nothing is computed.

A table that is absent from the case is a stage that is not planned, not imported, not run and
not reported.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from vibecalc.absorber.stage import plan_absorber
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Entry
from vibecalc.core.run.stage import StagePlan, below, orders_words
from vibecalc.excitation.stage import plan_pump
from vibecalc.isolation.stage import ORDERS, plan_torque_reaction
from vibecalc.kinds import finds_speed, has_speed
from vibecalc.measurement.stage import plan_measurement
from vibecalc.parts.firing import torque_reaches_mounts
from vibecalc.response.stage import plan_response
from vibecalc.roll.stage import plan_roll
from vibecalc.torsion.stage import plan_damper, plan_torsion, plan_torsion_studies

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_case(case: "Case") -> tuple[StagePlan, ...]:
    """The stages of `case` in the order in which they run."""
    return tuple(stage for make in _MAKERS for stage in make(case))


def needed_stages(case: "Case", wanted: frozenset[str] | None) -> tuple[StagePlan, ...]:
    """Of the stages of `case` those that bring what is wanted, None being all, in their order.

    A stage that others read from is there with any later one, since it may be read by that.
    """
    needed: list[StagePlan] = []
    for stage in reversed(plan_case(case)):
        brings = wanted is None or not wanted.isdisjoint(stage.quantities)
        if brings or (needed and not stage.is_last):
            needed.append(stage)
    return tuple(reversed(needed))


def planned_quantities(case: "Case") -> dict[str, Entry]:
    """Every result path that a run of `case` will hold, with its catalogue entry."""
    return {path: CATALOGUE[path] for stage in plan_case(case) for path in stage.quantities}


def _kinematics(case: "Case") -> Iterator[StagePlan]:
    asked = case.kinematics is not None
    if not (asked or _needs_excitation(case)):
        return
    curves = () if asked else ("/position", "/velocity", "/acceleration")
    paths = tuple(path for path in below("kinematics/") if not path.endswith(curves or ("//",)))
    yield StagePlan(
        stage="kinematics",
        adapter="vibecalc.kinematics.adapter:run_kinematics",
        why="[kinematics] is in the case" if asked else "the excitation needs the piston motion",
        parts=("crank_train",),
        orders=orders_words(case),
        cost="one pass over the orders" + (", 361 crank angles" if asked else ""),
        quantities=paths,
    )


def _needs_excitation(case: "Case") -> bool:
    if not has_speed(case.machine):  # [excitation] then says at most which cylinders work
        return False
    if case.machine.kind == "engine" and (case.machine.body is None or case.machine.mounts is None):
        return case.excitation is not None  # a shaft line has an excitation of its own
    return any(table is not None for table in (case.excitation, case.response, case.isolation))


def _excitation(case: "Case") -> Iterator[StagePlan]:
    if not _needs_excitation(case):
        return
    options = case.excitation
    user = "response" if case.isolation is None else "isolation"
    other = "/balance/total_" if case.machine.crank_train.has_banks else "/balance/banks/"
    balance = below("excitation/balance/", (other,)) if options and options.balance else ()
    residual = ("excitation/residual",) if options and options.residual else ()
    train = case.machine.crank_train
    rotating = len(train.counterweights) + len(train.balance_shafts)
    yield StagePlan(
        stage="excitation",
        adapter="vibecalc.excitation.adapter:run_excitation",
        why="[excitation] is in the case" if options else f"the {user} needs the forces",
        parts=("crank_train", "rotating_masses") if rotating else ("crank_train",),
        orders=orders_words(case),
        cost=f"cylinders and weights summed per order: {len(train.cylinders)} and {rotating}",
        quantities=(
            *below("excitation/", without=_EXCITATION_EXTRAS),
            *_rod(case),
            *(below("excitation/counterweight/") if train.counterweights else ()),
            *balance,
            *residual,
        ),
    )


_EXCITATION_EXTRAS = ("/balance/", "/residual", "/rod/", "/motor/", "/counterweight/", "/pump/")


def _rod(case: "Case") -> tuple[str, ...]:
    """Results of the rod as a body: of its own moment where the case gives it, else a bound."""
    rod = case.machine.crank_train.rod
    if rod is None or rod.crank_pin_to_mass_centre is None:
        return ()
    if rod.inertia is None:
        return ("excitation/rod/split_inertia", "excitation/rod/couple_bound")
    return below("excitation/rod/", without=("bound",))


def _motor(case: "Case") -> Iterator[StagePlan]:
    if case.machine.motor is None or case.excitation is None or finds_speed(case.machine):
        return
    yield StagePlan(
        stage="motor",
        adapter="vibecalc.excitation.adapter:run_motor",
        why="[machine.motor] and [excitation] are in the case",
        parts=("motor",),
        orders=f"the {len(case.machine.motor.torque.order)} of its torque",
        cost="one pass over the orders",
        quantities=below("excitation/motor/"),
        is_last=case.response is None or case.response.impact is None,
    )


_PITCH_ONLY = ("isolation/pitch/", "isolation/lever_force/", "support_force/rigid_peak")
_BODY_ONLY = ("isolation/modes/", "isolation/body/")
#: of the stages beside it
_OTHERS = ("run_up", "masked", "torque_reaction")


def _isolation(case: "Case") -> Iterator[StagePlan]:
    options = case.isolation
    if options is None:
        return
    pitch = options.model == "pitch"
    speed = f"{case.machine.speed:.6g} rad/s"
    yield StagePlan(
        stage="isolation",
        adapter="vibecalc.isolation.adapters.pitch:run_isolation_pitch"
        if pitch
        else "vibecalc.isolation.adapters.rigid_body:run_isolation_rigid_body",
        why=f'[isolation] is in the case, model = "{options.model}"',
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost="one solve per order at " + speed,
        quantities=below(
            "isolation/",
            without=(*_OTHERS, *(_BODY_ONLY if pitch else _PITCH_ONLY)),
        ),
    )
    if options.run_up is None:
        return
    first, last = options.run_up.start, options.run_up.stop
    torque = torque_reaches_mounts(case)
    yield StagePlan(
        stage="run_up",
        adapter="vibecalc.isolation.adapters.run_up:run_run_up",
        why="[isolation] run_up is in the case" + ", with the torque of the cylinders" * torque,
        parts=("body", "mounts", *(("crank_train",) if torque else ())),
        orders=ORDERS if torque else orders_words(case),
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=tuple(
            path
            for path in below("isolation/", without=() if pitch else ("lever_force",))
            if "run_up" in path or "masked" in path
        ),
        is_last=True,
    )


_MAKERS: tuple[Callable[["Case"], Iterator[StagePlan]], ...] = (
    _kinematics,
    _excitation,
    _motor,
    plan_pump,
    plan_response,
    plan_torsion,
    plan_torsion_studies,
    plan_damper,
    plan_roll,
    _isolation,
    plan_torque_reaction,
    plan_measurement,
    plan_absorber,
)
