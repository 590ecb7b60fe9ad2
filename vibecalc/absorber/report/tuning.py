"""Absorbers and pendulums in the report: response, tuning, its proof, the cost of errors."""

import math

import numpy as np

from vibecalc.absorber.report.motion import band_words, states, tolerances
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Part,
    Section,
    having,
    labels,
    scalar_of,
    scalars,
    section,
    stacked,
    table_of,
    together,
)
from vibecalc.core.report.writing import Column, height, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Record, Result

# ----------------------------------------------------------------------------
# Response of a primary system with its absorber: peaks, frequencies, poles.
# ----------------------------------------------------------------------------

ABSORBER = "response/absorber/"
#: lines on the curves that a brief report has room for
_BRIEF = 40
_MARKS = ("primary_frequency", "antiresonance", "locked_frequency_ratio")


def absorber(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(
        path for path in record if path.startswith(ABSORBER) and ABSORBER + "motion/" not in path
    )
    if not shown:
        return None
    # without a spring nothing stands still anywhere
    at_rest = scalar_of(record, ABSORBER + "antiresonance") == 0.0
    names = [name for name in _MARKS if not (at_rest and name == "antiresonance")]
    marks, _ = scalars(record, (ABSORBER + name for name in names), ABSORBER)
    natural = by_axis(
        record,
        "mode",
        "undamped mode",
        [(ABSORBER + "natural_frequency_ratio", "frequency\nratio")],
    )
    fixed = by_axis(
        record, "fixed_point", "fixed point",
        [(ABSORBER + "fixed_point/frequency_ratio", "frequency\nratio"),
         (ABSORBER + "fixed_point/magnitude", "height")],
    )  # fmt: skip
    details: dict[str, Part] = {
        "frequencies of the absorber": stacked(marks, natural, fixed),
        "poles": _poles(record),
    }
    curves = [_curves(result), _peaks(record)]
    if height(together(*curves)[0]) > _BRIEF:
        details, curves = {"curves and their maxima": together(*curves), **details}, []
    return section("Response of primary and absorber", curves, details, shown)


def _curves(result: Result) -> list[str]:
    lines = by_axis(
        result.record, "curve", "curve",
        [(ABSORBER + name, words) for name, words in (
            ("largest", "largest\nresponse"),
            ("largest_frequency_ratio", "at frequency\nratio"),
            ("largest_travel", "largest\ntravel"),
        )],
    )  # fmt: skip
    if not lines:
        return []
    moved = having(result.record, ABSORBER + "each/largest_travel", "curve", "absorber")
    if moved is not None:
        columns = [Column("largest travel of curve")]
        columns += [number(name) for name in labels(moved.axes[1])]
        rows = [
            [name, *(show(float(one), moved.error_estimate) for one in values)]
            for name, values in zip(labels(moved.axes[0]), np.asarray(moved.values), strict=True)
        ]
        lines += ["", *table(columns, rows)]
    options = table_of(result.case, "response", "absorber")
    tuning = table_of(result.case, "tuning")
    what = options.get("response") or tuning.get("response") or "displacement"
    cause = options.get("excitation") or tuning.get("excitation") or "force"
    words = f"{str(what).replace('_', ' ')} under excitation by {cause}, as ratios: "
    return [
        *paragraph(words + "displacements over T0 / K1, or over the motion of the ground"),
        *lines,
    ]


def _peaks(record: Record) -> list[str]:
    """Every maximum of every curve."""
    height = having(record, ABSORBER + "peak/magnitude", "curve", "peak")
    place = having(record, ABSORBER + "peak/frequency_ratio", "curve", "peak")
    if height is None or place is None:
        return []
    natural = scalar_of(record, ABSORBER + "primary_frequency")
    columns = [Column("maxima of curve"), number("frequency\nratio")]
    columns += [number("Hz")] if natural is not None else []
    columns += [number("height")]
    rows = []
    tops, spots = np.asarray(height.values), np.asarray(place.values)
    for label, heights, places in zip(labels(height.axes[0]), tops, spots, strict=True):
        for top, spot in zip(heights, places, strict=True):
            if top > 0.0:
                row = [label, show(spot)]
                row += [show(hertz(natural * spot))] if natural is not None else []
                rows.append([*row, show(top, height.error_estimate)])
    return table(columns, rows) if rows else []


def _poles(record: Record) -> list[str]:
    quantity = having(record, ABSORBER + "pole", "pole")
    if quantity is None:
        return []
    columns = (number("pole"), number("decay"), number("frequency\nratio"),
               number("damping\nratio"))  # fmt: skip
    rows = []
    for place, value in enumerate(np.asarray(quantity.values), start=1):
        if value.imag < -quantity.error_estimate:
            continue
        size = abs(value)
        rows.append([
            str(place), show(-value.real, quantity.error_estimate),
            show(value.imag, quantity.error_estimate),
            show(-value.real / size if size > 0.0 and math.isfinite(size) else 0.0, 1e-15),
        ])  # fmt: skip
    return [*paragraph("poles over the primary's own frequency, one of each pair:"),
            *table(columns, rows)]  # fmt: skip


# ----------------------------------------------------------------------------
# Tuning of an absorber: what is best, what proves it, what errors in it cost.
# ----------------------------------------------------------------------------

TUNING = "tuning/"
_KINDS = {
    "free": "spring and damper",
    "viscous": "a damper without a spring",
    "undamped_spring": "a spring without a damper",
    "lanchester": "the damper without a spring that suits an undamped primary",
}
_RESULTS = (
    *("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping", "own_damping"),
    *("torsional_stiffness", "torsional_damping", "linear_stiffness", "linear_damping"),
    *("secondary_frequency", "peak", "peak_less_one", "mean_square", "travel"),
)
_PENALTY = 1e-9
#: peaks with and without absorbers that differ by less are the same
_SAME = 1e-9


def absorber_tuning(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(TUNING))
    if not shown:
        return None
    lines = _conclusion(result)
    scalar, _ = scalars(record, (TUNING + name for name in _RESULTS), TUNING)
    blocks = [lines, scalar, _each(record), _bounded(record), tolerances(record), _mistuned(result)]
    given = bool(table_of(result.case, "tuning").get("frequency"))
    peaks = "largest in the band" if given else "peaks that hold the optimum"
    details = {
        peaks: [*_proof(record, given), *states(record)],
        "tuning by other methods": _methods(result),
        "slopes of the optimum": _slopes(record),
        "design chart": _chart(record),
    }
    return section("Tuning of the absorber", blocks, details, shown)


def _conclusion(result: Result) -> list[str]:
    """What is best in one sentence, and what it brings."""
    record, options = result.record, table_of(result.case, "tuning")
    what = str(options.get("response", "displacement")).replace("_", " ")
    cause = str(options.get("excitation", "force")).replace("_", " ")
    how = _KINDS.get(str(options.get("kind", "free")), "")
    if table_of(options, "bounds"):
        how += ", within the bounds"
    if options.get("frequency"):
        how = f"an absorber that swings at {show(hertz(float(options['frequency'])))} Hz, as given"
    measure = "mean square" if is_mean(result) else "largest amplitude"
    if scalar_of(record, TUNING + "helps") == 0.0:
        words = f"{no_help(result)} the {measure} of the {what} under excitation by {cause}"
        threshold = scalar_of(record, TUNING + "threshold") or 0.0
        damped = (scalar_of(record, TUNING + "primary_damping") or 0.0) < threshold
        only = options.get("kind") == "undamped_spring" and damped
        return paragraph(words + ("; spring and damper do." if only else "."))
    cause += band_words(result)
    least = "Largest amplitude" if options.get("frequency") else f"Least {measure}"
    words = f"{least} of the {what} under excitation by {cause}, by {how}: "
    name = "mean_square" if is_mean(result) else "peak"
    value, alone = (scalar_of(record, TUNING + key) for key in (name, f"{name}_alone"))
    several = TUNING + "each/mass_ratio" in record.quantities
    if several and value is not None and alone is not None and value >= alone * (1.0 - _SAME):
        return paragraph(
            f"None of these absorbers helps: the {measure} of the {what} under excitation by "
            f"{cause} is {show(value)} with them and {show(alone)} without."
        )
    if value is None:
        return paragraph(words.rstrip(": ") + ".")
    if alone is not None and value > alone:
        words += f"{show(value)}, more than the {show(alone)} without it"
    else:
        words += f"{show(value)} instead of {'' if alone is None else show(alone)}"
        if alone is not None and math.isfinite(alone) and value > 0.0:
            words += f", a factor {show(alone / value, digits=3)}"
    lines = paragraph(words + ".")
    if options.get("frequency"):
        lines += _next_to_the_best(record, value)
    if scalar_of(record, TUNING + "without_spring") == 1.0:
        lines += paragraph("The best absorber has no spring.")
    limit = scalar_of(record, TUNING + "threshold")
    if limit is not None:
        lines += paragraph(_threshold(limit))
    return lines


def _next_to_the_best(record: Record, value: float) -> list[str]:
    """What spring and damper could do within the band, next to a frequency as given."""
    names = ("stiffness_ratio", "secondary_damping", "peak")
    k, z, least = (scalar_of(record, f"{TUNING}optimum/{name}") for name in names)
    if k is None or z is None or least is None:
        return []
    if value <= least * (1.0 + _SAME):
        return paragraph("No spring and damper do better within the band.")
    return paragraph(
        f"The best spring and damper for the band leave {show(least)}: a stiffness ratio of "
        f"{show(k)} and a damping of {show(z)}."
    )


def _threshold(limit: float) -> str:
    if math.isinf(limit):
        return "An absorber helps at any damping of the primary."
    if limit == 0.0:
        return "With any damping of the primary it grows without bound."
    return f"From a damping of the primary of {show(limit)} on no absorber helps."


def is_mean(result: Result) -> bool:
    """Whether the mean square is what was made small."""
    return table_of(result.case, "tuning").get("norm") == "h2"


def no_help(result: Result) -> str:
    """Subject and verb of what does not help, of the kind that the case asks for."""
    options = table_of(result.case, "tuning")
    within = " within the bounds" if table_of(options, "bounds") else ""
    return {
        "undamped_spring": f"No spring without a damper{within} lowers",
        "viscous": f"No damper without a spring{within} lowers",
        "lanchester": "This damper without a spring does not lower",
    }.get(str(options.get("kind", "free")), f"No absorber{within} lowers")


def _each(record: Record) -> list[str]:
    lines = by_axis(
        record, "absorber", "absorber",
        [(f"{TUNING}each/{name}", words) for name, words in (
            ("mass_ratio", "mass ratio"), ("stiffness_ratio", "stiffness\nratio"),
            ("secondary_damping", "damping"), ("own_damping", "damping on its\nown frequency"),
            ("travel", "travel"),
        )],
    )  # fmt: skip
    kind = "linear" if TUNING + "each/linear_stiffness" in record.quantities else "torsional"
    units = ("N/m", "N*s/m") if kind == "linear" else ("N*m/rad", "N*m*s/rad")
    in_units = by_axis(
        record, "absorber", "absorber",
        [(f"{TUNING}each/{kind}_stiffness", "spring\n", units[0]),
         (f"{TUNING}each/{kind}_damping", "damper\n", units[1]),
         (f"{TUNING}each/frequency", "own frequency\n", "Hz")],
    )  # fmt: skip
    return [*lines, "", *in_units] if in_units else lines


def _proof(record: Record, given: bool) -> list[str]:
    if scalar_of(record, TUNING + "helps") == 0.0:
        return []
    lines = by_axis(
        record, "active", "largest in the band" if given else "peak that holds it",
        [(f"{TUNING}active/{name}", words) for name, words in (
            ("frequency_ratio", "frequency\nratio"), ("magnitude", "height"), ("weight", "weight"),
        )],
    )  # fmt: skip
    proof = scalar_of(record, TUNING + "certificate")
    if proof is not None and lines:
        left = show(proof, record[TUNING + "certificate"].error_estimate, 2)
        cost = scalar_of(record, TUNING + "bounds/penalty")
        what, small = "these peaks", "no small change"
        if cost is not None and cost > _PENALTY:
            what, small = "these peaks and of the bounds that hold", "no small change within them"
        lines += paragraph(
            f"the slopes of {what} by spring and damper cancel with these weights (left over: "
            f"{left}), so that {small} lowers them all"
        )
    used = scalar_of(record, TUNING + "evaluations")
    if used is not None and not given:
        lines += paragraph(f"found with {int(used)} evaluations of a peak")
    return lines


def _methods(result: Result) -> list[str]:
    record = result.record
    what = "mean square\nabove best," if is_mean(result) else "above the\nbest,"
    lines = by_axis(
        record, "method", "method",
        [(f"{TUNING}method/{name}", *words) for name, *words in (
            ("stiffness_ratio", "stiffness\nratio"), ("secondary_damping", "damping"),
            ("promised", "promised\npeak"), ("peak", "true peak"), ("loss", what, "%"),
        )],
        blank=(f"{TUNING}method/promised",),
    )  # fmt: skip
    if lines and TUNING + "bounds/penalty" in record.quantities:
        lines += paragraph("closed forms know no bounds: all of these are without them")
    promised = having(record, TUNING + "method/promised", "method")
    if promised is None or not scalar_of(record, TUNING + "primary_damping"):
        return lines
    forms = np.array(labels(promised.axes[0])) != "numerical"
    if np.any(np.isfinite(np.asarray(promised.values)[forms])):
        lines += paragraph("promised by a closed form: the peak on an undamped primary")
    return lines


def _mistuned(result: Result) -> list[str]:
    record = result.record
    loss = having(record, TUNING + "mistuning/loss", "mistuned", "deviation")
    if loss is None or not np.any(np.abs(loss.values) > loss.error_estimate):
        return []
    absent = {
        label
        for label, name in (("stiffness", "stiffness_ratio"), ("damping", "secondary_damping"))
        if scalar_of(record, TUNING + name) == 0.0
    }
    what = "mean square" if is_mean(result) else "peak"
    sizes = np.asarray(loss.axes[1].values, dtype=float)
    columns = [Column(f"higher {what}, %, for an error of")]
    columns += [number(f"{100.0 * size:+.3g} %") for size in sizes[:6]]
    rows = []
    for label, row in zip(labels(loss.axes[0]), np.asarray(loss.values), strict=True):
        if label in absent:
            continue
        cells = [show(100.0 * one, 100.0 * loss.error_estimate, 3) for one in row[:6]]
        rows.append([label, *cells])
    return table(columns, rows)


def _slopes(record: Record) -> list[str]:
    names = [f"{TUNING}sensitivity/{n}" for n in ("stiffness_ratio", "secondary_damping", "peak")]
    found = [one for name in names if (one := having(record, name, "ratio")) is not None]
    if not any(np.any(one.values) for one in found):
        return []
    return by_axis(
        record, "ratio", "slope by",
        [(f"{TUNING}sensitivity/{name}", words) for name, words in (
            ("stiffness_ratio", "of the best\nstiffness"),
            ("secondary_damping", "of the best\ndamping"),
            ("peak", "of the peak"),
        )],
    )  # fmt: skip


def _bounded(record: Record) -> list[str]:
    """What holds the tuning, and what it would be without the bounds."""
    penalty = record.quantities.get(TUNING + "bounds/penalty")
    if penalty is None:
        return []
    if float(penalty.values) <= _PENALTY:
        return paragraph("the bounds cost nothing: the best tuning of all keeps them")
    active = having(record, TUNING + "bounds/active", "tuning_bound")
    held = [] if active is None else [
        name for name, holds in zip(labels(active.axes[0]), active.values, strict=True) if holds
    ]  # fmt: skip
    lines = paragraph(
        f"the tuning is held by its bounds ({', '.join(held)}), which cost "
        f"{show(100.0 * float(penalty.values), digits=3)} % of the peak; without them it would be:"
    )
    names = ("stiffness_ratio", "secondary_damping", "peak", "travel")
    table_of_it, _ = scalars(record, (f"{TUNING}unbounded/{name}" for name in names), TUNING)
    return lines + table_of_it


def _chart(record: Record) -> list[str]:
    peak = having(record, TUNING + "chart/peak", "primary_damping", "mass_ratio")
    if peak is None:
        return []
    masses = np.asarray(peak.axes[1].values, dtype=float)
    chosen = np.unique(np.linspace(0, len(masses) - 1, 6).round().astype(int))
    columns = [number("primary damping")]
    columns += [number(f"m = {masses[i]:.4g}") for i in chosen]
    rows = [
        [show(float(damping), digits=4), *(show(row[i], peak.error_estimate) for i in chosen)]
        for damping, row in zip(peak.axes[0].values, np.asarray(peak.values), strict=True)
    ]
    free = ", without the bounds" if TUNING + "bounds/penalty" in record.quantities else ""
    return [*paragraph(f"Least peak over the mass ratio m{free}:"), *table(columns, rows)]


# ----------------------------------------------------------------------------
# Pendulums on a rotor: their order, what it becomes with the swing, what they absorb.
# ----------------------------------------------------------------------------

PENDULUM = "pendulum/"
_SCALARS = (
    *("order", "path_radius", "path_exponent", "detuning", "largest_swing", "mass_ratio"),
    *("inertia", "stiffness", "small/rotor", "small/swing", "small/rotor_without"),
    *("jump/torque", "jump/swing"),
)
_MOST_ROWS = 9


def pendulum(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(PENDULUM))
    if not shown:
        return None
    lines, _ = scalars(record, (PENDULUM + name for name in _SCALARS), PENDULUM)
    details = {"order against swing": _order_of_swing(record)}
    return section("Centrifugal pendulums", [lines, _words(result)], details, shown)


def _order_of_swing(record: Record) -> list[str]:
    quantity = having(record, PENDULUM + "order_of_swing", "swing")
    if quantity is None:
        return []
    swings = np.asarray(quantity.axes[0].values, dtype=float)
    chosen = np.unique(np.linspace(0, len(swings) - 1, _MOST_ROWS).round().astype(int))
    small = float(quantity.values[0])
    columns = (number("swing, deg"), number("order"), number("off by, %"))
    rows = []
    for i in chosen:
        value = float(quantity.values[i])
        off = 100.0 * (value / small - 1.0)
        slack = 200.0 * quantity.error_estimate / small
        rows.append([f"{math.degrees(swings[i]):.1f}", show(value), show(off, slack, 3)])
    return table(columns, rows)


def _words(result: Result) -> list[str]:
    record = result.record
    rotor, alone = (scalar_of(record, PENDULUM + f"small/{x}") for x in ("rotor", "rotor_without"))
    lines = []
    if rotor is not None and alone is not None:
        swing = scalar_of(record, PENDULUM + "small/swing") or 0.0
        share = show(alone / rotor, digits=3) if rotor > 0.0 else "any"
        lines += paragraph(
            f"small swings of {show(math.degrees(swing), digits=4)} deg bring the rotor's motion "
            f"down by a factor {share}"
        )
    torque = table_of(result.case, "machine", "pendulum").get("torque")
    limit = scalar_of(record, PENDULUM + "jump/torque")
    if limit is not None and math.isfinite(limit):
        words = f"beyond {show(limit)} N*m the pendulums jump out of step with the torque"
        if isinstance(torque, int | float) and torque:
            words += f", {show(limit / torque, digits=3)} times the one of the case"
        lines += paragraph(words)
    return lines
