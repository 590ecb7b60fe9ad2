"""Parts of an absorber, and what to buy: springs, oil, clearance, and the peak that they give."""

import numpy as np

from vibecalc.absorber.report.tuning import is_mean, no_help
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
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
ICE = 273.15
_SCALARS = (
    *("rod_stiffness", "primary_frequency", "ring_mass", "ring_inertia"),
    *("built/spring_rate", "built/stiffness_ratio", "built/secondary_damping", "built/peak"),
    *("built/peak_frequency", "clearance", "gap/rim", "gap/sides", "gap/bore"),
)
#: axis of a stock without springs
_NONE = "none"
#: of a stock that leaves one part to the tuning
_AS_TUNED = "as tuned"
TUNING_BOUNDS = "tuning/bounds/penalty"
_PAIRS = 5
_MOST_ROWS = 9


def absorber_parts(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(HARDWARE))
    if not shown:
        return None
    parts, _ = scalars(record, (HARDWARE + name for name in _SCALARS), HARDWARE)
    details = {
        "parts of the absorber": parts,
        "bending of the rod": _bending(record),
        "springs in stock": _springs(record),
        "oils in stock": _oils(record),
        "dampers in stock": _dampers(record),
        "what the absorber does as its oil warms": _warming(record),
    }
    blocks = [_to_buy(result), _pairs(result)]
    return section("Parts of the absorber, and what to buy", blocks, details, shown)


def _bending(record: Record) -> list[str]:
    names = [
        (f"{HARDWARE}bending/{name}", words, "Hz")
        for name, words in (
            ("frequency", "at rest,"), ("forward", "with the\nspin,"), ("backward", "against\nit,"),
        )
    ]  # fmt: skip
    lines = by_axis(record, "mode", "bending of the rod, mode", names)
    guess = scalar_of(record, HARDWARE + "bending/rayleigh")
    if guess is not None:
        lines += paragraph(
            f"Rayleigh's quotient for half a sine over the span: {show(hertz(guess))} Hz, an upper "
            "bound of the first"
        )
    return lines


def _springs(record: Record) -> list[str]:
    return by_axis(
        record, "stock_spring", "spring in stock",
        [(HARDWARE + "spring/rate", "rate, N/m"),
         (HARDWARE + "spring/stiffness_ratio", "stiffness\nratio")],
    )  # fmt: skip


def _oils(record: Record) -> list[str]:
    thick = having(record, HARDWARE + "oil/kinematic_viscosity", "stock_oil")
    if thick is None:
        return []
    columns = [Column("oil in stock"), number("viscosity\ncSt"),
               number("viscosity\nmPa*s"), number("damping\nN*m*s/rad"),
               number("damping\nratio")]  # fmt: skip
    others = [
        having(record, f"{HARDWARE}oil/{name}", "stock_oil")
        for name in ("damping", "secondary_damping", "right_temperature")
    ]
    right = others.pop()
    columns += [number("right at\ndegC")] if right is not None else []
    rows = []
    for place, label in enumerate(labels(thick.axes[0])):
        row = [label, show(1e6 * float(thick.values[place])), _dynamic(record, place)]
        row += ["" if one is None else show(float(one.values[place])) for one in others]
        if right is not None:
            warm = float(right.values[place])
            row.append(f"{warm - ICE:.1f}" if warm else "never")
        rows.append(row)
    return table(columns, rows)


def _dampers(record: Record) -> list[str]:
    return by_axis(
        record, "stock_damper", "damper in stock",
        [(HARDWARE + "damper/damping", "N*s/m"),
         (HARDWARE + "damper/secondary_damping", "damping\nratio")],
    )  # fmt: skip


def _penalty(record: Record) -> Quantity | None:
    """What pairs of stock parts cost: springs with oils, or with dampers."""
    oils = having(record, HARDWARE + "pair/penalty", "stock_spring", "stock_oil")
    return oils or having(record, HARDWARE + "damper_pair/penalty", "stock_spring", "stock_damper")


