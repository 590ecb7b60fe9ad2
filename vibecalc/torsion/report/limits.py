"""Limits of a shaft line: what it bears by them, ranges that they bar, a row for each verdict."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.sections import having, labels, speed_of, stacked
from vibecalc.core.report.writing import (
    Column,
    number,
    pairs,
    paragraph,
    read,
    short,
    show,
    table,
    turns,
)
from vibecalc.core.results.record import (
    BARRED,
    BROKEN,
    KEPT,
    UNDECIDED,
    WORST_FIRST,
    Estimate,
    Quantity,
    Record,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import Bound, state_of, verdicts_of
from vibecalc.numerics.rounding import first_of_largest
from vibecalc.torsion.report.couplings import BORNE, ICE, borne, permitted
from vibecalc.torsion.report.gears import AT_SPEED, covered, in_conditions, in_transient, of_gears
from vibecalc.torsion.report.line import (
    MEGA,
    TORSION,
    asked,
    every,
    joined,
    line_of,
    mode_names,
    names,
    order_text,
    place_of,
    silent,
    torque_unit,
    vector,
)
from vibecalc.units import convert

if TYPE_CHECKING:
    from vibecalc.torsion.stress_limits import Rule
    from vibecalc.torsion.stress_limits import Separation as SeparationRule

# ----------------------------------------------------------------------------
# Limits of stress and torque in a shaft line, where they come from, the ranges that they bar.
# ----------------------------------------------------------------------------

_LIMIT = TORSION + "limit/"


def most_used(record: Record, place: int, _path: str) -> str | None:
    """The shaft or gear in which a limit has its largest utilisation at any speed."""
    return _most_used(record, "each", place)


def most_used_at_speed(record: Record, place: int, _path: str) -> str | None:
    """The same at the operating speed."""
    return _most_used(record, "operating", place)


def _most_used(record: Record, when: str, place: int) -> str | None:
    of = having(record, f"{_LIMIT}{when}/utilisation", "limit", "section")
    if of is None or np.all(np.isnan(of.values[place])):
        return None
    return labels(of.axes[1])[int(np.nanargmax(of.values[place]))]


def most_used_in_condition(record: Record, place: int, path: str) -> str | None:
    """The same of a condition and a limit, with the condition."""
    start = "operating_" if "/operating_" in path else ""
    of = having(record, f"{TORSION}conditions/limit/{start}element", "condition", "limit")
    number = 0 if of is None else int(np.ravel(of.values)[place])
    if of is None or not number:
        return None
    condition = labels(of.axes[0])[place // len(of.axes[1].values)]
    return f"{_loaded(record)[number - 1]}, {condition}"


def most_stressed_in_condition(record: Record, place: int, _path: str) -> str | None:
    """The section of the largest stress in any condition, with the condition."""
    stress = having(record, f"{TORSION}conditions/largest/stress_half_range", "section")
    number = having(record, f"{TORSION}conditions/largest/section_condition", "section")
    known = names(record, "conditions/torque_half_range", "condition")
    if stress is None or number is None or not known:
        return None
    section = labels(stress.axes[0])[place]
    at = place_of(number, section)
    condition = "" if at is None else known[int(number.values[at]) - 1]
    return ", ".join(filter(None, (section, condition)))


def _loaded(record: Record) -> list[str]:
    """Sections and gears, as the elements of conditions are counted."""
    return names(record, "torque_mean", "section") + names(record, "gear/mean_torque", "gear")


def rule_of(limit: Mapping[str, Any]) -> "Rule":
    """The rule of a limit of the case, with edition and scope."""
    from vibecalc.torsion.stress_limits import ALTERNATING_SHARE, M53, M68, TORQUE_TABLE, USER_TABLE

    for key, rule in (("alternating_share", ALTERNATING_SHARE), ("torque", TORQUE_TABLE)):
        if limit.get(key):
            return rule
    return {"iacs_m68": M68, "iacs_m53": M53}.get(str(limit.get("rule")), USER_TABLE)


def separation_rule(result: Result) -> "SeparationRule | None":
    """The rule for the margins that the case names."""
    from vibecalc.torsion.stress_limits import SEPARATIONS

    return SEPARATIONS.get(str(asked(result).get("separation") or ""))


def of_torque(record: Record) -> np.ndarray:
    """Which limits are of the torque, by what they allow at the operating speed or over speeds."""
    for path, axis in (("operating/torque_allowed", "section"), ("torque_allowed", "speed")):
        found = having(record, _LIMIT + path, "limit", axis)
        if found is not None:
            values = np.asarray(found.values, dtype=float)
            there = values > 0.0 if axis == "section" else np.isfinite(values)
            return np.asarray(np.any(there, axis=1))
    count = vector(record, "limit/operating_utilisation", "limit")
    return np.zeros(0 if count is None else count.size, bool)


def limited_words(record: Record, between: str = "and", some: Collection[int] | None = None) -> str:
    """What limits are of: `stress`, `torque` or both; of `some`, counted from 0, or all."""
    kinds = of_torque(record)
    chosen = kinds if some is None else kinds[[one for one in some if one < kinds.size]]
    if not np.any(chosen):
        return "stress"
    return "torque" if np.all(chosen) else f"stress {between} torque"


def limits_of(result: Result) -> list[Mapping[str, Any]]:
    """`response.torsion.limits` of the case."""
    return list(asked(result).get("limits") or ())


def origins(result: Result) -> list[str]:
    """What each limit is: rule, edition, sections, scope."""
    return stacked(*(pairs(_origin(i, limit)) for i, limit in enumerate(limits_of(result), 1)))


def _origin(place: int, limit: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    rule, kind, share = rule_of(limit), limit.get("rule"), limit.get("alternating_share")
    yield f"limit {place}", f"{rule.name}, {rule.edition} ({rule.status})"
    sections, gears = (", ".join(map(str, limit.get(key) or ())) for key in ("sections", "gears"))
    if sections or not (gears or share):
        of = "throw" if kind == "iacs_m53" else "section modulus"
        yield "  sections", sections or f"all with a {of}"
    if gears or share:
        yield "  gears", gears or "all"
    if share:
        yield "  alternating share", f"{float(share):g}"
    elif not kind:
        yield "  scope", "set by the case, over the speeds of its table"
        return
    yield from (("  scope", rule.scope), ("  not for", rule.not_for), ("  measure", rule.measure))
    if strength := limit.get("tensile_strength"):
        yield "  tensile strength", f"{show(1e-6 * float(strength), digits=4)} N/mm^2"
    if kind == "iacs_m53":
        yield "  crankshaft", str(limit.get("crankshaft_kind") or "free_form")
    elif limit.get("shaft_kind"):
        yield "  shaft", str(limit["shaft_kind"])
    elif kind:
        yield "  design factor c_K", f"{float(limit.get('design_factor') or 1.0):g}"


def has_limits(record: Record) -> bool:
    """Whether stress or torque of the line is held against a limit."""
    return f"{TORSION}limit/largest_utilisation" in record


# ----------------------------------------------------------------------------
# What each section and gear of a shaft line bears, and may bear, by each limit.
# ----------------------------------------------------------------------------


def formulas(result: Result) -> list[str]:
    """What the rules of the case allow and bar."""
    rules = {limit.get("rule") for limit in limits_of(result)}
    return [line for rule, words in _FORMULAS if rule in rules for line in paragraph(words)]


_FORMULAS = (
    (
        "iacs_m53",
        "Allowed stress of a crank pin by UR M53: the nominal torsional stress at which the "
        "fatigue strength sigma_DW is 1.15 times the equivalent stress sigma_v at the worst "
        "place. Fillets: sigma_v^2 = (sigma_B + sigma_add)^2 + 3 tau^2; oil bore: sigma_v = "
        "sigma_B / 3 (1 + 2 sqrt(1 + 9/4 (sigma_T / sigma_B)^2)); each stress with its "
        "concentration factor. Bending stresses: from the case.",
    ),
    (
        "iacs_m68",
        "Allowed stress by the rule: tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2), with "
        "1.38 instead of the bracket for lambda >= 0.9; tau_T = 1.7 tau_C / sqrt(c_K) for "
        "passage; c_D = 0.35 + 0.93 d^-0.2; lambda: speed / rated speed (the operating speed). "
        "Stresses in N/mm^2, d in mm. Barred range: 16 n / (18 - lambda) to (18 - lambda) n / 16 "
        "about the speed n of highest utilisation, extended to wherever the limit is exceeded; "
        "by a table of the case: only where the limit is exceeded.",
    ),
)

#: path below the limits, title, unit, and what writes a value in that unit, "" or "-" for none
_Column = tuple[str, str, str, Callable[[float], str]]


def _if_there(write: Callable[[float], str], none: str = "-") -> Callable[[float], str]:
    """What writes a value, and something else for zero, which stands for none."""
    return lambda value: write(value) if value else none


_plain, _known, _speed = _if_there(short, ""), _if_there(short), _if_there(turns)


def _use(value: float) -> str:
    """In percent; `above` what is held against no finite number."""
    text = show(100.0 * value, digits=4) if np.isfinite(value) else "above"
    return text if value else "-"


def _load(value: float) -> str:
    return show(value, digits=4) if value and np.isfinite(value) else "-"


def _endless(value: float) -> str:
    """A load, which a damping of nothing lets grow without end."""
    return _load(value) if np.isfinite(value) else "unbounded"


def _by_limit(
    record: Record, of: Quantity, there: np.ndarray, columns: Iterable[_Column]
) -> list[str]:
    """A row for each entry of a quantity over limits, sections (and places) that is `there`."""
    axes = [axis.name for axis in of.axes]
    named, rows = [labels(axis) for axis in of.axes[1:]], list[list[str]]()
    known = [
        (having(record, _LIMIT + path, *axes) or having(record, _LIMIT + path, "limit"), unit, how)
        for path, _, unit, how in columns
    ]
    for i, *place in np.argwhere(there).tolist():
        row = [str(i + 1), *(own[j] for own, j in zip(named, place, strict=True))]
        for one, unit, write in known:
            factor = convert(1.0, one.unit, unit) if one is not None and unit else 1.0
            at = (i, *place)[: one.values.ndim] if one is not None else ()
            row.append("" if one is None else write(factor * float(one.values[at])))
        rows.append(row)
    heads = [number("limit"), *(Column(name.rpartition("_")[2]) for name in axes[1:])]
    return table([*heads, *(number(title) for _, title, *_ in columns)], rows)


def _held(record: Record) -> tuple[Quantity, np.ndarray] | None:
    """Which sections a limit is for: a diameter in its basis, or a torque that it allows."""
    parts = [
        one
        for name in ("basis/diameter", "operating/torque_allowed")
        if (one := having(record, _LIMIT + name, "limit", "section")) is not None
    ]
    return (parts[0], np.any([one.values > 0.0 for one in parts], axis=0)) if parts else None


_BASIS: tuple[_Column, ...] = (
    ("basis/diameter", "diameter\nmm", "mm", _plain),
    ("basis/tensile_strength", "sigma_B\nN/mm^2", "N/mm^2", _plain),
    ("basis/counted_strength", "as used\nN/mm^2", "N/mm^2", _plain),
    ("basis/design_factor", "c_K", "", _plain),
    ("basis/size_factor", "c_D", "", _plain),
    ("basis/rated_speed", "rated speed\nrpm", "", turns),
)


def basis(result: Result) -> list[str]:
    """Diameter, strength and factors behind the rule of each section."""
    record = result.record
    factor = having(record, f"{_LIMIT}basis/design_factor", "limit", "section")
    held, rated = _held(record), vector(record, "limit/basis/rated_speed", "limit")
    if held is None or rated is None or factor is None:
        return []
    return _by_limit(record, held[0], held[1] & (factor.values > 0.0) & (rated[:, None] > 0.0),
                     _BASIS)  # fmt: skip


def uses_by_section(result: Result) -> list[str]:
    """Stress, what is allowed, and use of each section: where the use is largest, and operating.

    Then the same of torques.
    """
    record, given = result.record, limits_of(result)
    held, torques = _held(record), of_torque(record)
    blocks = []
    for name, prefix, unit in (("stress", "", "N/mm^2"), ("torque", "torque_", "N*m")):
        chosen = torques == (name == "torque")
        columns: tuple[_Column, ...] = (
            ("each/speed", "worst at\nrpm", "", _speed),
            (f"each/{name}", name, unit, _endless),
            (f"each/{prefix}allowed", "allowed\ncontin.", unit, _load),
            ("each/utilisation", "util.\n%", "", _use),
            (f"each/{prefix}transient", "allowed\npassage", unit, _load),
            ("each/passage_utilisation", "util.\n%", "", _use),
            (f"operating/{name}", f"operating\n{name}", unit, _load),
            (f"operating/{prefix}allowed", "allowed\ncontin.", unit, _load),
            ("operating/utilisation", "util.\n%", "", _use),
        )
        there = held[1] & chosen[:, None] if held else np.zeros((0, 0), bool)
        if held is None or not there.any():
            continue
        some = np.flatnonzero(there.any(axis=1)).tolist()
        rules = {i + 1: rule_of(given[i]).name for i in some}
        listed = "; ".join(
            f"{numbered([i for i, one in rules.items() if one == rule])}: {rule}"
            for rule in dict.fromkeys(rules.values())
        )
        words = f"Half ranges of the {name} in {unit}. {listed[:1].upper()}{listed[1:]}."
        if any(given[i].get("rule") for i in some):
            words += " Rules are informative: the class society's current edition applies."
        use = having(record, f"{_LIMIT}each/utilisation", "limit", "section")
        most = 0.0 if use is None else float(np.max(use.values[there]))
        blocks.append((most, [*_by_limit(record, held[0], there, columns), *paragraph(words)]))
    # what is used most comes first
    return stacked(*(block for _, block in sorted(blocks, key=lambda one: -one[0])))


def numbered(limits: Collection[int]) -> str:
    """`limit 2`, `limits 2 and 3`."""
    return f"limit{'s' * (len(limits) > 1)} {joined(map(str, limits))}"


_CRANK: tuple[_Column, ...] = (
    ("crank/bending_factor", "factor in\nbending", "", _known),
    ("crank/torsion_factor", "factor in\ntorsion", "", _known),
    ("crank/bending_stress", "bending\nN/mm^2", "N/mm^2", _known),
    ("crank/fatigue_strength", "sigma_DW\nN/mm^2", "N/mm^2", _known),
    ("crank/acceptability", "worst\nQ", "", _known),
    ("crank/operating_acceptability", "operating\nQ", "", _known),
)


def crank_places(result: Result) -> list[str]:
    """Acceptability of each place of the throws that the rule for crankshafts is held against."""
    record = result.record
    for strength in every(record, "limit/crank", "limit section crank_place", "fatigue_strength"):
        words = "Crankshafts by IACS UR M53: Q = sigma_DW / sigma_v must be at least 1.15."
        lines = _by_limit(record, strength, strength.values > 0.0, _CRANK)
        return [*paragraph(words), *lines]
    return []


CONTINUOUS, PASSING = "continuous", "passing through"
Where = dict[str, Any]


def limit_verdicts(result: Result) -> Iterator[Verdict]:
    """Every limit of the line that was computed.

    What holds at all speeds of the range has no row of its own for the operating speed within it.
    """
    words = f"misfire of cylinder {joined(ill)}" if (ill := silent(result)) else ""
    for part in (_by_use, of_gears, in_conditions, _separated):
        for row in part(result):
            yield row if row.condition else row._replace(condition=words)
    for row in in_transient(result):
        yield row._replace(condition=", ".join(filter(None, (row.condition, words))))


#: the worst first, as tables flag them
FLAGS = {one: one if one in (BARRED, KEPT) else one.upper() for one in WORST_FIRST}


def flags(result: Result, *kinds: str) -> list[str]:
    """The worst verdict on each limit of stress or torque, of all `kinds` or of some."""
    states: dict[Any, set[str]] = {}
    for row in verdicts_of(result):
        of = row.limit.rpartition(", ")[2]
        if row.element and row.quantity.startswith(f"{TORSION}limit/") and of in (kinds or (of,)):
            states.setdefault(row.where["limit"], set()).add(row.state)
    every = range(1, len(limits_of(result)) + 1)
    return [next(FLAGS[one] for one in FLAGS if one in states.get(i, {KEPT})) for i in every]


# ----------------------------------------------------------------------------
# Uses of limits by rules, tables and makers: of the line as it is, and of the worst condition.
# ----------------------------------------------------------------------------

_LARGEST = ("largest_utilisation", "", "operating_utilisation", "speed")
_COUPLING = ("largest_utilisation", "", "utilisation", "largest_utilisation_speed")
#: uses over the speeds, in passing through and at the operating speed, and the speeds of the first
_USES = {
    "limit/": (
        "each/utilisation",
        "each/passage_utilisation",
        "operating/utilisation",
        "each/speed",
    ),
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
                worst = first_of_largest(shares)
                held = kind == AT_SPEED and covered(result, over)
                if quantity is None or not shares[worst] > 0.0 or held:
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
    worst = f" (worst of {len(named)} conditions)" * (len(named) > 1)
    return named[use.condition] + worst


def _row(use: _Use, speed: float) -> Verdict:
    """The row of a use, in the unit of what is borne where that is known."""
    quantity, share = use.quantity, use.share
    state = state_of(1.0 - share, quantity.error_estimate, 1.0)
    decided_by = remedy(quantity, use.result.case) if state == UNDECIDED else ""
    load_of = _coupling if "coupling" in use.where else _section_or_gear
    words, allowed, load, unit = load_of(use, speed)
    if not load or not allowed or not 0.0 < allowed < np.inf:
        allowed, load, unit = 1.0, share, ""
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
        margin=allowed - load,
        state=state,
        decided_by=decided_by,
        utilisation=share,
        # of the largest use, which may be another than that in passing through
        speed=np.nan if use.kind == PASSING and not unit else speed,
        condition=_condition(use),
        **words,
    )


def _where_barred(use: _Use) -> tuple[str, str]:
    """A limit that is exceeded is kept where that is only in ranges which may be barred.

    In conditions of the cylinders those of all of them count.
    """
    folder = use.stem.removesuffix("limit/")
    found = every(use.result.record, f"{folder}exceeded", "exceeded", "limit", "permitted")
    here = use.result.record.quantities.get(
        f"{TORSION}{use.stem}operating{'_' if folder else '/'}utilisation"
    )
    operating = 0.0 if here is None else float(np.max(_over_conditions(here, use.place)))
    if found or not folder:
        limit, permitted_ = (one.values for one in found) if found else 2 * (np.zeros(0),)
        may = permitted_[limit == use.where["limit"]]
        unbarred = operating if may.size and may.all() else np.inf
    else:  # of an older file
        given = use.entry("unbarred_utilisation")
        if given is None and not operating > 1.0:
            return UNDECIDED, "another run"
        unbarred = np.inf if given is None else given
    return BROKEN if unbarred > 1.0 else BARRED, ""


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
    if limit == "temperature" and one is not None:  # counts by its rise
        load = one.temperature - ICE + use.share * (allowed - (one.temperature - ICE))
    if use.stem == "coupling/" and limit != "n_max":
        at = speed if use.kind == CONTINUOUS and np.isfinite(speed) else None
        load = borne(use.result, limit, place, at)
        if load and limit.startswith("T_KW"):  # less is permitted at the frequency of its torque
            allowed = load / use.share
    return told, allowed, load, unit


def _section_or_gear(use: _Use, _speed: float) -> _Read:
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
        known = _loaded(record)
        element = known[int(number) - 1] if number else f"limit {place + 1}"
    may = use.entry(allowed)
    load = use.share * may if may and load is None else load
    if may and load and abs(load / may - use.share) > 1e-6 * use.share:
        load = None  # the largest stress stands at another speed
    factor, unit = (MEGA, "N/mm^2") if of == "stress" else torque_unit(record)
    words = {"element": element, "limit": f"{of}, {use.kind}", "source": source, "status": status}
    return words, factor * (may or 0.0), factor * (load or 0.0), read(unit)


# ----------------------------------------------------------------------------
# Distance from orders.
# ----------------------------------------------------------------------------


_SEPARATED = ("margin", "order", "sufficient")


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
            limit=f"margin to order {order_text(order.values[i, k])}",
            status=rule.rule.status, speed=speed_of(result) or np.nan,
            utilisation=Bound("min", required, required).utilisation(away, "%"),
        )  # fmt: skip
