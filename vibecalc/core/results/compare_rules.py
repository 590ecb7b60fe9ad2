"""Which quantities are compared how, how closely, and entry by entry on the same labels."""

import fnmatch
import itertools
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.record import Axis, Quantity, Record
from vibecalc.core.results.select import LABEL_RTOL, entry_text, nearest
from vibecalc.core.results.text_files import LARGEST, text_file
from vibecalc.errors import UnitError, UsageError

# ----------------------------------------------------------------------------
# Rules of a comparison: which quantities are compared how, and how closely.
#
# A rules file is TOML::
#
#     [default]
#     rtol = 1e-7
#
#     [[rule]]
#     quantity = "isolation/*/natural_frequency"   # the last rule that fits counts, key by key
#     rtol = 1e-6
#     atol = "1e-3 rad/s"                          # a number is in the unit of the quantity
#
#     [[rule]]
#     quantity = "isolation/masked/*"
#     compare = "ignore"
# ----------------------------------------------------------------------------

#: kind -> what it does, for messages and documents
KINDS = {
    "value": "entry by entry; a complex entry is a point in the plane",
    "vector": "the entries along the last axis are one vector, compared as a whole",
    "phase": "angles modulo a turn (or cycle); of complex numbers where the amplitude is not small",
    "spectrum": "along `mode`, after matching modes by frequency and shape",
    "mode_shape": "direction and scale of each mode shape, whatever its sign",
    "curve": "along `speed`, as curves: samples may lie elsewhere",
    "ignore": "not at all",
}


@dataclass(frozen=True, kw_only=True)
class Rule:
    """How one quantity, or all that fit a pattern, is compared; None leaves a key to others.

    rtol
        Tolerance relative to the larger of the reference entry and the scale of the quantity.
    atol
        Absolute tolerance, added; a number in the unit of the quantity, or a text with a unit.
    compare
        One of `KINDS`; without it the quantity decides (complex, axis `mode`, axis `speed`).
    relative_to
        "whole": the scale is the largest magnitude in the quantity, of the same mode, order,
        condition and point of a sweep; "entry": each entry's own.
    floor
        Amplitude, relative to the largest one, below which a phase says nothing.
    shift
        Half-width of the tube around a curve along its axis, relative to the highest speed.
    repeated
        Modes whose frequencies are this close, relative, are one subspace.
    nan_equal
        Whether NaN equals NaN.
    """

    quantity: str = "*"
    rtol: float | None = None
    atol: float | str | None = None
    compare: str | None = None
    relative_to: str | None = None
    floor: float | None = None
    shift: float | None = None
    repeated: float | None = None
    nan_equal: bool | None = None


#: used where neither a rule nor [default] of a file says otherwise; curves have an rtol of 1e-4
DEFAULT = Rule(
    rtol=1e-7, atol=0.0, relative_to="whole", floor=1e-6, shift=1e-4, repeated=1e-5, nan_equal=True
)
CURVE_RTOL = 1e-4


@dataclass(frozen=True, kw_only=True)
class Rules:
    """Rules in the order of their file; later ones win."""

    default: Rule = Rule()
    rules: tuple[Rule, ...] = ()
    source: str = "built in"

    def unused(self, paths: Iterable[str]) -> list[str]:
        """Patterns that fit none of the quantities."""
        names = list(paths)
        return [one.quantity for one in self.rules if not fnmatch.filter(names, one.quantity)]

    def given(self, path: str) -> Rule:
        """What the file says about the quantity at `path`, key by key; None where it is silent."""
        merged: dict[str, Any] = _said(self.default)
        for rule in self.rules:
            if fnmatch.fnmatchcase(path, rule.quantity):
                merged |= _said(rule)
        return Rule(**{**merged, "quantity": path})


def completed(rule: Rule, compare: str) -> Rule:
    """`rule` with the built-in defaults for a comparison of kind `compare` in its gaps."""
    standard = _said(DEFAULT)
    if compare == "curve":
        standard["rtol"] = CURVE_RTOL
    return Rule(**{**standard, **_said(rule), "quantity": rule.quantity, "compare": compare})


