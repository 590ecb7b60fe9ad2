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
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import state_of, verdicts_of
from vibecalc.torsion.coupling_results import COUPLING, HEALTHY
from vibecalc.torsion.curve_results import CONDITIONS
from vibecalc.torsion.report.couplings import LIMIT_WORDS, borne, permitted
from vibecalc.torsion.report.limits import (
    by_section,
    exceeded_rows,
    held_sections,
    limited_sections,
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
_ALL_FIRE = "all cylinders fire"


def limit_verdicts(result: Result) -> Iterator[Verdict]:
    """Every limit of the line that was computed.

    What holds at all speeds of the range has no row of its own for the operating speed within it.
    """
    silent: Any = asked(result).get("misfire") or ()
    words = f"misfire of cylinder {joined(map(str, silent))}" if silent else ""
    for part in (_by_rules, _of_couplings, _of_gears, _separated, _of_conditions):
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


def _row(
    result: Result,
    path: str,
    where: dict[str, int | float | str],
    element: str,
    limit: str,
    source: str,
    status: str,
    share: float,
    speed: float | None,
    **more: Any,
) -> Verdict:
    """A row of a use, whose error is that of its quantity: the whole of it is 1."""
    quantity = result.record[path]
    state = state_of(1.0 - share, quantity.error_estimate, 1.0)
    row = Verdict(
        quantity=path,
        where=where,
        source=source,
        min=None,
        max=1.0,
        unit="",
        computed=share,
        label=", ".join(f"{axis}={entry}" for axis, entry in where.items()),
        error_estimate=Estimate(quantity.error_estimate, 0.0),
        margin=1.0 - share,
        state=state,
        decided_by=remedy(quantity, result.case) if state == UNDECIDED else "",
        element=element,
        limit=limit,
        status=status,
        use=share,
        speed=np.nan if speed is None else speed,
    )
    return row._replace(**more)


def _in_unit(row: Verdict, allowed: float | None, computed: float | None, unit: str) -> Verdict:
    """The row with its numbers in place of the use, where they are known and belong to it."""
    if allowed is None or computed is None or not np.isfinite(allowed) or not allowed > 0.0:
        return row
    margin = allowed - computed
    if (margin > 0.0) != (row.use < 1.0):  # a torque that counts by its frequency
        margin = allowed * row.margin
    error = Estimate(row.error_estimate * allowed, 0.0)
    return row._replace(
        max=allowed, computed=computed, margin=margin, unit=unit, error_estimate=error
    )


def _covered(result: Result, state: str | None) -> bool:
    """Whether the operating speed lies in a range of speeds over which a limit is kept."""
    low, high = speed_range(result)
    speed = speed_of(result)
    return state == KEPT and speed is not None and low <= speed <= high


# ----------------------------------------------------------------------------
# Limits of stress and torque by rules and tables, of the line as it is and in conditions.
# ----------------------------------------------------------------------------


def _by_rules(result: Result) -> Iterator[Verdict]:
    """Continuous running over the range and at the operating speed, passing through."""
    record = result.record
    applies, named = held_sections(record), limited_sections(record)
    if applies is None or not named:
        return
    torques = of_torque(record)
    for i, j in np.argwhere(applies):
        of = "torque" if torques[i] else "stress"
        prefix = "torque_" if torques[i] else ""
        factor, unit = torque_unit(record) if torques[i] else (MEGA, "N/mm^2")
        at = by_section(record, "each/speed")
        found = None
        for kind, use, load, allowed in (
            (CONTINUOUS, "each/use", f"each/{of}", f"each/{prefix}allowed"),
            (PASSING, "each/transient_use", f"each/{of}", f"each/{prefix}transient"),
            (AT_SPEED, "operating/use", f"operating/{of}", f"operating/{prefix}allowed"),
        ):
            uses = by_section(record, use)
            if uses is None or not uses[i, j] > 0.0:
                continue
            speed = None if at is None or not at[i, j] else float(at[i, j])
            if kind == AT_SPEED:
                speed = speed_of(result)
                if _covered(result, found):
                    continue
            share = float(uses[i, j])
            where: dict[str, int | float | str] = {"limit": int(i) + 1, "section": named[j]}
            row = _row(result, f"{TORSION}limit/{use}", where, named[j], f"{of}, {kind}",
                       *_rule(result, int(i)), share, speed)  # fmt: skip
            both = (by_section(record, allowed), by_section(record, load))
            there, size = (None if one is None else factor * float(one[i, j]) for one in both)
            if there and size and np.isfinite(share) and abs(size / there - share) <= 1e-6 * share:
                row = _in_unit(row, there, size, unit)
            elif kind == PASSING:  # the largest stress stands elsewhere
                row = row._replace(speed=np.nan)
            if kind == CONTINUOUS:
                found = row.state
                row = row._replace(state=_barred(record, int(i), int(j), row.state))
            yield row


def _rule(result: Result, place: int) -> tuple[str, str]:
    """Number and rule with its edition, and whether it is informative or the case's own."""
    limit = limits_of(result)[place]
    rule = rule_of(limit)
    words = f"{place + 1}: {rule.name}"
    return (f"{words}, {rule.edition}", rule.status) if limit.get("rule") else (words, "case")


def _barred(record: Record, i: int, j: int, state: str) -> str:
    """The state in continuous running: exceeded only where a range may be barred is kept.

    No range may be that has the operating speed in it.
    """
    use = record.quantities.get(f"{TORSION}limit/operating/use")
    ranges = [one for one in exceeded_rows(record) if one.limit == i + 1]
    may = bool(ranges) and all(one.permitted for one in ranges)
    here = use is not None and state_of(1.0 - use.values[i, j], use.error_estimate, 1.0) != KEPT
    return BARRED if state == BROKEN and may and not here else state


def _of_conditions(result: Result) -> Iterator[Verdict]:
    """The largest use of each limit with all cylinders firing, and in the worst condition.

    What exceeds a limit for continuous running is broken where no range may be barred, else
    undecided: no ranges are looked for in a condition.
    """
    record, rated = result.record, vector(result.record, "limit/basis/rated_speed", "limit")
    for stem in (f"{TORSION}healthy", CONDITIONS):
        paths = [f"{stem}/limit/{name}" for name in ("largest_use", "operating_use", "speed")]
        most, here, at = (_by_condition(record, path) for path in paths)
        known = most or here
        for i in range(0 if known is None else known[1].shape[1]):
            where: dict[str, int | float | str] = {"limit": i + 1}
            names = (f"limit {i + 1}, its worst element", *_rule(result, i))
            state = None
            if most is not None:
                c = int(np.argmax(most[1][:, i]))
                speed = None if at is None else float(at[1][c, i])
                share, words = float(most[1][c, i]), _worst_of(most[0], c)
                row = _row(result, paths[0], where, names[0], CONTINUOUS, *names[1:], share, speed,
                           condition=words)  # fmt: skip
                top = 0.0 if rated is None else NO_BARRED_RANGE * rated[i]
                never = here is not None and here[1][c, i] > 1.0
                if row.state == BROKEN and not (never or (speed is not None and 0 < top <= speed)):
                    decided_by = "a case of that condition, which looks for ranges to bar,"
                    row = row._replace(state=UNDECIDED, decided_by=decided_by)
                state = row.state
                yield row
            if here is not None and not _covered(result, state):
                c = int(np.argmax(here[1][:, i]))
                yield _row(result, paths[1], where, names[0], AT_SPEED, *names[1:],
                           float(here[1][c, i]), speed_of(result),
                           condition=_worst_of(here[0], c))  # fmt: skip


def _by_condition(record: Record, path: str) -> tuple[list[str], np.ndarray] | None:
    """Names (c,) of conditions and values (c, ...) of a result; one where all cylinders fire."""
    quantity = record.quantities.get(path)
    if quantity is None:
        return None
    values = np.asarray(quantity.values, dtype=float)
    if quantity.axes[0].name == "condition":
        return labels(quantity.axes[0]), values
    return [_ALL_FIRE], values[None]


def _worst_of(names: list[str], place: int) -> str:
    return names[place] + f", worst of {len(names)}" * (len(names) > 1)


# ----------------------------------------------------------------------------
# Couplings, gears, distance from orders.
# ----------------------------------------------------------------------------


def _of_couplings(result: Result) -> Iterator[Verdict]:
    """What the maker permits, over the speeds and at the operating one, in the worst condition."""
    from vibecalc.torsion.couplings import LIMITS, has_limit

    record, line = result.record, line_of(result)
    if line is None:
        return
    for stem in (COUPLING, HEALTHY, f"{CONDITIONS}/coupling"):
        paths = [f"{stem}/{name}" for name in ("largest_use", "use", "largest_use_speed")]
        most, here, at = (record.quantities.get(path) for path in paths)
        known = most or here
        if known is None:
            continue
        named = [axis for axis in known.axes if axis.name == "coupling_limit"]
        for place, one in enumerate(line.couplings):
            said = dict(zip(LIMITS, has_limit(one), strict=True))
            source = (one.type or "values of the case", "maker" if one.type else "case")
            for k, name in enumerate(labels(named[0])):
                if not said[name]:
                    continue
                words = LIMIT_WORDS[name]
                if words.startswith(" "):  # another reading of the line above it
                    words = f"{LIMIT_WORDS['T_KW']}, by orders"
                allowed, unit = permitted(one, name)
                where: dict[str, int | float | str] = {"coupling": one.name, "coupling_limit": name}
                state = None
                for quantity, path in ((most, paths[0]), (here, paths[1])):
                    if quantity is None or (quantity is here and _covered(result, state)):
                        continue
                    condition, speed = "", speed_of(result)
                    shares = np.asarray(quantity.values, dtype=float)[..., place, k]
                    c = int(np.argmax(shares))
                    if stem == HEALTHY:
                        condition = _ALL_FIRE
                    elif stem != COUPLING:
                        condition = _worst_of(labels(quantity.axes[0]), c)
                    if quantity is most and at is not None:
                        speed = float(np.ravel(at.values[..., place, k])[c])
                    row = _row(result, path, where, one.name, words, *source,
                               float(np.ravel(shares)[c]), speed, condition=condition)  # fmt: skip
                    state = row.state
                    load = None
                    if stem == COUPLING:
                        load = borne(result, name, place, None if quantity is here else speed)
                    yield _in_unit(row, allowed, load, unit)


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
            row = _row(result, quantity.path, {"gear": name}, name,
                       f"no reversal of the torque, {words}", "sign of the torque of the teeth",
                       "informative", np.nan, speed)  # fmt: skip
            state = BROKEN if np.any(hammers) else KEPT
            low, off = factor * float(lows[k]), factor * (torque.error_estimate if torque else 0.0)
            yield row._replace(
                min=0.0, max=None, computed=low, margin=low, error_estimate=Estimate(off, 0.0),
                unit=unit if torque else "", state=state, decided_by="",
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
        row = _row(result, f"{stem}/sufficient", {"mode": int(i) + 1, "order_class": classes[k]},
                   f"{named[i]} mode", f"distance from order {order_text(order.values[i, k])}",
                   f"{rule.rule.name}, {rule.rule.edition}", rule.rule.status, np.nan,
                   speed_of(result))  # fmt: skip
        yield row._replace(
            min=required, max=None, computed=away, margin=away - required, unit="%",
            error_estimate=Estimate(100.0 * margin.error_estimate, 0.0),
            state=KEPT if enough.values[i, k] else BROKEN, decided_by="",
        )  # fmt: skip
