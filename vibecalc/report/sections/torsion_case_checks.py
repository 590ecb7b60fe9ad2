"""Rows of the first table on a shaft line: frequencies and their separation, limits, gears."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import hertz, rpm, show
from vibecalc.report.sections.torsion_limits import (
    BROKEN,
    barred_ranges,
    has_limits,
    limits_of,
    rule_of,
    verdicts,
)
from vibecalc.report.sections.torsion_scenes import (
    ABOVE,
    ANY,
    BARE,
    CLOSE,
    HAMMER,
    OPERATING,
    Row,
    Scene,
    bound_of,
)
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    asked,
    elastic_modes,
    joined,
    names,
    order_text,
    turns,
    vector,
)
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from vibecalc.hardware.shaft_rules import Separation as SeparationRule

_GEARS = "gears that hammer"


def frequencies(result: Result, columns: list[Scene]) -> Iterator[Row]:
    record = result.record
    natural = having(record, TORSION + "modes/natural_frequency", "mode")
    modes = elastic_modes(result)
    if natural is None or not modes:
        return
    first, error = float(natural.values[modes[0]]), natural.error_estimate
    text = show(hertz(first), hertz(error))
    value = {scene.prefix: text for scene in columns if scene.prefix != BARE}
    where = {columns[0].prefix: (f"mode {modes[0] + 1}", f"{show(rpm(first), digits=5)} cpm")}
    bare = vector(record, BARE + "natural_frequency", "bare_mode")
    if bare is not None and np.any(bare > 0.0):
        lowest = int(np.flatnonzero(bare > 0.0)[0])
        value[BARE] = show(hertz(bare[lowest]))
        where[BARE] = (f"its mode {lowest + 1}", f"{show(rpm(bare[lowest]), digits=5)} cpm")
    yield Row("lowest natural frequency", "Hz", value, where=where)
    yield from _separations(result, modes, columns)


class Separation(NamedTuple):
    """The mode next to an order of a class; `required` 0 where no rule asks anything of it."""

    kind: str
    mode: int
    order: float
    margin: float
    required: float
    close: bool


def separation_rule(result: Result) -> "SeparationRule | None":
    """The rule for the margins that the case names."""
    from vibecalc.hardware.shaft_rules import SEPARATIONS

    return SEPARATIONS.get(str(asked(result).get("separation") or ""))


def separations(result: Result, modes: list[int]) -> Iterator[Separation]:
    """The mode next to an order of each class at the operating speed, first one that is close."""
    record, rule = result.record, separation_rule(result)
    margin, order, kept = (
        having(record, f"{TORSION}separation/{OPERATING}/{name}", "mode", "order_class")
        for name in ("margin", "half_order", "kept")
    )
    if margin is None or order is None:
        return
    for place, kind in enumerate(labels(margin.axes[1])):
        away = np.asarray(margin.values, dtype=float)[:, place]
        counts = [mode for mode in modes if np.isfinite(away[mode]) and order.values[mode, place]]
        close = [] if kept is None else [mode for mode in counts if not kept.values[mode, place]]
        if not counts:
            continue
        least = min(close or counts, key=lambda mode: float(away[mode]))
        met = float(order.values[least, place])
        required = 0.0 if rule is None else rule.margin.get(met, 0.0)
        yield Separation(kind, least, met, float(away[least]), required, bool(close))


def _separations(result: Result, modes: list[int], columns: list[Scene]) -> Iterator[Row]:
    first, asks = columns[0].prefix, separation_rule(result)
    for row in separations(result, modes):
        text = f"{100.0 * row.margin:.1f}"
        rule = f"; {asks.rule.name}, informative" if asks is not None and row.required else ""
        yield Row(
            f"margin to {row.kind} order, {OPERATING}", "%",
            {scene.prefix: text for scene in columns if scene.prefix != BARE},
            f"min {100.0 * row.required:g}" if row.required else "",
            "" if not row.required else CLOSE if row.close else "kept",
            {first: (f"mode {row.mode + 1}", f"order {order_text(row.order)}{rule}")},
        )  # fmt: skip


def stress_limits(result: Result, columns: list[Scene]) -> Iterator[Row]:
    """A row for each limit of the stress: use, at any speed and at the operating one."""
    record = result.record
    if not has_limits(record):
        return
    given = limits_of(result)
    flags = verdicts(record)
    section, speed = (vector(record, f"limit/{name}", "limit") for name in ("section", "speed"))
    known = names(record, "torque_half_range", "section")
    for i, word in enumerate(flags):
        name = rule_of(given[i]).name if i < len(given) else ""
        for way, path in ((ANY, "limit/largest_use"), (OPERATING, "limit/operating_use")):
            uses = {
                scene.prefix: float(use[i])
                for scene in columns
                if (use := vector(record, scene.prefix + path, "limit")) is not None
                and i < use.size
            }
            if not uses:
                continue
            flag = word if way == ANY else "kept" if uses.get("", 0.0) <= 1.0 else BROKEN
            value = {
                prefix: show(100.0 * use, digits=4) + (ABOVE if prefix and use > 1.0 else "")
                for prefix, use in uses.items()
            }
            at = OPERATING
            place = -1
            if way == ANY and speed is not None and section is not None:
                at, place = f"{turns(speed[i])} rpm", int(section[i]) - 1
            where = (known[place] if 0 <= place < len(known) else "", f"{at}: {name}")
            yield Row(f"stress over limit {i + 1}, {way}", "%", value, "100", flag, {"": where})
    barred = barred_ranges(record)
    ends = "\n".join(barred)
    yield Row("barred ranges", "", {"": str(len(barred))}, where={"": ("", ends)} if ends else {})


def gears(result: Result, columns: list[Scene]) -> Iterator[Row]:
    """Gears whose torque reverses, at the operating speed and at any speed."""
    record = result.record
    for way, path, found in ((OPERATING, "gear/hammers", hammering(record)),
                             (ANY, "speeds/gear_hammers", hammering_at(record))):  # fmt: skip
        if found is None:
            continue
        loud = [name for name, at in found if at]
        _, flag, _ = bound_of(result, TORSION + path, 1.0)
        flag = flag or (HAMMER if loud else "kept")
        where = {"": (joined(loud), "\n".join(at for _, at in found if at))} if loud else {}
        yield Row(f"{_GEARS}, {way}", "", {"": str(len(loud))}, "0", flag, where)


def hammering(record: Record) -> list[tuple[str, str]] | None:
    """Each gear, and where its torque reverses at the operating speed ("" if it does not)."""
    found = vector(record, "gear/hammers", "gear")
    if found is None:
        return None
    return [
        (name, OPERATING if one else "")
        for name, one in zip(names(record, "gear/hammers", "gear"), found, strict=True)
    ]


def hammering_at(record: Record) -> list[tuple[str, str]] | None:
    """Each gear, and the ranges of speeds in which its torque reverses ("" if it does not)."""
    found = having(record, TORSION + "speeds/gear_hammers", "gear", "speed")
    if found is None:
        return None
    low, high, gear = (
        vector(record, f"hammering/{n}", "hammering") for n in ("from", "to", "gear")
    )
    told = []
    for place, name in enumerate(labels(found.axes[0])):
        loud = bool(np.any(np.asarray(found.values)[place]))
        ends = []
        if low is not None and high is not None and gear is not None:
            ends = [
                f"{turns(low[i])} to {turns(high[i])}" for i in np.flatnonzero(gear == place + 1)
            ]
        told.append((name, f"{joined(ends)} rpm" if ends else "somewhere" if loud else ""))
    return told