def absolute_tolerance(rule: Rule, unit: str) -> float:
    """`rule.atol` in `unit`; UsageError names the rule where the dimensions do not agree."""
    if not isinstance(rule.atol, str):
        return float(rule.atol or 0.0)
    from vibecalc.units import parse_quantity

    try:
        return parse_quantity(rule.atol, unit, difference=True)
    except UnitError as error:
        raise UsageError(f"atol = {rule.atol!r} does not fit {rule.quantity}: {error}") from error


def read_rules(path: Path | str) -> Rules:
    """Read a rules file. Raises UsageError that lists all problems of the file at once."""
    try:
        content = tomllib.loads(text_file(Path(path), LARGEST, "the rules file"))
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path} is not a TOML file: {error}") from error
    problems = [
        f"unknown table [{name}]; known are {', '.join(nearest(name, ['default', 'rule']))}"
        for name in content
        if name not in ("default", "rule")
    ]
    tables = content.get("rule", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        problems.append("`rule` has to be a list of tables: write [[rule]]")
        tables = []
    default = content.get("default", {})
    if not isinstance(default, dict):
        problems.append("`default` has to be a table: write [default]")
        default = {}
    problems += _problems("[default]", default, _DEFAULT_KEYS)
    for number, table in enumerate(tables, start=1):
        name = f"[[rule]] {number}"
        if "quantity" not in table:
            problems.append(f'{name}: `quantity` is missing, as in quantity = "isolation/*"')
        problems += _problems(name, table, _RULE_KEYS)
    if problems:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        raise UsageError("\n  ".join([f"{count} in the rules file {path}:", *problems]))
    return Rules(
        default=Rule(**default), rules=tuple(Rule(**table) for table in tables), source=str(path)
    )


def _problems(where: str, table: dict[str, Any], known: tuple[str, ...]) -> list[str]:
    problems = []
    for key, value in table.items():
        if key not in known:
            problems.append(
                f"{where}: unknown key `{key}`; known are {', '.join(nearest(key, known))}"
            )
        elif (wrong := _CHECKS[key](value)) is not None:
            problems.append(f"{where}: {key} = {value!r}: {wrong}")
    return problems


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _tolerance(value: Any) -> str | None:
    return None if _is_number(value) and value >= 0 else "has to be a number, zero or more"


def _absolute(value: Any) -> str | None:
    if isinstance(value, str):
        from vibecalc.units import split_number

        try:
            value = float(split_number(value)[0].replace("_", ""))
        except ValueError:
            return 'has to begin with a number, as in "1e-6 N"'
    return _tolerance(value)


def _one_of(words: tuple[str, ...]) -> Callable[[Any], str | None]:
    def check(value: Any) -> str | None:
        if value in words:
            return None
        return f"has to be one of {', '.join(nearest(str(value), words))}"

    return check


def _pattern(value: Any) -> str | None:
    return None if isinstance(value, str) and value else "has to be a path or pattern"


def _flag(value: Any) -> str | None:
    return None if isinstance(value, bool) else "has to be true or false"


_CHECKS: dict[str, Callable[[Any], str | None]] = {
    "quantity": _pattern,
    "rtol": _tolerance,
    "atol": _absolute,
    "compare": _one_of(tuple(KINDS)),
    "relative_to": _one_of(("whole", "entry")),
    "floor": _tolerance,
    "shift": _tolerance,
    "repeated": _tolerance,
    "nan_equal": _flag,
}
_RULE_KEYS = tuple(_CHECKS)
_DEFAULT_KEYS = tuple(key for key in _CHECKS if key not in ("quantity", "compare"))


def _said(rule: Rule) -> dict[str, Any]:
    """The keys of a rule that say something."""
    pairs = {field.name: getattr(rule, field.name) for field in fields(rule)}
    del pairs["quantity"]
    return {name: value for name, value in pairs.items() if value is not None}


# ----------------------------------------------------------------------------
# Brings two quantities onto the same entries, by the labels on their axes.
# ----------------------------------------------------------------------------


class Entries(NamedTuple):
    """Compared entries, flat: labels, reference, value, how far apart, and how far they may be."""

    labels: tuple[str, ...]
    reference: np.ndarray
    value: np.ndarray
    difference: np.ndarray
    allowed: np.ndarray


class AlignedArrays(NamedTuple):
    """Two arrays over the same axes, and what had to be left out of either."""

    reference: np.ndarray
    value: np.ndarray
    axes: tuple[Axis, ...]
    problems: tuple[str, ...]


def align(reference: Quantity, value: Quantity, free: str | None = None) -> AlignedArrays:
    """Entries that both have, in the order of the reference; axis names are the same in both.

    The axis named `free` is put first and left as it is in either array (it is not in `axes`).
    """
    left, right = np.asarray(reference.values), np.asarray(value.values)
    axes: list[Axis] = []
    problems: list[str] = []
    first = None
    for position, (one, other) in enumerate(zip(reference.axes, value.axes, strict=True)):
        if one.name == free:
            first = position
            continue
        from_left, from_right = match_labels(one.values, other.values)
        problems += _left_out(one, from_left, "is missing")
        problems += _left_out(other, from_right, "is not in the reference")
        left = left.take(from_left, axis=position)
        right = right.take(from_right, axis=position)
        shared = np.asarray(one.values)[from_left]
        axes.append(Axis(name=one.name, values=shared, unit=one.unit, long_name=one.long_name))
    if first is not None:
        left, right = np.moveaxis(left, first, 0), np.moveaxis(right, first, 0)
    return AlignedArrays(left, right, tuple(axes), tuple(problems))


def match_labels(left: np.ndarray, right: np.ndarray) -> tuple[list[int], list[int]]:
    """Positions of equal labels: names exactly, numbers within 1e-9 of the larger one.

    A label that occurs twice is matched in order of occurrence.
    """
    if left.dtype.kind not in "biuf" or right.dtype.kind not in "biuf":
        return _match_names([str(name) for name in left], [str(name) for name in right])
    order_left, order_right = np.argsort(left, kind="stable"), np.argsort(right, kind="stable")
    pairs: list[tuple[int, int]] = []
    i = j = 0
    while i < len(left) and j < len(right):
        x, y = float(left[order_left[i]]), float(right[order_right[j]])
        if abs(x - y) <= LABEL_RTOL * max(abs(x), abs(y)):
            pairs.append((int(order_left[i]), int(order_right[j])))
            i, j = i + 1, j + 1
        elif x < y:
            i += 1
        else:
            j += 1
    pairs.sort()
    return [one for one, _ in pairs], [other for _, other in pairs]


def labels(axes: tuple[Axis, ...], prefix: str = "") -> tuple[str, ...]:
    """One label per entry of an array over `axes`, in C order."""
    texts = [
        [f"{axis.name}={entry_text(axis, position)}" for position in range(len(axis.values))]
        for axis in axes
    ]
    start = [prefix] if prefix else []
    return tuple(", ".join([*start, *parts]) for parts in itertools.product(*texts))


def _match_names(left: list[str], right: list[str]) -> tuple[list[int], list[int]]:
    places: dict[str, list[int]] = {}
    for position, name in enumerate(right):
        places.setdefault(name, []).append(position)
    pairs = [
        (position, places[name].pop(0)) for position, name in enumerate(left) if places.get(name)
    ]
    return [one for one, _ in pairs], [other for _, other in pairs]


def _left_out(axis: Axis, shared: list[int], words: str) -> list[str]:
    lost = sorted(set(range(len(axis.values))) - set(shared))
    if not lost:
        return []
    more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
    return [f"{axis.name}={entry_text(axis, lost[0])}{more} {words}"]


# ----------------------------------------------------------------------------
# Entry by entry, as vectors, and by phase: the comparisons that need no matching.
# ----------------------------------------------------------------------------

#: axes along which each row is measured by its own size, and so is each point of a sweep
_ROWS = re.compile(r"(?:.*_)?(?:mode|order|condition|operation|harmonic)|sample|.*\..*")
#: standard errors that two statistics may be apart
_STANDARD_ERRORS = 4.0
#: how much larger an error estimate may be than that of the reference and still count
_GROWTH = 10.0
#: of the terms that cancel: what the last bits of sums and of their inputs may leave of them
_LAST_DIGITS = 1e-13
_OPTIMISED = "optimisation/variable/"


def by_value(aligned: AlignedArrays, reference: Quantity, value: Quantity, rule: Rule) -> Entries:
    """Each entry for itself; complex entries are points in the plane, names equal or not."""
    left, right = aligned.reference.ravel(), aligned.value.ravel()
    names = labels(aligned.axes)
    if left.dtype.kind not in "biufc":
        difference = np.where(left.astype(str) == right.astype(str), 0.0, math.inf)
        return Entries(names, left, right, difference, np.zeros(left.shape))
    allowed = tolerance(np.abs(aligned.reference), aligned.axes, reference, value, rule).ravel()
    return Entries(names, left, right, apart(left, right, rule), allowed)


def by_vector(aligned: AlignedArrays, reference: Quantity, value: Quantity, rule: Rule) -> Entries:
    """The entries along the last axis as one vector: length of the difference."""
    if not aligned.axes or aligned.reference.dtype.kind not in "biufc":
        return by_value(aligned, reference, value, rule)
    count = math.sqrt(aligned.reference.shape[-1])
    difference = np.linalg.norm(apart(aligned.reference, aligned.value, rule), axis=-1).ravel()
    left = np.linalg.norm(np.abs(aligned.reference), axis=-1)
    right = np.linalg.norm(np.abs(aligned.value), axis=-1).ravel()
    axes = aligned.axes[:-1]
    allowed = tolerance(left, axes, reference, value, rule, spread=count).ravel()
    return Entries(labels(axes), left.ravel(), right, difference, allowed)


def by_phase(
    aligned: AlignedArrays,
    reference: Quantity,
    value: Quantity,
    rule: Rule,
    period: float = 2.0 * math.pi,
) -> Entries:
    """Angles modulo one turn, or another period, in rad; `rtol` and `atol` are in rad.

    Of complex entries the angle counts, where the reference is above the amplitude floor; the
    error estimates turn a phase by themselves over the amplitude.
    """
    names = labels(aligned.axes)
    left, right = aligned.reference.ravel(), aligned.value.ravel()
    margin = absolute_tolerance(rule, "rad") + (rule.rtol or 0.0)
    size = scale_of(np.abs(left)) if np.iscomplexobj(left) else 1.0
    known, other = reference.error_estimate, value.error_estimate
    errors = uncertainty(known, other, (rule.rtol or 0.0) * size)
    if np.iscomplexobj(left) and np.iscomplexobj(right):
        amplitude = np.abs(left)
        significant = np.flatnonzero(amplitude > (rule.floor or 0.0) * size)
        left, right = left[significant], right[significant]
        names = tuple(names[position] for position in significant)
        # A value of zero has no phase: as far off as can be.
        turned = np.where(right == 0, math.pi, np.abs(np.angle(right * np.conj(left))))
        allowed = margin + errors / np.abs(left)
        left, right = np.angle(left), np.angle(right)
    elif reference.unit == "rad":
        turned = np.abs(np.remainder(left - right + period / 2.0, period) - period / 2.0)
        allowed = np.full(left.shape, margin + errors)
    else:
        raise UsageError(
            f"compare = 'phase' does not fit {reference.path}: "
            "it needs complex numbers or angles in rad"
        )
    same = (left == right) | (np.isnan(left) & np.isnan(right) & bool(rule.nan_equal))
    difference = np.where(same, 0.0, np.where(np.isfinite(turned), turned, math.inf))
    return Entries(names, left, right, difference, allowed)


def apart(left: np.ndarray, right: np.ndarray, rule: Rule) -> np.ndarray:
    """|left - right|; infinities of one sign are equal, NaN is only if the rule says so."""
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(np.subtract(left, right, dtype=_common(left, right)))
    same = left == right
    if rule.nan_equal:
        same = same | (np.isnan(left) & np.isnan(right))
    return np.where(same, 0.0, np.where(np.isnan(difference), math.inf, difference))


def tolerance(
    magnitude: np.ndarray,
    axes: Sequence[Axis],
    reference: Quantity,
    value: Quantity,
    rule: Rule,
    spread: float = 1.0,
) -> np.ndarray:
    """What entries may differ by: atol + rtol * max(entry, scale) and both error estimates.

    `magnitude` are the sizes of the compared entries, over `axes`; `spread` multiplies the error
    estimates, for entries made of several. Statistics may be four standard errors apart instead.
    """
    size = np.where(np.isfinite(magnitude), magnitude, 0.0)
    if rule.relative_to == "whole":
        within = tuple(i for i, axis in enumerate(axes) if not _ROWS.fullmatch(axis.name))
        largest = size.max(axis=within, keepdims=True, initial=0.0)
        size = np.broadcast_to(largest, size.shape)
    margin = (rule.rtol or 0.0) * size
    errors = spread * uncertainty(reference.error_estimate, value.error_estimate, margin)
    allowed = absolute_tolerance(rule, reference.unit) + errors
    if reference.standard_error is not None or value.standard_error is not None:
        both = math.hypot(reference.standard_error or 0.0, value.standard_error or 0.0)
        return np.asarray(allowed + _STANDARD_ERRORS * spread * both)
    return np.asarray(allowed + margin)


def uncertainty(known: float, other: float, margin: Any) -> Any:
    """What the error estimates of the reference (`known`) and the value (`other`) allow together.

    The value's counts up to ten times that of the reference, next to the `margin` that is allowed
    anyway: numbers that got worse do not excuse themselves by saying so. An estimate that is not
    finite allows nothing.
    """
    known = known if math.isfinite(known) else 0.0
    most = _GROWTH * known + margin
    return known + (np.minimum(other, most) if math.isfinite(other) else 0.0 * most)


def grown(reference: Quantity, value: Quantity, rule: Rule) -> str:
    """Words on an error estimate that has grown beyond what the numbers may differ by, or empty.

    Such a number is not known as well as the reference, and may be the same by chance.
    """
    if reference.standard_error is not None or value.standard_error is not None:
        return ""
    numbers = reference.values.dtype.kind in "biufc"
    size = scale_of(np.abs(reference.values)) if numbers else 0.0
    most = absolute_tolerance(rule, reference.unit) + (rule.rtol or 0.0) * size
    was, now = float(reference.error_estimate), float(value.error_estimate)
    if now <= _GROWTH * was + most:
        return ""
    return f"error estimate {was:.1e} became {now:.1e} {reference.unit}".rstrip()


def last_digits(reference: Record) -> float:
    """How much of the terms that cancel may be left: of sums, and of inputs that a search found.

    A search says to how much of itself it knows what it found, an angle to how much of a radian;
    so do both of two results.
    """
    shares = [0.0]
    for path in (path for path in reference if path.startswith(_OPTIMISED)):
        variable = reference[path]
        size = 1.0 if variable.unit == "rad" else abs(float(variable.values))
        if size > 0.0:
            shares.append(variable.error_estimate / size)
    return _LAST_DIGITS + 2.0 * max(shares)


def scale_of(magnitude: np.ndarray) -> float:
    """Largest finite entry, zero if there is none."""
    finite = magnitude[np.isfinite(magnitude)]
    return float(finite.max()) if finite.size else 0.0


def _common(left: np.ndarray, right: np.ndarray) -> type:
    return complex if np.iscomplexobj(left) or np.iscomplexobj(right) else float
