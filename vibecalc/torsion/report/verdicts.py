"""Limits of a shaft line as rows: of rules, makers, gears, distance from orders, in conditions."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import having, labels, speed_of
from vibecalc.core.report.writing import read
from vibecalc.core.results.record import (
    BARRED,
    BROKEN,
    KEPT,
    UNDECIDED,
    Estimate,
    Quantity,
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import state_of, verdicts_of
from vibecalc.torsion.report.couplings import BORNE, borne, permitted
from vibecalc.torsion.report.limits import limits_of, of_torque, rule_of, separation_rule
from vibecalc.torsion.report.line import (
    MEGA,
    TORSION,
    every,
    joined,
    line_of,
    mode_names,
    names,
    order_text,
    silent,
    speed_range,
    torque_unit,
    vector,
)

CONTINUOUS, PASSING, AT_SPEED = "continuous", "passing through", "operating speed"
Where = dict[str, Any]


def limit_verdicts(result: Result) -> Iterator[Verdict]:
    """Every limit of the line that was computed.

    What holds at all speeds of the range has no row of its own for the operating speed within it.
    """
    words = f"misfire of cylinder {joined(ill)}" if (ill := silent(result)) else ""
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


class _Use(NamedTuple):
    """A use: `place` among the entries of its limits, in `condition` (from 0), and of what kind."""

    result: Result
    quantity: Quantity
    stem: str
    kind: str
    place: tuple[int, ...]
    where: Where
    condition: int
    share: float

    def entry(self, name: str) -> float | None:
        """The entry of another result of the same limits in the same condition, finite."""
        found = self.result.record.quantities.get(f"{TORSION}{self.stem}{name}")
        if found is None:
            return None
        value = float(_over_conditions(found, self.place)[self.condition])
        return value if np.isfinite(value) else None


def _by_use(result: Result) -> Iterator[Verdict]:
    """Continuous running over the range, passing through and at the operating speed."""
    for stem, paths in _USES.items():
        quantities = [result.record.quantities.get(f"{TORSION}{stem}{name}") for name in paths]
        known = next((one for one in quantities[:3] if one is not None), None)
        axes = [axis for axis in known.axes if axis.name != "condition"] if known else []
        for place in np.ndindex(*(len(axis.values) for axis in axes)) if axes else ():
            where: Where = {}
            for axis, k in zip(axes, place, strict=True):
                name = axis.values[k]
                where[axis.name] = int(name) if axis.name == "limit" else str(name)
            over = None
            for kind, quantity in zip((CONTINUOUS, PASSING, AT_SPEED), quantities[:3], strict=True):
                shares = np.zeros(1) if quantity is None else _over_conditions(quantity, place)
                worst = int(np.argmax(shares))
                covered = kind == AT_SPEED and _covered(result, over)
                if quantity is None or not shares[worst] > 0.0 or covered:
                    continue
                use = _Use(result, quantity, stem, kind, place, where, worst, float(shares[worst]))
                speed = speed_of(result) if kind == AT_SPEED else use.entry(paths[3])
                row = _row(use, np.nan if speed is None else speed)
                over = row.state if kind == CONTINUOUS else over
                yield row


def _over_conditions(quantity: Quantity, place: tuple[int, ...]) -> np.ndarray:
    """Entries (c,) at a place among all other axes; one where there are no conditions."""
    entry: Any = (..., *place)
    return np.ravel(quantity.values[entry])


def _condition(use: _Use) -> str:
    """The condition in words; none of the line as the case has it."""
    if "/" not in use.stem.rstrip("/"):
        return ""
    if use.quantity.axes[0].name != "condition":
        return "all cylinders fire"
    named = labels(use.quantity.axes[0])
    return named[use.condition] + f" (worst of {len(named)})" * (len(named) > 1)


def _row(use: _Use, speed: float) -> Verdict:
    """The row of a use, in the unit of what is borne where that is known."""
    quantity, share = use.quantity, use.share
    state = state_of(1.0 - share, quantity.error_estimate, 1.0)
    decided_by = remedy(quantity, use.result.case) if state == UNDECIDED else ""
    load_of = _coupling if "coupling" in use.where else _load
    words, allowed, load, unit = load_of(use, speed)
    if not load or not allowed or not 0.0 < allowed < np.inf:
        allowed, load, unit = 1.0, share, ""
    margin = allowed - load
    if (margin > 0.0) != (share < 1.0):  # a torque that counts by its frequency
        margin = allowed * (1.0 - share)
    if state == BROKEN and use.kind == CONTINUOUS and "limit" in use.where:
        state, decided_by = _where_barred(use)
    return Verdict(
        quantity=quantity.path,
        where=use.where,
        min=None,
        max=allowed,
        unit=unit,
        computed=load,
        label=", ".join(f"{axis}={one}" for axis, one in use.where.items()),
        error_estimate=Estimate(quantity.error_estimate * allowed, 0.0),
        margin=margin,
        state=state,
        decided_by=decided_by,
        use=share,
        # of the largest use, which may be another than that in passing through
        speed=np.nan if use.kind == PASSING and not unit else speed,
        condition=_condition(use),
        **words,
    )


def _where_barred(use: _Use) -> tuple[str, str]:
    """A limit that is exceeded is kept where that is only in ranges which may be barred."""
    if use.stem == "limit/":
        found = every(use.result.record, "exceeded", "exceeded", "limit", "permitted")
        limit, permitted_ = (one.values for one in found) if found else 2 * (np.zeros(0),)
        may = permitted_[limit == use.where["limit"]]
        unbarred = use.entry("operating/use") if may.size and may.all() else np.inf
    else:
        unbarred = use.entry("unbarred_use")
        if unbarred is None and not (use.entry("operating_use") or 0.0) > 1.0:
            return UNDECIDED, "another run"  # of an older file
        unbarred = np.inf if unbarred is None else unbarred
    return BROKEN if (unbarred or 0.0) > 1.0 else BARRED, ""


#: words of a row, what is allowed and what is borne in the unit that people read
_Read = tuple[dict[str, Any], float | None, float | None, str]


def _coupling(use: _Use, speed: float) -> _Read:
    line, limit, place = line_of(use.result), str(use.where["coupling_limit"]), use.place[0]
    one = None if line is None else line.couplings[place]
    words = BORNE[limit][1]
    if words.startswith(" "):  # another reading of the line above it
        words = f"{BORNE['T_KW'][1]}, by orders"
    source, status = (one.type, "maker") if one and one.type else ("values of the case", "case")
    told = {"element": use.where["coupling"], "limit": words, "source": source, "status": status}
    allowed, unit = (np.inf, "") if one is None else permitted(one, limit)
    load: float | None = use.share * allowed
    if use.stem == "coupling/" and limit != "n_max":
        at = speed if use.kind == CONTINUOUS and np.isfinite(speed) else None
        load = borne(use.result, limit, place, at)
    elif limit == "temperature":  # counts by its rise
        load = None
    return told, allowed, load, unit


def _load(use: _Use, _speed: float) -> _Read:
    """Of a section or gear, by a rule, a table or a share."""
    record, place, here = use.result.record, int(use.where["limit"]) - 1, use.kind == AT_SPEED
    limit, torques = limits_of(use.result)[place], of_torque(record)
    rule, of = rule_of(limit), "torque" if torques[place] else "stress"
    source, status = f"{place + 1}: {rule.name}", "case"
    if limit.get("rule"):
        source, status = f"{source}, {rule.edition}", rule.status
    prefix = "torque_" * (of == "torque")
    if use.stem == "limit/":
        at = "operating" if here else "each"
        element = str(use.where["section"])
        allowed = f"{at}/{prefix}{'transient' if use.kind == PASSING else 'allowed'}"
        load = use.entry(f"{at}/{of}")
    else:
        at = "operating_" * here
        number, allowed, load = use.entry(f"{at}element"), f"{at}{prefix}allowed", None
        known = names(record, "torque_mean", "section") + names(record, "gear/mean_torque", "gear")
        element = known[int(number) - 1] if number else f"limit {place + 1}"
    may = use.entry(allowed)
    load = use.share * may if may and load is None else load
    if may and load and abs(load / may - use.share) > 1e-6 * use.share:
        load = None  # the largest stress stands at another speed
    factor, unit = (MEGA, "N/mm^2") if of == "stress" else torque_unit(record)
    words = {"element": element, "limit": f"{of}, {use.kind}", "source": source, "status": status}
    return words, factor * (may or 0.0), factor * (load or 0.0), read(unit)


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
        for quantity, path, words in (
            (loud, "largest/gear_minimum_torque", "any speed"),
            (here, "gear/minimum_torque", AT_SPEED),
        ):
            if quantity is None or (quantity is here and _covered(result, state)):
                continue
            low, off, speed = _least(record, path, place)
            speed = speed_of(result) if quantity is here else speed
            parts = np.any(quantity.values[place]) or (quantity is loud and low < -off)
            state = BROKEN if parts else KEPT
            yield Verdict(
                quantity.path, {"gear": name}, "sign of the torque of the teeth", 0.0, None,
                read(unit) if np.isfinite(low) else "", factor * low, f"gear={name}",
                Estimate(factor * off, 0.0), factor * low, state, element=name,
                limit=f"no reversal of the torque, {words}", status="informative",
                speed=np.nan if speed is None else speed,
            )  # fmt: skip


def _least(record: Record, path: str, gear: int) -> tuple[float, float, float | None]:
    """The least torque of a gear with its error, and its speed over a range; NaN if not known."""
    found = having(record, TORSION + path, "gear")
    if found is not None:
        at = vector(record, f"{path}_speed", "gear")
        speed = None if at is None else float(at[gear])
        return float(found.values[gear]), found.error_estimate, speed
    curve = having(record, f"{TORSION}speeds/gear_minimum_torque", "gear", "speed")
    if curve is None or not path.startswith("largest"):
        return np.nan, 0.0, None
    k = int(np.argmin(curve.values[gear]))
    return float(curve.values[gear, k]), curve.error_estimate, float(curve.axes[1].values[k])


_SEPARATED = ("margin", "half_order", "sufficient")


def _separated(result: Result) -> Iterator[Verdict]:
    """Distance of the natural frequencies from orders of the operating speed, by a rule."""
    record, rule = result.record, separation_rule(result)
    stem = f"{TORSION}separation/operating"
    found = every(record, "separation/operating", "mode order_class", *_SEPARATED)
    if rule is None or not found:
        return
    margin, order, enough = found
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
