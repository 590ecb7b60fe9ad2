"""Absorbers and pendulums in the report: response, tuning, its proof, the cost of errors."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.absorber.asked_tables import excitation_and_response
from vibecalc.absorber.report.motion import band_words, in_percent, tolerances
from vibecalc.absorber.results import FrictionDamped
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
    together,
)
from vibecalc.core.report.writing import Column, height, hertz, number, paragraph, show, table
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result

# ----------------------------------------------------------------------------
# Response of a primary system with its absorber: peaks, frequencies, poles.
# ----------------------------------------------------------------------------

ABSORBER = "response/absorber/"
#: lines on the curves that a brief report has room for
_BRIEF = 40
_MARKS = ("primary_frequency", "antiresonance", "locked_frequency_ratio")
CURVES = Rows("curve", "curve", (
    Cells("largest", "largest\nresponse"), Cells("largest_frequency_ratio", "at frequency\nratio"),
    Cells("largest_travel", "largest\ntravel"),
), "response/absorber", merge=True)  # fmt: skip
TRAVELS = Rows("curve", "largest travel of curve", (
    Cells("each/largest_travel", "{}"),
), "response/absorber")  # fmt: skip
NATURAL = Rows("mode", "undamped mode", (
    Cells("natural_frequency_ratio", "frequency\nratio"),
), "response/absorber", merge=True)  # fmt: skip
FIXED = Rows("fixed_point", "fixed point", (
    Cells("frequency_ratio", "frequency\nratio"), Cells("magnitude", "response"),
), "response/absorber/fixed_point", merge=True)  # fmt: skip


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
    marks = scalars(record, (ABSORBER + name for name in names), ABSORBER)
    details: dict[str, Part] = {
        "frequencies of the absorber": together(
            marks, rows_of(record, NATURAL), rows_of(record, FIXED)
        ),
        "poles": _poles(record),
    }
    curves: list[Part] = [_curves(result), _peaks(record)]
    if height(together(*curves)[0]) > _BRIEF:
        details, curves = {"curves and their maxima": together(*curves), **details}, []
    return section("Response of primary and absorber", curves, details, shown)


def _curves(result: Result) -> list[str]:
    lines, _ = together(rows_of(result.record, CURVES), rows_of(result.record, TRAVELS))
    if not lines:
        return []
    options, tuning = table_of(result.case, "response", "absorber"), table_of(result.case, "tuning")
    by, what = excitation_and_response(options, tuning)
    over = "base motion" if by.startswith("base") else "static displacement of the primary"
    over = "(unbalance / mass of the primary)" if by == "unbalance" else over
    of = f"{what} for {by} excitation".replace("_", " ")
    about = paragraph(f"{of}; displacements / {over}")
    return [*about, *lines]


def _peaks(record: Record) -> list[str]:
    """Every maximum of every curve."""
    height = having(record, ABSORBER + "peak/magnitude", "curve", "peak")
    place = having(record, ABSORBER + "peak/frequency_ratio", "curve", "peak")
    if height is None or place is None:
        return []
    natural = scalar_of(record, ABSORBER + "primary_frequency")
    columns = [Column("maxima of curve"), number("frequency\nratio")]
    columns += [number("Hz")] if natural is not None else []
    columns += [number("response")]
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
    return [*paragraph("poles relative to the primary's natural frequency, one per pair:"),
            *table(columns, rows)]  # fmt: skip


# ----------------------------------------------------------------------------
# Tuning of an absorber: what is best, what proves it, what errors in it cost.
# ----------------------------------------------------------------------------

TUNING = "tuning/"
_KINDS = {
    "free": "spring and damper",
    "viscous": "a damper without a spring",
    "undamped_spring": "a spring without a damper",
    "lanchester": "Lanchester's damper without a spring, optimum for an undamped primary",
}
_RESULTS = (
    *(
        "primary_damping",
        "mass_ratio",
        "stiffness_ratio",
        "damping_over_primary_critical",
        "absorber_damping_ratio",
    ),
    *("torsional_stiffness", "torsional_damping", "linear_stiffness", "linear_damping"),
    *("secondary_frequency", "peak", "mean_square", "travel"),
)
_PENALTY = 1e-9
#: peaks with and without absorbers that differ by less are the same
_SAME = 1e-9
_RATIO, _DAMPING = (
    Cells("stiffness_ratio", "stiffness\nratio"),
    Cells("damping_over_primary_critical", "damping / critical\nof primary"),
)
EACH = Rows("absorber", "absorber", (
    Cells("mass_ratio", "mass ratio"), _RATIO, _DAMPING,
    Cells("absorber_damping_ratio", "damping\nratio"), Cells("travel", "travel"),
), "tuning/each", merge=True)  # fmt: skip
EACH_BUILT = Rows("absorber", "absorber", (
    Cells("torsional_stiffness", "spring\nN*m/rad"),
    Cells("torsional_damping", "damper\nN*m*s/rad"),
    Cells("linear_stiffness", "spring\nN/m", "N/m"), Cells("linear_damping", "damper\nN*s/m"),
    Cells("frequency", "frequency\nHz", "Hz"),
), "tuning/each", merge=True)  # fmt: skip
ACTIVE = Rows("active", "governing peak", (
    Cells("frequency_ratio", "frequency\nratio"), Cells("magnitude", "response"),
    Cells("weight", "weight"),
), "tuning/active", merge=True)  # fmt: skip
METHODS = Rows("method", "method", (
    _RATIO, _DAMPING, Cells("promised", "predicted\npeak", blank=True), Cells("peak", "true peak"),
    Cells("loss", "above the\noptimum, %", "%"),
), "tuning/method", merge=True)  # fmt: skip
SLOPES = Rows("ratio", "derivative with respect to", (
    Cells("stiffness_ratio", "optimum\nstiffness"),
    Cells("damping_over_primary_critical", "optimum\ndamping"), Cells("peak", "peak"),
), "tuning/sensitivity", merge=True)  # fmt: skip


def _with_names(quantity: Quantity, places: Any, names: list[str]) -> Quantity:
    """Some columns of a quantity of two axes, under names of their own."""
    first, second = quantity.axes
    axis = replace(second, values=np.array(names, dtype=object))
    return part_of(quantity, quantity.values[:, places], first, axis)


def _mistuned(record: Record) -> Quantity | None:
    """What errors of the parts that are there cost, the first six of them."""
    loss = having(record, TUNING + "mistuning/loss", "mistuned", "deviation")
    if loss is None or not np.any(np.abs(loss.values) > loss.error_estimate):
        return None
    there = [
        scalar_of(record, TUNING + name) != 0.0
        for name in ("stiffness_ratio", "damping_over_primary_critical")
    ]
    axis = replace(loss.axes[0], values=loss.axes[0].values[there])
    names = [f"{100.0 * size:+.3g} %" for size in loss.axes[1].values[:6]]
    return _with_names(part_of(loss, loss.values[there], axis, loss.axes[1]), slice(6), names)


MISTUNED = Rows("mistuned", "increase of the {what} in % for a detuning of", (
    Cells(_mistuned, "{}", in_percent, right=True),
))  # fmt: skip


def _charted(record: Record) -> Quantity | None:
    """Peaks of a chart at six mass ratios."""
    peak = having(record, TUNING + "chart/peak", "primary_damping", "mass_ratio")
    if peak is None:
        return None
    masses = replace(peak, values=peak.axes[1].values, axes=peak.axes[1:])
    places = evenly(6)([masses])
    return _with_names(peak, places, [f"m = {masses.values[i]:.4g}" for i in places])


CHART = Rows("primary_damping", "primary damping", (
    Cells(_charted, "{}"),
), label=lambda damping: show(float(damping), digits=4), right=True)  # fmt: skip


def _off(record: Record) -> Quantity | None:
    """What is off in the states whose peaks hold a tuning, in percent."""
    found = record.quantities.get("tuning/tolerances/deviation")
    if found is None:
        return None
    names = [f"{name}, %".replace("_", "\n") for name in labels(found.axes[1])]
    return _with_names(found, slice(None), names)


STATES = Rows("active", "governing peak", (
    Cells(_off, "{}", in_percent, right=True),
), right=True)  # fmt: skip


def absorber_tuning(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record, given = result.record, bool(table_of(result.case, "tuning").get("frequency"))
    shown = frozenset(path for path in record if path.startswith(TUNING))
    if not shown:
        return None
    what = "mean square" if is_mean(result) else "peak"
    title = MISTUNED.title.format(what=what)
    slopes, _ = rows_of(record, SLOPES)
    if not any(np.any(record[path].values) for path in shown if "/sensitivity/" in path):
        slopes = []
    blocks: list[Part] = [
        _conclusion(result),
        scalars(record, (TUNING + name for name in _RESULTS), TUNING),
        rows_of(record, EACH),
        rows_of(record, EACH_BUILT),
        _bounded(record),
        tolerances(record),
        rows_of(record, MISTUNED._replace(title=title)),
    ]
    details: dict[str, Part] = {
        "largest in the band" if given else "governing peaks": [
            *_proof(record, given), *rows_of(record, STATES)[0]],
        "tuning by other methods": _methods(result),
        "slopes of the optimum": slopes,
        "design chart": _chart(record),
    }  # fmt: skip
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
        how = f"an absorber of the given frequency, {show(hertz(float(options['frequency'])))} Hz"
    measure = "mean square" if is_mean(result) else "peak"
    if scalar_of(record, TUNING + "helps") == 0.0:
        words = f"{no_help(result)} the {measure} of the {what} for {cause} excitation"
        threshold = scalar_of(record, TUNING + "threshold") or 0.0
        damped = (scalar_of(record, TUNING + "primary_damping") or 0.0) < threshold
        only = options.get("kind") == "undamped_spring" and damped
        return paragraph(words + ("; one with spring and damper does." if only else "."))
    least = "Peak" if options.get("frequency") else f"Minimum {measure}"
    words = f"{least} of the {what} for {cause} excitation{band_words(result)}, with {how}: "
    name = "mean_square" if is_mean(result) else "peak"
    value, alone = (scalar_of(record, TUNING + key) for key in (name, f"{name}_alone"))
    several = TUNING + "each/mass_ratio" in record.quantities
    if several and value is not None and alone is not None and value >= alone * (1.0 - _SAME):
        return paragraph(
            f"None of these absorbers helps: the {measure} of the {what} for {cause} excitation is "
            f"{show(value)} with them and {show(alone)} without."
        )
    if value is None:
        return paragraph(words.rstrip(": ") + ".")
    if alone is not None and value > alone:
        words += f"{show(value)}, more than the {show(alone)} without the absorber"
    else:
        words += show(value) + ("" if alone is None else f", without the absorber {show(alone)}")
        if alone is not None and math.isfinite(alone) and value > 0.0:
            words += f" (factor {show(alone / value, digits=3)})"
    k, m = (scalar_of(record, TUNING + name) for name in ("stiffness_ratio", "mass_ratio"))
    if k and m:
        words += f"; natural frequency ratio, absorber / primary: {show(math.sqrt(k / m))}"
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
    names = ("stiffness_ratio", "damping_over_primary_critical", "peak")
    k, z, least = (scalar_of(record, f"{TUNING}optimum/{name}") for name in names)
    if k is None or z is None or least is None:
        return []
    if value <= least * (1.0 + _SAME):
        return paragraph("This is the optimum for the band.")
    return paragraph(
        f"Optimum for the band: peak {show(least)} with stiffness ratio {show(k)} and damping "
        f"{show(z)}."
    )


def _threshold(limit: float) -> str:
    if math.isinf(limit):
        return "An absorber reduces the response whatever the damping of the primary."
    if limit == 0.0:
        return "With any damping of the primary the response is unbounded."
    return f"With a primary damping ratio of {show(limit)} or more an absorber gives no benefit."


def is_mean(result: Result) -> bool:
    """Whether the mean square is what was made small."""
    return table_of(result.case, "tuning").get("norm") == "h2"


def no_help(result: Result) -> str:
    """Subject and verb of what does not help, of the kind that the case asks for."""
    options = table_of(result.case, "tuning")
    within = " within the bounds" if table_of(options, "bounds") else ""
    return {
        "undamped_spring": f"No spring without a damper{within} reduces",
        "viscous": f"No damper without a spring{within} reduces",
        "lanchester": "This damper without a spring does not reduce",
    }.get(str(options.get("kind", "free")), f"No absorber{within} reduces")


def _proof(record: Record, given: bool) -> list[str]:
    if scalar_of(record, TUNING + "helps") == 0.0:
        return []
    lines, _ = rows_of(record, ACTIVE._replace(title="largest in the band") if given else ACTIVE)
    proof = record.quantities.get(TUNING + "certificate")
    if proof is not None and lines:
        left = show(float(proof), proof.error_estimate, 2)
        cost = scalar_of(record, TUNING + "bounds/penalty")
        what, small = "these peaks", "no small change"
        if cost is not None and cost > _PENALTY:
            what, small = "these peaks and the active bounds", "no small change within them"
        lines += paragraph(
            f"optimality: the weighted gradients of {what} with respect to spring and damper "
            f"cancel (remainder {left}); {small} reduces all peaks"
        )
    used = scalar_of(record, TUNING + "evaluations")
    if used is not None and not given:
        lines += paragraph(f"{int(used)} peak evaluations")
    return lines


def _methods(result: Result) -> list[str]:
    record, of = result.record, METHODS
    if is_mean(result):
        loss = of.columns[-1]
        assert isinstance(loss, Cells)
        mean = loss._replace(head="mean square above\noptimum, %")
        of = of._replace(columns=(*of.columns[:-1], mean))
    lines, _ = rows_of(record, of)
    if lines and TUNING + "bounds/penalty" in record.quantities:
        lines += paragraph("closed forms ignore the bounds: all methods without bounds")
    promised = having(record, TUNING + "method/promised", "method")
    if promised is None or not scalar_of(record, TUNING + "primary_damping"):
        return lines
    forms = np.array(labels(promised.axes[0])) != "numerical"
    if np.any(np.isfinite(np.asarray(promised.values)[forms])):
        lines += paragraph("predicted peak of a closed form: that of an undamped primary")
    return lines


def _bounded(record: Record) -> list[str]:
    """What holds the tuning, and what it would be without the bounds."""
    penalty = record.quantities.get(TUNING + "bounds/penalty")
    if penalty is None:
        return []
    if float(penalty.values) <= _PENALTY:
        return paragraph("the optimum without bounds lies within them")
    active = having(record, TUNING + "bounds/active", "tuning_bound")
    held = [] if active is None else [
        name for name, holds in zip(labels(active.axes[0]), active.values, strict=True) if holds
    ]  # fmt: skip
    lines = paragraph(
        f"active bounds: {', '.join(held)}; they raise the peak by "
        f"{show(100.0 * float(penalty.values), digits=3)} %; without them:"
    )
    names = ("stiffness_ratio", "damping_over_primary_critical", "peak", "travel")
    table_of_it, _ = scalars(record, (f"{TUNING}unbounded/{name}" for name in names), TUNING)
    return lines + table_of_it


def _chart(record: Record) -> list[str]:
    free = ", without the bounds" if TUNING + "bounds/penalty" in record.quantities else ""
    lines, _ = rows_of(record, CHART)
    return [*paragraph(f"Minimum peak for mass ratio m{free}:"), *lines] if lines else []


# ----------------------------------------------------------------------------
# A mass that dry friction drags along.
# ----------------------------------------------------------------------------

FRICTION = "friction_damper/"


def friction_damper(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    shown = frozenset(path for path in result.record if path.startswith(FRICTION))
    if not shown:
        return None
    given, best = (scalar_of(result.record, f"{FRICTION}{name}friction_ratio")
                   for name in ("", "best_"))  # fmt: skip
    # of a damper with the optimum friction that is said already
    skipped = f"{FRICTION}best_" if given == best else "-"
    paths = (path for path in paths_of(FrictionDamped) if not path.startswith(skipped))
    lines, _ = scalars(result.record, paths, FRICTION)
    return section("Friction damper", [lines], {}, shown)


# ----------------------------------------------------------------------------
# Pendulums on a rotor: their order, what it becomes with the swing, what they absorb.
# ----------------------------------------------------------------------------

PENDULUM = "pendulum/"
_SCALARS = (
    *("order", "path_radius", "detuning", "largest_swing", "mass_ratio"),
    *("inertia", "stiffness", "small/rotor", "small/swing", "small/rotor_without"),
    *("jump/torque", "jump/swing"),
)


def _change(record: Record) -> Quantity | None:
    """Change of the order by the swing, relative to that of small ones."""
    order = having(record, PENDULUM + "order_of_swing", "swing")
    if order is None:
        return None
    small = float(order.values[0])
    changed = part_of(order, order.values / small - 1.0, *order.axes)
    return replace(changed, error_estimate=2.0 * order.error_estimate / small, terms=1.0)


ORDERS = Rows("swing", "swing, deg", (
    Cells("pendulum/order_of_swing", "order"), Cells(_change, "change, %", in_percent, right=True),
), label=lambda swing: f"{math.degrees(swing):.1f}", right=True, places=evenly(9))  # fmt: skip


def pendulum(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(PENDULUM))
    if not shown:
        return None
    lines, _ = scalars(record, (PENDULUM + name for name in _SCALARS), PENDULUM)
    details = {"order against swing": rows_of(record, ORDERS)}
    return section("Centrifugal pendulums", [lines, _words(result)], details, shown)


def _words(result: Result) -> list[str]:
    record = result.record
    rotor, alone = (scalar_of(record, PENDULUM + f"small/{x}") for x in ("rotor", "rotor_without"))
    form = str(table_of(result.case, "machine", "pendulum").get("path", "circular"))
    lines = paragraph(f"the mass centre runs on a {form} path")
    if rotor is not None and alone is not None:
        swing = scalar_of(record, PENDULUM + "small/swing") or 0.0
        share = show(alone / rotor, digits=3) if rotor > 0.0 else "any"
        lines += paragraph(
            f"small swings of {show(math.degrees(swing), digits=4)} deg reduce the rotor's motion "
            f"by a factor of {share}"
        )
    torque = table_of(result.case, "machine", "pendulum").get("torque")
    limit = scalar_of(record, PENDULUM + "jump/torque")
    if limit is not None and math.isfinite(limit):
        words = f"above {show(limit)} N*m the pendulums jump out of phase with the torque"
        if isinstance(torque, int | float) and torque:
            words += f" ({show(limit / torque, digits=3)} times the torque of the case)"
        lines += paragraph(words)
    return lines
