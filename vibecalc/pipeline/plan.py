"""Which stages a case asks for, and why: read from the case alone, nothing is computed.

A table that is absent from the case is a stage that is not planned, not imported, not run and
not reported.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.pipeline.catalogue import CATALOGUE, Entry

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


class StagePlan(NamedTuple):
    """One stage of a run: its adapter, why it is there, what it reads and what it will make.

    `is_last` marks a stage that no later one reads from.
    """

    stage: str
    module: str
    why: str
    parts: tuple[str, ...]
    uses: tuple[str, ...]
    orders: str
    cost: str
    quantities: tuple[str, ...]
    is_last: bool = False

    def as_texts(self) -> dict[str, str]:
        """The plan of this stage as short texts, for reports."""
        return {
            "stage": self.stage,
            "why": self.why,
            "parts": ", ".join(self.parts),
            "orders": self.orders,
            "modules": ", ".join(self.uses),
            "cost": self.cost,
            "quantities": ", ".join(self.quantities),
        }


def plan_case(case: "Case") -> tuple[StagePlan, ...]:
    """The stages of `case` in the order in which they run."""
    return tuple(stage for make in _MAKERS for stage in make(case))


def planned_quantities(case: "Case") -> dict[str, Entry]:
    """Every result path that a run of `case` will hold, with its catalogue entry."""
    return {path: CATALOGUE[path] for stage in plan_case(case) for path in stage.quantities}


@lru_cache(maxsize=64)
def _below(prefix: str, without: tuple[str, ...] = ()) -> tuple[str, ...]:
    return tuple(
        path
        for path in CATALOGUE
        if path.startswith(prefix) and not any(word in path for word in without)
    )


def _orders(case: "Case") -> str:
    if case.excitation and case.excitation.orders:
        return f"1 to {case.excitation.orders}, as the case asks"
    if case.kinematics and case.kinematics.series == "truncated":
        separate = case.excitation is not None and case.excitation.driven_machine == "separate"
        last = (4 if separate else 2) * (case.kinematics.terms or 1)
        return f"1 to {last}, all of the truncated series"
    return f"until the rest is below rtol = {case.accuracy.rtol:g}"


def _kinematics(case: "Case") -> Iterator[StagePlan]:
    asked = case.kinematics is not None
    if not (asked or _needs_excitation(case)):
        return
    truncated = case.kinematics is not None and case.kinematics.series == "truncated"
    curves = () if asked else ("/position", "/velocity", "/acceleration")
    paths = tuple(path for path in _below("kinematics/") if not path.endswith(curves or ("//",)))
    yield StagePlan(
        stage="kinematics",
        module="kinematics",
        why="[kinematics] is in the case" if asked else "the excitation needs the piston motion",
        parts=("crank_train",),
        uses=("kinematics.truncated_series",) if truncated else ("kinematics.harmonics",),
        orders=_orders(case),
        cost="one pass over the orders" + (", 361 crank angles" if asked else ""),
        quantities=paths,
    )


def _needs_excitation(case: "Case") -> bool:
    return case.excitation is not None or case.isolation is not None


def _excitation(case: "Case") -> Iterator[StagePlan]:
    if not _needs_excitation(case):
        return
    options = case.excitation
    balance = _below("excitation/balance/") if options and options.balance else ()
    residual = ("excitation/residual",) if options and options.residual else ()
    train = case.machine.crank_train
    rotating = len(train.counterweights) + len(train.balance_shafts)
    yield StagePlan(
        stage="excitation",
        module="excitation",
        why="[excitation] is in the case" if options else "the isolation needs the forces",
        parts=("crank_train", "rotating_masses") if rotating else ("crank_train",),
        uses=("excitation.reciprocating", "excitation.rotating")
        + (("excitation.balance",) if balance or residual else ())
        + (
            ("excitation.inertia_torque",)
            if options and options.driven_machine == "separate"
            else ()
        ),
        orders=_orders(case),
        cost=f"cylinders and weights summed per order: {len(train.cylinders)} and {rotating}",
        quantities=(
            *_below("excitation/", without=("/balance/", "/residual")),
            *balance,
            *residual,
        ),
    )


_PITCH_ONLY = ("isolation/pitch/", "isolation/lever_force/", "support_force/rigid_peak")
_BODY_USES = ("isolation.rigid_body", "response.modes", "response.direct")
_BODY_ONLY = ("isolation/modes/", "isolation/body/")


def _isolation(case: "Case") -> Iterator[StagePlan]:
    options = case.isolation
    if options is None:
        return
    pitch = options.model == "pitch"
    speed = f"{case.machine.speed:.6g} rad/s"
    yield StagePlan(
        stage="isolation",
        module="isolation_pitch" if pitch else "isolation_rigid_body",
        why=f'[isolation] is in the case, model = "{options.model}"',
        parts=("body", "mounts"),
        uses=("isolation.pitch",) if pitch else _BODY_USES,
        orders=_orders(case),
        cost="one solve per order at " + speed,
        quantities=_below(
            "isolation/",
            without=("run_up", "masked", *(_BODY_ONLY if pitch else _PITCH_ONLY)),
        ),
    )
    if options.run_up is None:
        return
    first, last = options.run_up.start, options.run_up.stop
    yield StagePlan(
        stage="run_up",
        module="run_up",
        why="[isolation] run_up is in the case",
        parts=("body", "mounts"),
        uses=("isolation.run_up", "numerics.cycle_peak"),
        orders=_orders(case),
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=tuple(
            path
            for path in _below("isolation/", without=() if pitch else ("lever_force",))
            if "run_up" in path or "masked" in path
        ),
        is_last=True,
    )


_MAKERS: tuple[Callable[["Case"], Iterator[StagePlan]], ...] = (
    _kinematics,
    _excitation,
    _isolation,
)
