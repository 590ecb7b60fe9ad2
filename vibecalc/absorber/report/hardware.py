"""Parts of an absorber, and what to buy: springs, oil, clearance, and the peak that they give."""

import numpy as np

from vibecalc.absorber.report.tuning import is_mean, no_help
from vibecalc.absorber.stage import AS_TUNED, NO_SPRING
from vibecalc.absorber.tables import ICE
from vibecalc.core.report.rows import Cells, Rows, evenly, part_of, rows_of
from vibecalc.core.report.sections import (
    Part,
    Section,
    having,
    labels,
    scalar_of,
    scalars,
    section,
    table_of,
)
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

HARDWARE = "hardware/"
_SCALARS = (
    *("rod_stiffness", "primary_frequency", "ring_mass", "ring_inertia"),
    *(
        "built/spring_rate",
        "built/stiffness_ratio",
        "built/damping_over_primary_critical",
        "built/peak",
    ),
    *("built/peak_frequency", "clearance", "gap/rim", "gap/sides", "gap/bore"),
)
TUNING_BOUNDS = "tuning/bounds/penalty"
_PAIRS = 5


def _celsius(value: float, _error: float = 0.0) -> str:
    return f"{value - ICE:.1f}" if value else "never"


def _dynamic(record: Record) -> Quantity | None:
    """Dynamic viscosity of stock oils: their damping over that of the gap at one Pa*s."""
    damping = having(record, HARDWARE + "oil/damping", "stock_oil")
    if damping is None:
        return None
    films = sum(float(record[f"{HARDWARE}gap/{name}"]) for name in ("rim", "sides", "bore"))
    return part_of(damping, 1e3 * damping.values / films, *damping.axes)


BENDING = Rows("mode", "bending of the rod, mode", (
    Cells("frequency", "at rest, Hz", "Hz"), Cells("forward", "forward\nwhirl, Hz", "Hz"),
    Cells("backward", "backward\nwhirl, Hz", "Hz"),
), "hardware/bending", merge=True)  # fmt: skip
SPRINGS = Rows("stock_spring", "spring in stock", (
    Cells("rate", "rate, N/mm", "N/mm"), Cells("stiffness_ratio", "stiffness\nratio"),
), "hardware/spring", merge=True)  # fmt: skip
OILS = Rows("stock_oil", "oil in stock", (
    Cells("hardware/oil/kinematic_viscosity", "viscosity\ncSt", "cSt"),
    Cells(_dynamic, "viscosity\nmPa*s"), Cells("hardware/oil/damping", "damping\nN*m*s/rad"),
    Cells("hardware/oil/damping_over_primary_critical", "damping / critical\nof primary"),
    Cells("hardware/oil/right_temperature", "optimum at\ndegC", _celsius, right=True),
))  # fmt: skip
DAMPERS = Rows("stock_damper", "damper in stock", (
    Cells("damping", "N*s/m"),
    Cells("damping_over_primary_critical", "damping / critical\nof primary"),
), "hardware/damper", merge=True)  # fmt: skip
WARMING = Rows("temperature", "oil, degC", (
    Cells("damping_over_primary_critical", "damping / critical\nof primary"),
    Cells("peak", "peak, these\nsprings"),
    Cells("best_stiffness_ratio", "optimum\nstiffness"), Cells("best_peak", "peak with\nit"),
), "hardware/warming", label=_celsius, right=True, places=evenly(9))  # fmt: skip


def absorber_parts(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(HARDWARE))
    if not shown:
        return None
    bending, _ = rows_of(record, BENDING)
    guess = scalar_of(record, HARDWARE + "bending/rayleigh")
    if guess is not None:
        bending += paragraph(
            f"Rayleigh quotient, half sine over the span: {show(hertz(guess))} Hz, an upper bound "
            "of mode 1"
        )
    warming, _ = rows_of(record, WARMING)
    if warming:
        warming = [*paragraph(_warmed(record)), *warming]
    details: dict[str, Part] = {
        "part data": scalars(record, (HARDWARE + name for name in _SCALARS), HARDWARE),
        "bending of the rod": bending,
        "springs in stock": rows_of(record, SPRINGS),
        "oils in stock": rows_of(record, OILS),
        "dampers in stock": rows_of(record, DAMPERS),
        "effect of the oil temperature": warming,
    }
    blocks = [_to_buy(result), _pairs(record)]
    return section("Parts of the absorber", blocks, details, shown)


# ----------------------------------------------------------------------------
# What to buy: springs with an oil or a damper, the best pairs first.
# ----------------------------------------------------------------------------


def _best(record: Record) -> tuple[str, list[tuple[str, str, float]]]:
    """Oil or damper; springs, part and penalty of all allowed pairs in stock, the best first."""
    for part, root in (("oil", HARDWARE + "pair"), ("damper", HARDWARE + "damper_pair")):
        penalty, allowed = (record.quantities.get(f"{root}/{x}") for x in ("penalty", "allowed"))
        if penalty is not None:
            springs, others = (labels(axis) for axis in penalty.axes)
            there = True if allowed is None else allowed.values > 0
            values = np.where(there, penalty.values, np.inf)
            order = np.argsort(values, axis=None, kind="stable")
            pairs = np.stack(np.unravel_index(order, values.shape), axis=1)[
                : np.sum(np.isfinite(values))
            ]
            return part, [(springs[i], others[j], float(values[i, j])) for i, j in pairs]
    return "", []