def _dynamic(record: Record, place: int) -> str:
    """Dynamic viscosity of a stock oil: its damping over that of the gap at one Pa*s."""
    damping = having(record, HARDWARE + "oil/damping", "stock_oil")
    shares = [scalar_of(record, f"{HARDWARE}gap/{name}") for name in ("rim", "sides", "bore")]
    films = sum(share for share in shares if share is not None)
    if damping is None or films <= 0.0:
        return ""
    return show(1e3 * float(damping.values[place]) / films)


def _best(record: Record, penalty: Quantity) -> list[tuple[str, str, float]]:
    """Springs, oil and penalty of every pair that keeps the travel, the best first."""
    springs, oils = (labels(axis) for axis in penalty.axes)
    values = np.asarray(penalty.values, dtype=float)
    path = penalty.path.replace("/penalty", "/allowed")
    admissible = having(record, path, *(axis.name for axis in penalty.axes))
    values = (
        values
        if admissible is None
        else np.where(np.asarray(admissible.values) > 0, values, np.inf)
    )
    order = np.argsort(values, axis=None, kind="stable")
    places = [np.unravel_index(int(place), values.shape) for place in order]
    return [(springs[i], oils[j], float(values[i, j])) for i, j in places
            if np.isfinite(values[i, j])]  # fmt: skip


def _pairs(result: Result) -> list[str]:
    record = result.record
    if _is_useless(record):
        return []
    penalty, least = _penalty(record), scalar_of(record, "tuning/peak")
    if penalty is None or least is None:
        return []
    other = penalty.axes[1].name.removeprefix("stock_")
    columns = (Column("the best pairs: springs"), Column(other), number("peak"),
               number("penalty, %"))  # fmt: skip
    rows = [
        [spring, oil, show(least * (1.0 + cost)), show(100.0 * cost, digits=3)]
        for spring, oil, cost in _best(record, penalty)[:_PAIRS]
    ]
    return table(columns, rows)


def _warming(record: Record) -> list[str]:
    peak = having(record, HARDWARE + "warming/peak", "temperature")
    if peak is None:
        return []
    warm = np.asarray(peak.axes[0].values, dtype=float)
    chosen = np.unique(np.linspace(0, len(warm) - 1, _MOST_ROWS).round().astype(int))
    names = (
        ("secondary_damping", "damping\nratio"), ("peak", "peak, these\nsprings"),
        ("best_stiffness_ratio", "best stiff-\nness ratio"), ("best_peak", "peak with\nit"),
    )  # fmt: skip
    shown = [
        (quantity, words)
        for name, words in names
        if (quantity := having(record, f"{HARDWARE}warming/{name}", "temperature")) is not None
    ]
    columns = [number("oil at degC"), *(number(words) for _, words in shown)]
    rows = [
        [f"{warm[i] - ICE:.1f}", *(show(float(q.values[i]), q.error_estimate) for q, _ in shown)]
        for i in chosen
    ]
    return [*paragraph(_warmed(record)), *table(columns, rows)]


def _warmed(record: Record) -> str:
    """Which springs and which oil get warm."""
    penalty = having(record, HARDWARE + "pair/penalty", "stock_spring", "stock_oil")
    pairs = [] if penalty is None else _best(record, penalty)
    if not pairs:
        return "As the oil that is in warms, with the springs that are in:"
    spring, oil, _ = pairs[0]
    held = "without springs" if spring == _NONE else f"with the springs {spring!r}"
    return f"As the oil {oil!r} from stock warms, {held}:"


def _is_useless(record: Record) -> bool:
    return scalar_of(record, "tuning/helps") == 0.0


