"""Limits of a shaft line as rows: of rules, makers, gears, distance from orders, in conditions."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibecalc.core.report.sections import having, labels, speed_of
from vibecalc.core.results.record import (
    BARRED,
    BROKEN,
    KEPT,
    UNDECIDED,
    Estimate,
    Quantity,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import state_of, verdicts_of
from vibecalc.torsion.report.couplings import LIMIT_WORDS, borne, permitted
from vibecalc.torsion.report.limits import (
    by_section,
    exceeded_rows,
    limits_of,
    of_torque,
    rule_of,
    separation_rule,
)
from vibecalc.torsion.report.line import (
    MEGA,
    TORSION,
    asked,
    joined,
    line_of,
    mode_names,
    order_text,
    speed_range,
    torque_unit,
    vector,
)
from vibecalc.torsion.stress_limits import NO_BARRED_RANGE

CONTINUOUS, PASSING, AT_SPEED = "continuous", "passing through", "operating speed"
Where = dict[str, Any]


def limit_verdicts(result: Result) -> Iterator[Verdict]:
    """Every limit of the line that was computed.

    What holds at all speeds of the range has no row of its own for the operating speed within it.
    """
    silent: Any = asked(result).get("misfire") or ()
    words = f"misfire of cylinder {joined(map(str, silent))}" if silent else ""
    for part in (_by_use, _of_gears, _separated):
        for row in part(result):
            yield row if row.condition else row._replace(condition=words)


#: the worst first, as tables flag them
_FLAGS = {BROKEN: "BROKEN", UNDECIDED: "UNDECIDED", BARRED: "pass only", KEPT: "kept"}


def flags(result: Result, *kinds: str) -> list[str]:
    """The worst verdict on each limit of stress or torque, of all `kinds` or of some."""
    states: dict[Any, set[str]] = {}
    for row in verdicts_of(result):
        of = row.limit.rpartition(", ")[2]
        if row.element and row.quantity.startswith(f"{TORSION}limit/") and of in (kinds or (of,)):
            states.setdefault(row.where["limit"], set()).add(row.state)
    every = range(1, len(limits_of(result)) + 1)
    return [next(_FLAGS[one] for one in _FLAGS if one in states.get(i, {KEPT})) for i in every]


def _covered(result: Result, state: str | None) -> bool:
    """Whether the operating speed lies in a range of speeds over which a limit is kept."""
    low, high = speed_range(result)
    speed = speed_of(result)
    return state == KEPT and speed is not None and low <= speed <= high


# ----------------------------------------------------------------------------
# Uses of limits by rules, tables and makers: of the line as it is, and of the worst condition.
# ----------------------------------------------------------------------------

_LARGEST = ("largest_use", "", "operating_use", "speed")
_COUPLING = ("largest_use", "", "use", "largest_use_speed")
#: uses over the speeds, in passing through and at the operating speed, and the speeds of the first
_USES = {
    "limit/": ("each/use", "each/transient_use", "operating/use", "each/speed"),
    "coupling/": _COUPLING,
    "healthy/limit/": _LARGEST,
    "healthy/coupling/": _COUPLING,
    "conditions/limit/": _LARGEST,
    "conditions/coupling/": _COUPLING,
}


def _by_use(result: Result) -> Iterator[Verdict]:
    """Continuous running over the range, passing through and at the operating speed."""
    for stem, names in _USES.items():
        paths = [TORSION + stem + name for name in names]
        quantities = [result.record.quantities.get(path) for path in paths]
        known = next((one for one in quantities[:3] if one is not None), None)
        axes = [axis for axis in known.axes if axis.name != "condition"] if known else []
        for place in np.ndindex(*(len(axis.values) for axis in axes)) if axes else ():
            entry: Where = {axis.name: axis.values[k] for axis, k in zip(axes, place, strict=True)}
            over = None
            for kind, quantity in zip((CONTINUOUS, PASSING, AT_SPEED), quantities[:3], strict=True):
                shares = np.zeros(1) if quantity is None else _over_conditions(quantity, place)
                worst = int(np.argmax(shares))
                covered = kind == AT_SPEED and _covered(result, over)
                if quantity is None or not shares[worst] > 0.0 or covered:
                    continue
                speed = speed_of(result) if kind == AT_SPEED else None
                if kind != AT_SPEED and (at := quantities[3]) is not None:
                    speed = float(_over_conditions(at, place)[worst])
                row = _row(result, quantity, entry, kind, float(shares[worst]), speed)
                if stem.startswith(("healthy/", "conditions/")):
                    row = row._replace(condition=_condition(quantity, worst))
                else:
                    row = _in_unit(result, row, stem, kind, place)
                if kind == PASSING and not row.unit:  # that of another largest use
                    row = row._replace(speed=np.nan)
                if kind == CONTINUOUS:
                    over = row.state
                    if "limit" in entry:
                        row = _barred(result, row, stem, place, worst)
                yield row


def _over_conditions(quantity: Quantity, place: tuple[int, ...]) -> np.ndarray:
    """Entries (c,) at a place among all other axes; one where there are no conditions."""
    entry: Any = (..., *place)
    return np.ravel(quantity.values[entry])


def _condition(quantity: Quantity, place: int) -> str:
    if quantity.axes[0].name != "condition":
        return "all cylinders fire"
    named = labels(quantity.axes[0])
    return named[place] + f", worst of {len(named)}" * (len(named) > 1)


def _row(
    result: Result, quantity: Quantity, entry: Where, kind: str, share: float, speed: float | None
) -> Verdict:
    """A row of a use, whose error is that of its quantity: the whole of it is 1."""
    where: Where = {axis: int(one) if axis == "limit" else str(one) for axis, one in entry.items()}
    state = state_of(1.0 - share, quantity.error_estimate, 1.0)
    return Verdict(
        quantity=quantity.path,
        where=where,
        min=None,
        max=1.0,
        unit="",
        computed=share,
        label=", ".join(f"{axis}={one}" for axis, one in where.items()),
        error_estimate=Estimate(quantity.error_estimate, 0.0),
        margin=1.0 - share,
        state=state,
        decided_by=remedy(quantity, result.case) if state == UNDECIDED else "",
        use=share,
        speed=np.nan if speed is None else speed,
        **_words(result, where, kind),
    )


def _words(result: Result, where: Where, kind: str) -> dict[str, Any]:
    """Element, limit, source and status of a row."""
    if "coupling" in where:
        line, name = line_of(result), where["coupling"]
        of = next((one.type for one in line.couplings if one.name == name), "") if line else ""
        words = LIMIT_WORDS[str(where["coupling_limit"])]
        if words.startswith(" "):  # another reading of the line above it
            words = f"{LIMIT_WORDS['T_KW']}, by orders"
        source, status = (of, "maker") if of else ("values of the case", "case")
        return {"element": name, "limit": words, "source": source, "status": status}
    place = int(where["limit"]) - 1
    limit, torques = limits_of(result)[place], of_torque(result.record)
    rule = rule_of(limit)
    source, status = f"{place + 1}: {rule.name}", "case"
    if limit.get("rule"):
        source, status = f"{source}, {rule.edition}", rule.status
    of = "torque" if torques[place] else "stress"
    return {
        "element": where.get("section", f"limit {place + 1}, its worst element"),
        "limit": f"{of}, {kind}",
        "source": source,
        "status": status,
    }


def _in_unit(result: Result, row: Verdict, stem: str, kind: str, place: tuple[int, ...]) -> Verdict:
    """The row with its numbers in place of the use, where they are known and belong to it."""
    record = result.record
    if stem == "coupling/":
        line, name = line_of(result), str(row.where["coupling_limit"])
        allowed, unit = (np.inf, "") if line is None else permitted(line.couplings[place[0]], name)
        load = borne(result, name, place[0], row.speed if kind == CONTINUOUS else None)
        load = row.use * allowed if name == "n_max" else load
    else:
        of = row.limit.partition(",")[0]
        factor, unit = torque_unit(record) if of == "torque" else (MEGA, "N/mm^2")
        at, prefix = "operating" if kind == AT_SPEED else "each", "torque_" * (of == "torque")
        both = (f"{at}/{prefix}{'transient' if kind == PASSING else 'allowed'}", f"{at}/{of}")
        found = [by_section(record, name) for name in both]
        allowed, load = (0.0 if one is None else factor * float(one[place]) for one in found)
        if allowed and load and abs(load / allowed - row.use) > 1e-6 * row.use:
            load = None  # the largest stress stands at another speed
    if not load or not allowed or not 0.0 < allowed < np.inf:
        return row
    margin = allowed - load
    if (margin > 0.0) != (row.use < 1.0):  # a torque that counts by its frequency
        margin = allowed * row.margin
    error = Estimate(row.error_estimate * allowed, 0.0)
    return row._replace(max=allowed, computed=load, margin=margin, unit=unit, error_estimate=error)


def _barred(
    result: Result, row: Verdict, stem: str, place: tuple[int, ...], condition: int
) -> Verdict:
    """The row of continuous running: what is exceeded only where a range may be barred is kept.

    No range may be that has the operating speed in it. In a condition no ranges are looked for:
    from a share of the rated speed on a rule lets none be barred, below that it is undecided.
    """
    record = result.record
    if row.state != BROKEN:
        return row
    here = record.quantities.get(TORSION + stem + _USES[stem][2])
    if here is not None:
        share = _over_conditions(here, place)[condition]
        if state_of(1.0 - share, here.error_estimate, 1.0) != KEPT:
            return row
    if stem == "limit/":
        ranges = [one for one in exceeded_rows(record) if one.limit == row.where["limit"]]
        may = bool(ranges) and all(one.permitted for one in ranges)
        return row._replace(state=BARRED) if may else row
    rated = vector(record, "limit/basis/rated_speed", "limit")
    top = 0.0 if rated is None else NO_BARRED_RANGE * rated[place[0]]
    if 0.0 < top <= row.speed:
        return row
    decided_by = "a case of that condition, which looks for ranges to bar,"
    return row._replace(state=UNDECIDED, decided_by=decided_by)


# ----------------------------------------------------------------------------
# Gears and distance from orders.
# ----------------------------------------------------------------------------


def _of_gears(result: Result) -> Iterator[Verdict]:
    """No reversal of the torque of teeth: over the speeds, and at the operating one."""
    record = result.record
    factor, unit = torque_unit(record)
    loud = having(record, f"{TORSION}speeds/gear_hammers", "gear", "speed")
    here = having(record, f"{TORSION}gear/hammers", "gear")
    known = loud or here
    for place, name in enumerate(labels(known.axes[0]) if known else []):
        state = None
        for quantity, least, words in (
            (loud, "speeds/gear_minimum_torque", "any speed"),
            (here, "gear/minimum_torque", AT_SPEED),
        ):
            if quantity is None or (quantity is here and _covered(result, state)):
                continue
            hammers = np.atleast_1d(quantity.values[place])
            torque = record.quantities.get(TORSION + least)
            lows = -1.0 * hammers if torque is None else np.atleast_1d(torque.values[place])
            k = int(np.argmin(lows))
            curve = torque or quantity
            speed = speed_of(result) if quantity is here else float(curve.axes[1].values[k])
            state = BROKEN if np.any(hammers) else KEPT
            low, off = factor * float(lows[k]), factor * (torque.error_estimate if torque else 0.0)
            yield Verdict(
                quantity.path, {"gear": name}, "sign of the torque of the teeth", 0.0, None,
                unit if torque else "", low, f"gear={name}", Estimate(off, 0.0), low, state,
                element=name, limit=f"no reversal of the torque, {words}", status="informative",
                speed=np.nan if speed is None else speed,
            )  # fmt: skip


def _separated(result: Result) -> Iterator[Verdict]:
    """Distance of the natural frequencies from orders of the operating speed, by a rule."""
    record, rule = result.record, separation_rule(result)
    stem = f"{TORSION}separation/operating"
    margin, order, enough = (
        having(record, f"{stem}/{name}", "mode", "order_class")
        for name in ("margin", "half_order", "sufficient")
    )
    if rule is None or margin is None or order is None or enough is None:
        return
    named, classes = mode_names(result), labels(margin.axes[1])
    for i, k in np.argwhere(np.isfinite(margin.values) & (np.asarray(order.values) > 0.0)):
        required = 100.0 * rule.margin.get(float(order.values[i, k]), 0.0)
        if not required:
            continue
        away = 100.0 * float(margin.values[i, k])
        where: Where = {"mode": int(i) + 1, "order_class": classes[k]}
        yield Verdict(
            f"{stem}/sufficient", where, f"{rule.rule.name}, {rule.rule.edition}", required, None,
            "%", away, "", Estimate(100.0 * margin.error_estimate, 0.0), away - required,
            KEPT if enough.values[i, k] else BROKEN, element=f"{named[i]} mode",
            limit=f"distance from order {order_text(order.values[i, k])}",
            status=rule.rule.status, speed=speed_of(result) or np.nan,
        )  # fmt: skip