def _pairs(record: Record) -> list[str]:
    (part, pairs), least = _best(record), scalar_of(record, "tuning/peak")
    if least is None or scalar_of(record, "tuning/helps") == 0.0:
        return []
    heads = Column("springs in stock"), Column(part), number("peak"), number("above optimum, %")
    rows = [
        [
            "" if spring == NO_SPRING else spring,
            other,
            show(least * (1.0 + cost)),
            show(100.0 * cost, digits=3),
        ]
        for spring, other, cost in pairs[:_PAIRS]
    ]
    return table(heads, rows)


def _warmed(record: Record) -> str:
    """Which springs and which oil get warm."""
    part, pairs = _best(record)
    if part != "oil" or not pairs:
        return "Effect of the oil temperature, installed oil and springs:"
    spring, oil, _ = pairs[0]
    held = "without springs" if spring == NO_SPRING else f"springs {spring!r}"
    return f"Effect of the oil temperature, stock oil {oil!r}, {held}:"


def _to_buy(result: Result) -> list[str]:
    """Springs, oil, clearance, and the peak that they will give."""
    record = result.record
    least = scalar_of(record, "tuning/peak")
    if least is None:
        return []
    rows = [*_wanted(result), *_bought(result, least)]
    if scalar_of(record, "tuning/helps") == 0.0:
        subject, what = no_help(result), "mean square" if is_mean(result) else "peak"
        rows = [f"nothing: {subject[0].lower()}{subject[1:]} the {what}."]
    return [*paragraph("To order:"), *(line for words in rows for line in paragraph(words, "-"))]


def _wanted(result: Result) -> list[str]:
    record, machine = result.record, table_of(result.case, "machine")
    rate, thick, play, damper = (scalar_of(record, path) for path in (
        *(HARDWARE + name for name in ("spring_rate", "dynamic_viscosity", "clearance")),
        "tuning/linear_damping",
    ))  # fmt: skip
    words = []
    if rate is not None:
        count = table_of(machine, "springs").get("count", 1)
        together = _in_units(record, "stiffness", "together")
        words.append(f"springs: {count} of {show(1e-3 * rate)} N/mm each{together}")
    if thick is not None:
        warm = table_of(machine, "gap").get("temperature")
        place = f" at {float(warm) - ICE:.4g} degC" if isinstance(warm, int | float) else ""
        inside = _in_units(record, "damping", "in the gap")
        words.append(f"oil: {show(1e3 * thick)} mPa*s{place}{inside}")
    elif damper is not None:
        words.append(f"damper: {show(damper)} N*s/m")
    if play is not None:
        words.append(f"clearance: {show(1e3 * play, digits=4)} mm")
    return words


def _in_units(record: Record, name: str, where: str) -> str:
    """Stiffness or damping of the tuning with its unit: in torsion, else along a line."""
    for kind in ("torsional", "linear"):
        found = record.quantities.get(f"tuning/{kind}_{name}")
        if found is not None:
            return f" ({show(float(found))} {found.unit} {where})"
    return ""


def _bought(result: Result, least: float) -> list[str]:
    record = result.record
    words = [f"peak with exactly these: {show(least)}"]
    alone = scalar_of(record, "tuning/peak_alone")
    if alone is not None and np.isfinite(alone):
        words[0] += f" (without an absorber {show(alone)})"
    given = bool(table_of(result.case, "tuning").get("frequency"))
    than = "this tuning" if given or is_mean(result) else "the optimum"
    built = scalar_of(record, HARDWARE + "built/peak")
    if built is not None:
        above = _above(built / least - 1.0, than)
        words.append(f"peak with the installed parts: {show(built)}, {above}")
    (part, pairs), peak = _best(record), scalar_of(record, HARDWARE + "buy/peak")
    if not pairs or peak is None:
        return words
    spring, other, cost = pairs[0]
    names = ("springs", spring), (part, other)
    what = " and ".join(f"{kind} {name!r}" for kind, name in names
                        if name not in (NO_SPRING, AS_TUNED))  # fmt: skip
    if AS_TUNED in (spring, other):
        what += f" with the {'springs' if spring == AS_TUNED else 'damper'} of the tuning"
    thick, dynamic = record.quantities.get(HARDWARE + "oil/kinematic_viscosity"), _dynamic(record)
    if thick is not None and dynamic is not None:
        place = labels(thick.axes[0]).index(other)
        both = show(float(dynamic[place])), show(1e6 * float(thick[place]))
        what += f" ({both[0]} mPa*s, {both[1]} cSt)"
    than = "the tuning" if TUNING_BOUNDS in record.quantities else than
    return [*words, f"from stock: {what}; peak {show(peak)}, {_above(cost, than)}"]


def _above(cost: float, than: str) -> str:
    return f"{show(100.0 * abs(cost), digits=3)} % {'below' if cost < 0.0 else 'above'} {than}"
