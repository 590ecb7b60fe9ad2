"""What a case asks of its shaft line and what the line has, read from the tables alone."""

import math
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Leading
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.study_results import PASSAGES

if TYPE_CHECKING:
    from vibecalc.torsion.line_part_tables import Coupling
    from vibecalc.torsion.question_tables import Transient
    from vibecalc.torsion.shaft_line_tables import ShaftLine
    from vibecalc.torsion.tables import Torsion

#: where the case says nothing
_HIGHEST_ORDER = 12.0
#: of longer lines poles are not all computed
_MANY_FREEDOMS = 200
#: longer rows are not printed
_LONGEST_HOLZER = 100


def asked(case: Case) -> "Torsion | None":
    """[response.torsion] of a case."""
    return None if case.response is None else case.response.torsion


def torsion_of(case: Case) -> "Torsion":
    torsion = asked(case)
    assert torsion is not None
    return torsion


def shaft_line_of(case: Case) -> "ShaftLine":
    assert case.machine.shaft_line is not None
    return case.machine.shaft_line


def has_loops(case: Case) -> bool:
    """Whether shafts and gears close a loop."""
    line = shaft_line_of(case)
    return len(line.shafts) + len(line.gears) > len(line.stations) - 1


def has_holzer(case: Case) -> bool:
    """Whether the line, a row or a tree of branches, is short enough for printed tables."""
    return freedom_count(case) <= _LONGEST_HOLZER and not has_loops(case)


def has_damped_rings(case: Case) -> bool:
    """Whether a ring is damped against the line, which may make its modes others than undamped."""
    dampers = shaft_line_of(case).dampers
    return torsion_of(case).damping_model is None and any(
        one.damping or one.loss_factor for one in dampers
    )


def has_friction_damper(case: Case) -> bool:
    """Whether dry friction drags a ring along."""
    return any(one.kind == "friction" for one in shaft_line_of(case).dampers)


def modes_follow_speed(case: Case) -> bool:
    """Whether pendulums, or couplings that vary, let natural frequencies change with the speed."""
    if any(one.kind == "pendulum" for one in shaft_line_of(case).dampers):
        return True
    return any(one.follows for one in named_couplings(case).values())


def named_couplings(case: Case) -> dict[str, "Coupling"]:
    """Elastic couplings of a line by the names of their shafts."""
    from vibecalc.torsion.shaft_line_tables import Layout

    line = shaft_line_of(case)
    named = zip(Layout(line).sections, line.shafts, strict=True)
    return {name: shaft.coupling for name, shaft in named if shaft.coupling is not None}


def has_warm_couplings(case: Case) -> bool:
    """Whether the temperature of some coupling is given, or follows from its heat."""
    found = named_couplings(case).values()
    return any(one.temperature or one.thermal_resistance or one.temperature_rise for one in found)


def coupling_limits(case: Case) -> tuple[str, ...]:
    """Limits that the maker of some coupling says."""
    found = named_couplings(case)
    if not found:
        return ()
    from vibecalc.torsion.couplings import LIMITS, has_limit, permissible

    said = zip(*(has_limit(permissible(one)) for one in found.values()), strict=True)
    return tuple(name for name, of in zip(LIMITS, said, strict=True) if any(of))


def asked_orders(case: Case) -> tuple[float, float]:
    """Highest order and step of the orders of a case."""
    torsion = asked(case)
    given = None if torsion is None else torsion.orders
    four = (case.machine.cycle or "four_stroke") == "four_stroke"
    step = (0.5 if four else 1.0) if given is None or given.step is None else given.step
    if given is not None and given.count is not None:
        return step * given.count, step
    highest = _HIGHEST_ORDER if given is None or given.highest is None else given.highest
    return step * math.floor(highest / step + 1e-9), step


def excited_orders(case: Case) -> tuple[float, ...]:
    """Orders of the crank that excite the line, ascending: of cylinders and as given at stations.

    A frequency that does not follow the speed counts as its order at the operating speed.
    """
    engine: tuple[float, ...] = ()
    if has_crank_train(case.machine):
        highest, step = asked_orders(case)
        engine = tuple(step * number for number in range(1, round(highest / step) + 1))
    if not counts_at_stations(case):
        return engine
    from vibecalc.torsion.station_torques import all_orders

    return tuple(all_orders(case, engine).order.tolist())


