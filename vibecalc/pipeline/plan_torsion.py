"""The stages that [response.torsion] asks for: the shaft line at one speed and over a range."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.machine.shaft_sections import has_stress
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.stage_plan import StagePlan, below

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.case.torsion_tables import LineSpeeds, Torsion

_STEADY = (
    *("/modes/", "/excitation/"),
    *("/angle", "/twist", "/torque", "/stress", "/section_heat", "/station_heat", "/modal_heat"),
    "/damper/",
    *("/gear/", "/margin/", "/separation/operating/", "/critical/", "/limit/operating"),
    *("/limit/basis/", "/healthy/mean_torque", "/healthy/damper/", "/healthy/limit/operating_use"),
    *(f"/healthy/{name}_half_range" for name in ("torque", "twist", "stress")),
)
_RANGE = (
    *("/speeds/", "/masked/", "/largest/", "/summit/", "/limit/", "/bare/"),
    *("/barred/", "/exceeded/"),
    *("/reduction", "/hammering/", "/campbell/", "/separation/range/"),
    *("/healthy/speeds/", "/healthy/largest/", "/healthy/limit/largest_use"),
)
#: where the case says nothing
_HIGHEST_ORDER = 12.0
#: longer rows are not printed
_LONGEST_HOLZER = 100


def plan_torsion(case: "Case") -> Iterator[StagePlan]:
    """Modes, excitation and vibration at the operating speed; curves where speeds are given."""
    torsion = asked(case)
    if torsion is None or case.machine.shaft_line is None:
        return
    line = case.machine.shaft_line
    stations = len(line.stations)
    yield StagePlan(
        stage="torsion",
        adapter="vibecalc.pipeline.stages.torsion.stage:run",
        why="[response.torsion] is in the case",
        parts=("crank_train", "shaft_line"),
        orders=_orders_words(case),
        cost=f"modes of {stations} stations; {solves(case)} solves, one per order, at "
        f"{case.machine.speed:.6g} rad/s",
        quantities=_picked(case, _STEADY),
    )
    if torsion.speeds is None:
        return
    speeds = torsion.speeds
    yield StagePlan(
        stage="torsion_speeds",
        adapter="vibecalc.pipeline.stages.torsion.speeds:run",
        why="[response.torsion] speeds are in the case",
        parts=("crank_train", "shaft_line"),
        orders=_orders_words(case),
        cost=_range_cost(case, speeds),
        quantities=_picked(case, _RANGE),
        is_last=True,
    )


def asked(case: "Case") -> "Torsion | None":
    """[response.torsion] of a case."""
    return None if case.response is None else case.response.torsion


def has_loops(case: "Case") -> bool:
    """Whether shafts and gears close a loop."""
    line = case.machine.shaft_line
    assert line is not None
    return len(line.shafts) + len(line.gears) > len(line.stations) - 1


def has_holzer(case: "Case") -> bool:
    """Whether the line, a row or a tree of branches, is short enough for printed tables."""
    line = case.machine.shaft_line
    assert line is not None
    return len(line.stations) + len(line.dampers) <= _LONGEST_HOLZER and not has_loops(case)


def has_modal_damping(case: "Case") -> bool:
    """Whether the case damps by mode."""
    torsion = asked(case)
    assert torsion is not None
    return torsion.damping_model is not None and torsion.damping_model.kind == "modal"


def has_damped_rings(case: "Case") -> bool:
    """Whether a ring is damped against the line, so that its modes are not the undamped ones."""
    torsion, line = asked(case), case.machine.shaft_line
    assert torsion is not None and line is not None
    return torsion.damping_model is None and any(
        one.damping or one.loss_factor for one in line.dampers
    )


def _picked(case: "Case", starts: tuple[str, ...]) -> tuple[str, ...]:
    """Paths of these beginnings that the case has something for."""
    line, torsion = case.machine.shaft_line, asked(case)
    assert line is not None and torsion is not None
    train = case.machine.crank_train
    there = {
        "ring_shape": bool(line.dampers),
        "/damper/": bool(line.dampers),
        "/bare/": bool(line.dampers),
        "/reduction": bool(line.dampers),
        "/speeds/heat": bool(line.dampers),
        "/speeds/travel": bool(line.dampers),
        "gear": bool(line.gears),
        "/hammering/": bool(line.gears),
        "/campbell/": torsion.campbell and any(one.kind == "pendulum" for one in line.dampers),
        "transfer_matrix": not has_loops(case),
        "holzer": has_holzer(case),
        "undamped_frequency": has_damped_rings(case),
        "/kept": torsion.separation is not None,
        "bank_factor": len({one.bank_angle for one in train.cylinders}) > 1,
        "modal_heat": has_modal_damping(case),
        "stress": any(has_stress(shaft) for shaft in line.shafts),
        "tangential_pressure": bool(train.bore),
        "mean_indicated_pressure": bool(train.bore),
        "/limit/": bool(torsion.limits),
        "/limit/operating": bool(torsion.limits) and starts is _STEADY,
        "/limit/basis/": bool(torsion.limits) and starts is _STEADY,
        "/healthy/": bool(torsion.misfire),
        "/barred/": bool(torsion.limits),
        "/exceeded/": bool(torsion.limits),
    }
    left_out = tuple(word for word, has in there.items() if not has)
    return tuple(
        path
        for path in below(f"{ROOT}/", without=left_out)
        if path.startswith(tuple(ROOT + start for start in starts))
    )


def asked_orders(case: "Case") -> tuple[float, float]:
    """Highest order and step of the orders of a case."""
    torsion = asked(case)
    given = None if torsion is None else torsion.orders
    four = (case.machine.cycle or "four_stroke") == "four_stroke"
    step = (0.5 if four else 1.0) if given is None or given.step is None else given.step
    if given is not None and given.count is not None:
        return step * given.count, step
    highest = _HIGHEST_ORDER if given is None or given.highest is None else given.highest
    return step * math.floor(highest / step + 1e-9), step


def solves(case: "Case", speeds: int = 1) -> int:
    """Solves of the line at so many speeds, one per order."""
    highest, step = asked_orders(case)
    return round(highest / step) * speeds


def _range_cost(case: "Case", speeds: "LineSpeeds") -> str:
    """Solves over the range in words; maxima between the points take some more."""
    line, torsion = case.machine.shaft_line, asked(case)
    assert line is not None and torsion is not None
    number = solves(case, speeds.points)
    twice = f", and {number} without dampers" if line.dampers else ""
    twice += f", and {number} without misfire" if torsion.misfire else ""
    return (
        f"{number} solves, one per order at {speeds.points} speeds from {speeds.start:.6g} to "
        f"{speeds.stop:.6g} rad/s{twice}"
    )


def _orders_words(case: "Case") -> str:
    highest, step = asked_orders(case)
    return f"{step:g} to {highest:g} by {step:g}"
