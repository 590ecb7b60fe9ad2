"""Does a change in time of a shaft line end within the steps that a run may take?"""

from collections.abc import Iterator

from vibecalc.case.schema import Case
from vibecalc.case.torsion_tables import Transient
from vibecalc.errors import KeyPath, Problem

TRANSIENT: KeyPath = ("response", "torsion", "transient")
#: where a case names no orders
HIGHEST_ORDER = 12.0


def transient_problems(case: Case) -> list[Problem]:
    """The problem of a change that takes longer than the march in time goes."""
    return [*_problems(case)]


def _problems(case: Case) -> Iterator[Problem]:
    torsion = None if case.response is None else case.response.torsion
    if torsion is None or torsion.transient is None or case.machine.shaft_line is None:
        return
    from vibecalc.response.torsion.transient_pieces import MOST_STEPS

    change = torsion.transient
    steps = least_steps(case)
    if steps <= MOST_STEPS:
        return
    spans = _angles(case, change)
    longest = max(spans, key=lambda key: spans[key])
    key = longest
    if longest == "change":
        key = "acceleration" if change.acceleration is not None else "duration"
    yield Problem(
        path=(*TRANSIENT, key) if key in change.model_fields_set else TRANSIENT,
        message="the change takes too many steps in time",
        found=f"{steps:.3g} steps or more, for {sum(spans.values()) / 6.283185307:.3g} turns of "
        "the crank",
        allowed=f"{MOST_STEPS:.3g} steps",
        hint="a faster change, less time before and after it, or fewer orders",
    )


def least_steps(case: Case) -> float:
    """Steps in time that the highest order alone needs; the modes of the line may need more."""
    from vibecalc.response.torsion.transient_pieces import ORDER_STEP

    assert case.response is not None and case.response.torsion is not None
    torsion = case.response.torsion
    assert torsion.transient is not None
    orders, highest = torsion.orders, HIGHEST_ORDER
    if orders is not None and orders.count is not None:
        highest = orders.count * (orders.step or _step(case))
    elif orders is not None and orders.highest is not None:
        highest = orders.highest
    return highest * sum(_angles(case, torsion.transient).values()) / ORDER_STEP


def _step(case: Case) -> float:
    return 1.0 if case.machine.cycle == "two_stroke" else 0.5


def _angles(case: Case, change: Transient) -> dict[str, float]:
    """Angle in rad that the crank turns through before, during and after the change."""
    if change.kind in ("load_step", "misfire_onset"):
        speed = case.machine.speed
        return {"before": change.before * speed, "after": change.after * speed}
    begin = 0.0 if change.kind == "start" else change.start or 0.0
    end = change.stop or 0.0
    duration = change.duration
    if duration is None:
        assert change.acceleration is not None  # one of the two, says the form
        duration = abs(end - begin) / change.acceleration
    return {
        "before": change.before * begin,
        "change": duration * (begin + end) / 2.0,
        "after": change.after * end,
    }
