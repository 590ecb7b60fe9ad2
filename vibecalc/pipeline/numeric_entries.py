"""Entries of numbered axes that a run will have, as far as the case tells before it."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.pipeline.catalogue import AXES

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: result paths of this beginning have the orders of the crank train, these apart
_OF_THE_TRAIN = ("kinematics/", "excitation/", "response/", "isolation/")
_OWN_ORDERS = (
    "excitation/motor/",
    "excitation/balance/",
    "response/impact/",
    "response/roll/",
    "response/start_up/",
    "response/control/",
)
#: and those that begin with order 0
_FROM_ZERO = ("kinematics/", "excitation/rod/")
_OWN_CLEARANCE = "machine.joints.wrist_pin.clearance"
#: as in `results/select.py`: two numbers this close, relatively, are the same entry
_SAME = 1e-9
_SHOWN = 12
#: axes whose entries are numbered 1, 2, 3, ...
_NUMBERED = (
    *("mode", "other_mode", "damped_mode", "bare_mode", "elastic_mode", "pole", "multiplier"),
    *("summit", "passage", "contact", "turn", "cage", "hammering", "barred", "limit", "wedge"),
    *("unstable", "basin"),
)


def missing_entries(
    path: KeyPath, quantity: str, where: Mapping[str, int | float | str], case: "Case"
) -> Iterator[Problem]:
    """Problems of a `where` that picks a clearance, an order or a mode that no run will have."""
    for axis, wanted in where.items():
        span = _speeds(quantity, case) if axis == "speed" else None
        known = span or _known(quantity, axis, case)
        if known is None and axis not in _NUMBERED:
            continue
        try:
            value = _number(wanted, AXES[axis][0])
        except UnitError as error:
            yield Problem(
                path=(*path, "where"),
                message=f"{axis} of {quantity} cannot be read: {error.message}",
                found=f"{axis} = {wanted!r}",
                allowed=error.allowed,
                hint=error.hint,
            )
            continue
        if known is None:
            there = value >= 1.0 and abs(value - round(value)) <= _SAME * value
            allowed, because = "1, 2, 3, ...", ""
        else:
            entries, because = known
            # a curve has a value at every speed between its ends
            there = span is not None and entries[0] <= value <= entries[-1]
            there = there or any(
                abs(value - one) <= _SAME * max(abs(value), abs(one)) for one in entries
            )
            allowed = _listed(entries, wanted, axis)
            allowed = allowed if span is None else allowed.replace(", ", " to ")
        if not there:
            article = "an" if axis[0] in "aeiou" else "a"
            yield Problem(
                path=(*path, "where"),
                message=f"this {_row(path)} asks for {article} {axis} that {quantity} lacks",
                found=f"{axis} = {wanted!r}",
                allowed=allowed,
                hint=because,
            )


def _row(path: KeyPath) -> str:
    return f"[[{path[0]}]]" if isinstance(path[1], int) else str(path[1])


def _speeds(quantity: str, case: "Case") -> tuple[tuple[float, ...], str] | None:
    """Ends of the speeds over which a curve is computed, and where they come from."""
    response, design = case.response, case.damper_design
    torsion = None if response is None else response.torsion
    asked: Any = None
    words = "[response.torsion.speeds]"
    if quantity.startswith("isolation/"):
        asked, words = case.isolation and case.isolation.run_up, "[isolation.run_up]"
    elif quantity.startswith("response/run_up/"):
        asked, words = response and response.run_up, "[response.run_up]"
    elif quantity.startswith("damper_design/") and design is not None and design.speeds is not None:
        asked, words = design.speeds, "[damper_design.speeds]"
    elif torsion is not None:
        asked = torsion.speeds
    return None if not asked else ((asked.start, asked.stop), f"{words} says from where to where")


def _known(quantity: str, axis: str, case: "Case") -> tuple[tuple[float, ...], str] | None:
    """The entries of an axis and where they come from; None where only the run can tell."""
    if axis == "clearance":
        return _clearances(case)
    if axis == "half_order" and quantity.startswith("response/torsion/"):
        return _half_orders(case)
    if axis in ("mode", "other_mode"):
        return _modes(quantity, case)
    if axis != "order":
        return None
    impact = None if case.response is None else case.response.impact
    if quantity.startswith("response/impact/") and impact is not None:
        return tuple(range(1, impact.orders + 1)), "orders of [response.impact] is the highest"
    roll = None if case.response is None else case.response.roll
    if quantity.startswith("response/roll/") and roll is not None:
        return tuple(range(1, roll.orders + 1)), "orders of [response.roll] is the highest"
    control = None if case.response is None else case.response.control
    if quantity.startswith("response/control/") and control is not None:
        return tuple(range(1, control.orders + 1)), "orders of [response.control] is the highest"
    options = case.excitation
    if options is None:
        return None
    if quantity.startswith("excitation/balance/") and options.balance is not None:
        return options.balance.orders, "orders of [excitation.balance] are those tabulated"
    if quantity.startswith(_OWN_ORDERS) or not quantity.startswith(_OF_THE_TRAIN):
        return None
    if options.orders is None:
        return None  # the tolerance decides
    first = 0 if quantity.startswith(_FROM_ZERO) else 1
    return tuple(range(first, options.orders + 1)), "orders of [excitation] is the highest one kept"


def _modes(quantity: str, case: "Case") -> tuple[tuple[float, ...], str] | None:
    line = case.machine.shaft_line
    if quantity.startswith(("isolation/modes/", "isolation/torque_reaction/")):
        planar = case.isolation is not None and case.isolation.model == "planar"
        most, because = (3, "a body in the plane") if planar else (6, "a rigid body")
        because += f" has {most} degrees of freedom"
    elif quantity.startswith("response/modes/"):
        most, because = 6, "a rigid body has 6 degrees of freedom"
    elif quantity.startswith("response/torsion/") and line is not None:
        most = len(line.stations) + len(line.dampers)
        because = "a shaft line has at most one mode for each station and each damper"
    else:
        return None
    return tuple(range(1, most + 1)), because


def _half_orders(case: "Case") -> tuple[tuple[float, ...], str]:
    from vibecalc.torsion.stage import asked_orders

    highest, step = asked_orders(case)
    entries = tuple(step * number for number in range(1, round(highest / step) + 1))
    return entries, "orders of [response.torsion] says their step and the highest"


def _clearances(case: "Case") -> tuple[tuple[float, ...], str] | None:
    impact = None if case.response is None else case.response.impact
    joints = case.machine.joints
    if impact is None or joints is None:
        return None
    if impact.clearances:
        return impact.clearances, "clearances of [response.impact] takes more of them"
    study = case.optimisation
    if study is not None and any(one.key == _OWN_CLEARANCE for one in study.variables):
        return None
    return (joints.wrist_pin.clearance,), "clearances of [response.impact] takes others, or more"


def _number(wanted: int | float | str, unit: str) -> float:
    from vibecalc.units import parse_quantity

    return parse_quantity(wanted, unit)


def _listed(entries: tuple[float, ...], wanted: int | float | str, axis: str) -> str:
    """The entries in the unit that the case writes, the first and the last of many."""
    from vibecalc.units import convert, split_number

    unit = AXES[axis][0]
    written = split_number(wanted)[1] if isinstance(wanted, str) else ""
    values = [convert(one, unit, written) if written else one for one in entries]
    texts = [f"{value:.9g} {written or unit}".rstrip() for value in values]
    if len(texts) > _SHOWN:
        short = axis != "clearance"
        return f"{texts[0]} to {texts[-1]}" if short else ", ".join(texts[:_SHOWN])
    return ", ".join(texts)