def _to_buy(result: Result) -> list[str]:
    """Springs, oil, clearance, and the peak that they will give."""
    record = result.record
    least = scalar_of(record, "tuning/peak")
    if least is None:
        return []
    if _is_useless(record):
        what = "mean square" if is_mean(result) else "peak"
        subject = no_help(result)
        words = f"Buy nothing: {subject[0].lower()}{subject[1:]} the {what}."
        return [*paragraph("What to buy:"), *paragraph(words, "-")]
    rows = [*_wanted(result), *_bought(result, least)]
    if not rows:
        return []
    return [*paragraph("What to buy:"), *(line for words in rows for line in paragraph(words, "-"))]


def _wanted(result: Result) -> list[str]:
    record = result.record
    rate = scalar_of(record, HARDWARE + "spring_rate")
    thick = scalar_of(record, HARDWARE + "dynamic_viscosity")
    play = scalar_of(record, HARDWARE + "clearance")
    machine = table_of(result.case, "machine")
    words = []
    if rate is not None:
        count = table_of(machine, "springs").get("count", 1)
        stiff, unit = _in_units(record, "stiffness")
        each = f" ({show(stiff)} {unit} together)" if stiff is not None else ""
        words.append(f"springs: {count} of {show(1e-3 * rate)} N/mm each{each}")
    if thick is not None:
        gap = table_of(machine, "gap")
        warm = gap.get("temperature")
        place = f" at {float(warm) - ICE:.4g} degC" if isinstance(warm, int | float) else ""
        damping, unit = _in_units(record, "damping")
        worth = f" ({show(damping)} {unit} in the gap)" if damping is not None else ""
        words.append(f"oil: {show(1e3 * thick)} mPa*s{place}{worth}")
    elif (damping := scalar_of(record, "tuning/linear_damping")) is not None:
        words.append(f"damper: {show(damping)} N*s/m")
    if play is not None:
        words.append(f"clearance: {show(1e3 * play, digits=4)} mm")
    return words


def _in_units(record: Record, name: str) -> tuple[float | None, str]:
    """Stiffness or damping of the tuning with its unit: in torsion, else along a line."""
    for kind in ("torsional", "linear"):
        found = record.quantities.get(f"tuning/{kind}_{name}")
        if found is not None:
            return float(found.values), found.unit
    return None, ""


def _bought(result: Result, least: float) -> list[str]:
    record = result.record
    words = [f"with exactly these the peak is {show(least)}"]
    alone = scalar_of(record, "tuning/peak_alone")
    if alone is not None and np.isfinite(alone):
        words[0] += f", {show(alone)} without an absorber"
    given = bool(table_of(result.case, "tuning").get("frequency"))
    than = "the one of this tuning" if given or is_mean(result) else "the best"
    built = scalar_of(record, HARDWARE + "built/peak")
    if built is not None:
        words.append(
            f"with the parts that are in, it is {show(built)}, {_above(built / least - 1.0, than)}"
        )
    penalty = _penalty(record)
    peak = scalar_of(record, HARDWARE + "buy/peak")
    if penalty is None or peak is None:
        return words
    pairs = _best(record, penalty)
    if not pairs:
        return words
    spring, oil, cost = pairs[0]
    place = labels(penalty.axes[1]).index(oil)
    than = "the tuning" if TUNING_BOUNDS in record.quantities else than
    thick = having(record, HARDWARE + "oil/kinematic_viscosity", "stock_oil")
    other = penalty.axes[1].name.removeprefix("stock_")
    names = ((f"springs {spring!r}", spring), (f"{other} {oil!r}", oil))
    what = " and ".join(words for words, name in names if name not in (_NONE, _AS_TUNED))
    if _AS_TUNED in (spring, oil):
        what += f" with the {'springs' if spring == _AS_TUNED else 'damper'} of the tuning"
    if thick is not None:
        size = show(1e6 * float(thick.values[place]))
        what += f" ({_dynamic(record, place)} mPa*s, {size} cSt)"
    words.append(f"from stock: {what}; the peak is {show(peak)}, {_above(cost, than)}")
    return words


def _above(cost: float, than: str) -> str:
    return f"{show(100.0 * abs(cost), digits=3)} % {'below' if cost < 0.0 else 'above'} {than}"