def counts_at_stations(case: Case) -> bool:
    """Whether orders are those of torques at stations, alone or with those of cylinders."""
    return bool(shaft_line_of(case).excitations) or not has_crank_train(case.machine)


def orders_words(case: Case) -> str:
    """Orders of the excitation in words."""
    if counts_at_stations(case):
        orders = excited_orders(case)
        return f"{len(orders)} from {orders[0]:.4g} to {orders[-1]:.4g}"
    highest, step = asked_orders(case)
    return f"{step:g} to {highest:g} by {step:g}"


def condition_names(case: Case) -> tuple[str, ...]:
    """Names of the conditions of the cylinders, none where the case asks for none."""
    from vibecalc.torsion.question_tables import condition_names

    torsion = asked(case)
    if torsion is None or torsion.conditions is None:
        return ()
    cylinders = (one.name for one in case.machine.crank_train.cylinders)
    return condition_names(torsion.conditions, cylinders)


def has_loss(case: Case) -> bool:
    """Whether something on the line has a loss factor, defined for steady vibration only."""
    line = shaft_line_of(case)
    return any(one.eta for one in line.shafts) or any(one.loss_factor for one in line.dampers)


def freedom_count(case: Case) -> int:
    line = shaft_line_of(case)
    return len(line.stations) + len(line.dampers)


# ----------------------------------------------------------------------------
# Steps in time that a change takes.
# ----------------------------------------------------------------------------


def least_steps(case: Case) -> float:
    """Steps in time that the highest order alone needs; the modes of the line may need more."""
    from vibecalc.torsion.transient.march import ORDER_STEP

    change = torsion_of(case).transient
    assert change is not None
    highest = max(excited_orders(case), default=0.0)
    return highest * sum(turned_angles(case, change).values()) / ORDER_STEP


def turned_angles(case: Case, change: "Transient") -> dict[str, float]:
    """Angle in rad that the crank turns through before, during and after the change, by key."""
    if change.kind not in PASSAGES:
        speed = case.machine.speed
        return {"time_before": change.time_before * speed, "time_after": change.time_after * speed}
    begin = 0.0 if change.kind == "start" else change.start or 0.0
    end = change.stop or 0.0
    duration = change.duration
    if duration is None:
        assert change.acceleration is not None  # one of the two, says the form
        duration = abs(end - begin) / change.acceleration
    return {
        "time_before": change.time_before * begin,
        "change": duration * (begin + end) / 2.0,
        "time_after": change.time_after * end,
    }


# ----------------------------------------------------------------------------
# Studies of many dampers on one line.
# ----------------------------------------------------------------------------

#: numbers of rings over which largest values are found together, and these
RING_KEYS = frozenset(
    f"machine.shaft_line.dampers[].{name}"
    for name in ("inertia", "stiffness", "damping", "loss_factor")
)
TOGETHER = tuple(
    f"{ROOT}/{name}"
    for name in (
        *("largest/torque_half_range", "largest/twist_half_range", "largest/stress_half_range"),
        *("largest/speed", "reduction", "speeds/heat"),
    )
)


def leading(case: Case) -> Leading | None:
    """How many rings on one line, whose values follow neither speed nor load, are taken at once."""
    from vibecalc.torsion.shaft_line_tables import has_laws

    line, torsion = shaft_line_of(case), torsion_of(case)
    own_ways = (
        *(torsion.speeds is None, torsion.damping_model is not None, torsion.method == "modal"),
        *(torsion.limits, torsion.misfire, line.excitations, named_couplings(case)),
        *(modes_follow_speed(case), has_laws(line), freedom_count(case) > _MANY_FREEDOMS),
    )
    if any(own_ways):
        return None
    return Leading(keys=RING_KEYS, only=TOGETHER, most=64, takes_all=False, milliseconds=5.0)
