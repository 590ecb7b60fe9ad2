"""Which quantities are compared how, how closely, and entry by entry on the same labels."""

import fnmatch
import math
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.record import Axis, Quantity, Record
from vibecalc.core.results.select import LABEL_RTOL, STANDARD_ERRORS, entry_text, label_of, nearest
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
#     quantity = "isolation/resonances_skipped/*"
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
        return Rule(**merged, quantity=path)


def completed(rule: Rule, compare: str) -> Rule:
    """`rule` with the built-in defaults for a comparison of kind `compare` in its gaps."""
    standard = _said(DEFAULT) | ({"rtol": CURVE_RTOL} if compare == "curve" else {})
    return Rule(quantity=rule.quantity, **standard | _said(rule) | {"compare": compare})


def _said(rule: Rule) -> dict[str, Any]:
    """The keys of a rule that say something."""
    said = vars(rule).items()
    return {name: value for name, value in said if value is not None and name != "quantity"}


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
    default, tables = content.get("default", {}), content.get("rule", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        problems.append("`rule` has to be a list of tables: write [[rule]]")
        tables = []
    if not isinstance(default, dict):
        problems.append("`default` has to be a table: write [default]")
        default = {}
    problems += _problems("[default]", default, KEYS.keys() - {"quantity", "compare"})
    for number, table in enumerate(tables, start=1):
        name = f"[[rule]] {number}"
        if "quantity" not in table:
            problems.append(f'{name}: `quantity` is missing, as in quantity = "isolation/*"')
        problems += _problems(name, table, KEYS)
    if problems:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        raise UsageError("\n  ".join([f"{count} in the rules file {path}:", *problems]))
    return Rules(default=Rule(**default), rules=tuple(Rule(**table) for table in tables))


def _problems(where: str, table: dict[str, Any], known: Collection[str]) -> list[str]:
    problems = []
    for key, value in table.items():
        if key not in known:
            names = nearest(key, [name for name in KEYS if name in known])
            problems.append(f"{where}: unknown key `{key}`; known are {', '.join(names)}")
        elif not KEYS[key][0](value):
            problems.append(f"{where}: {key} = {value!r}: has to be {KEYS[key][1]}")
    return problems


def _is_size(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0.0 <= value < math.inf


def _is_amount(value: Any) -> bool:
    from vibecalc.units import split_number

    try:
        digits = split_number(value)[0] if isinstance(value, str) else ""
        return _is_size(float(digits.replace("_", "")) if digits else value)
    except ValueError:
        return False


_SIZE = (_is_size, "a number, zero or more")
_WORDS = ("whole", "entry")
#: key of a rule -> whether a value is fit for it, and what it has to be
KEYS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "quantity": (lambda value: isinstance(value, str) and value != "", "a path or pattern"),
    "rtol": _SIZE,
    "atol": (_is_amount, 'a number, zero or more, also with a unit as in "1e-6 N"'),
    "compare": ([*KINDS].__contains__, f"one of {', '.join(KINDS)}"),
    "relative_to": (_WORDS.__contains__, "one of whole, entry"),
    "floor": _SIZE,
    "shift": _SIZE,
    "repeated": _SIZE,
    "nan_equal": (lambda value: isinstance(value, bool), "true or false"),
}


# ----------------------------------------------------------------------------
# Two quantities on the same entries, by the labels on their axes, and what these may differ by.
# ----------------------------------------------------------------------------

#: axes along which each row is measured by its own size, and so is each point of a sweep
_ROWS = re.compile(r"(?:.*_)?(?:mode|order|condition|operation|harmonic)|sample|.*\..*")
#: how much larger an error estimate may be than that of the reference and still count
_GROWTH = 10.0
#: of the terms that cancel: what the last bits of sums and of their inputs may leave of them
_LAST_DIGITS = 1e-13
_OPTIMISED = "optimisation/variable/"


class Entries(NamedTuple):
    """Compared entries, flat: reference, value, how far apart, and how far they may be.

    `label` writes which entry the one at a place is: that of the worst is all that anybody reads.
    """

    label: Callable[[int], str]
    reference: np.ndarray
    value: np.ndarray
    difference: np.ndarray
    allowed: np.ndarray


def joined(parts: Sequence[Entries]) -> Entries:
    """The entries of all parts."""
    rows = [(part.reference, part.value, part.difference, part.allowed) for part in parts]
    columns = zip(*(rows or [(np.empty(0),) * 4]), strict=True)
    ends = np.cumsum([part.reference.size for part in parts])

    def label(place: int) -> str:
        part = int(np.searchsorted(ends, place, side="right"))
        return parts[part].label(place - (int(ends[part - 1]) if part else 0))

    return Entries(label, *(np.concatenate([one.ravel() for one in column]) for column in columns))


class Pair(NamedTuple):
    """Two quantities under a rule, and the entries that both have.

    `left` of the reference and `right` of the value are over the same `axes`, in the order of the
    reference; before these comes an axis `free` to be unlike in both, if there is one. `problems`
    says what had to be left out.
    """

    reference: Quantity
    value: Quantity
    rule: Rule
    left: np.ndarray
    right: np.ndarray
    axes: tuple[Axis, ...]
    problems: tuple[str, ...]

    @property
    def rtol(self) -> float:
        """That of the rule."""
        return self.rule.rtol or 0.0

    def atol(self, unit: str) -> float:
        """That of the rule in `unit`; UsageError names it where the dimensions do not agree."""
        given = self.rule.atol
        if not isinstance(given, str):
            return float(given or 0.0)
        from vibecalc.units import parse_quantity

        try:
            return parse_quantity(given, unit, difference=True)
        except UnitError as error:
            raise UsageError(
                f"atol = {given!r} does not fit {self.rule.quantity}: {error}"
            ) from error

    def apart(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """|left - right|; infinities of one sign are equal, NaN is only if the rule says so."""
        kind = np.result_type(left, right, float)
        with np.errstate(invalid="ignore", over="ignore"):
            difference = np.abs(np.subtract(left, right, dtype=kind))
        same = (left == right) | (np.isnan(left) & np.isnan(right) & bool(self.rule.nan_equal))
        return np.where(same, 0.0, np.where(np.isnan(difference), math.inf, difference))

    def allowed(
        self, magnitude: np.ndarray, axes: Sequence[Axis], spread: float = 1.0
    ) -> np.ndarray:
        """What entries may differ by: atol + rtol * max(entry, scale) and both error estimates.

        `magnitude` are the sizes of the compared entries, over `axes`; `spread` multiplies the
        error estimates, for entries made of several. Statistics may be four standard errors apart
        instead.
        """
        size = np.where(np.isfinite(magnitude), magnitude, 0.0)
        if self.rule.relative_to == "whole":
            within = tuple(i for i, axis in enumerate(axes) if not _ROWS.fullmatch(axis.name))
            size = np.broadcast_to(size.max(axis=within, keepdims=True, initial=0.0), size.shape)
        margin = self.rtol * size
        allowed = self.atol(self.reference.unit) + spread * self.uncertainty(margin)
        statistics = [one.standard_error for one in (self.reference, self.value)]
        if statistics != [None, None]:
            both = math.hypot(*(one or 0.0 for one in statistics))
            return np.asarray(allowed + STANDARD_ERRORS * spread * both)
        return np.asarray(allowed + margin)

    def uncertainty(self, margin: Any) -> Any:
        """What both error estimates allow together, see `uncertainty`."""
        return uncertainty(self.reference.error_estimate, self.value.error_estimate, margin)

    def grown(self) -> tuple[str, ...]:
        """Words on an error estimate that has grown beyond what the numbers may differ by, if so.

        Such a number is not known as well as the reference, and may be the same by chance.
        """
        one, other = self.reference, self.value
        statistic = one.standard_error is not None or other.standard_error is not None
        size = scale_of(np.abs(one.values)) if is_number(one) else 0.0
        most = self.atol(one.unit) + self.rtol * size
        was, now = float(one.error_estimate), float(other.error_estimate)
        if statistic or now <= _GROWTH * was + most:
            return ()
        return (f"error estimate {was:.1e} became {now:.1e} {one.unit}".rstrip(),)


def align(reference: Quantity, value: Quantity, rule: Rule, free: str = "") -> Pair:
    """The entries that both have; axis names are the same in both, but one may be `free`."""
    left, right = np.asarray(reference.values), np.asarray(value.values)
    axes: list[Axis] = []
    problems: list[str] = []
    first = 0
    for position, (one, other) in enumerate(zip(reference.axes, value.axes, strict=True)):
        if one.name == free:
            first = position
            continue
        from_left, from_right = match_labels(one.values, other.values)
        moved = _shifted(one, other) if len(from_left) < len(one.values) else []
        problems += moved or [
            *_left_out(one, from_left, "is missing"),
            *_left_out(other, from_right, "is not in the reference"),
        ]
        left = left.take(from_left, axis=position)
        right = right.take(from_right, axis=position)
        axes.append(Axis(name=one.name, values=np.asarray(one.values)[from_left], unit=one.unit))
    if free:
        left, right = np.moveaxis(left, first, 0), np.moveaxis(right, first, 0)
    return Pair(reference, value, rule, left, right, tuple(axes), tuple(problems))


def match_labels(left: np.ndarray, right: np.ndarray) -> tuple[list[int], list[int]]:
    """Positions of equal labels: names exactly, numbers within 1e-9 of the larger one.

    A label that occurs twice is matched in order of occurrence.
    """
    pairs: list[tuple[int, int]] = []
    if left.dtype.kind not in "biuf" or right.dtype.kind not in "biuf":
        places: dict[str, list[int]] = {}
        for position, name in enumerate(right):
            places.setdefault(str(name), []).append(position)
        for position, name in enumerate(left):
            if places.get(str(name)):
                pairs.append((position, places[str(name)].pop(0)))
    else:
        order_left, order_right = np.argsort(left, kind="stable"), np.argsort(right, kind="stable")
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


def _shifted(one: Axis, other: Axis) -> list[str]:
    """The largest shift of a physical axis of as many entries, and where; none of bare labels."""
    left, right = np.asarray(one.values), np.asarray(other.values)
    physical = bool(one.unit) and left.dtype.kind == right.dtype.kind == "f"
    if not physical or len(left) != len(right) or not np.isfinite([left, right]).all():
        return []
    shift, size = right - left, np.maximum(np.abs(left), np.abs(right))
    worst, count = (
        int(np.argmax(np.abs(shift))),
        np.count_nonzero(np.abs(shift) > LABEL_RTOL * size),
    )
    return [
        f"axis {one.name}: {count} of {len(left)} entries moved, most by "
        f"{shift[worst]:+.4g} {one.unit}, at {one.name}={entry_text(one, worst)}"
    ]


def _left_out(axis: Axis, shared: list[int], words: str) -> list[str]:
    lost = sorted(set(range(len(axis.values))) - set(shared))
    if not lost:
        return []
    more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
    return [f"{axis.name}={entry_text(axis, lost[0])}{more} {words}"]


def uncertainty(known: float, other: float, margin: Any) -> Any:
    """What the error estimates of the reference (`known`) and the value (`other`) allow together.

    The value's counts up to ten times that of the reference, next to the `margin` that is allowed
    anyway: numbers that got worse do not excuse themselves by saying so. An estimate that is not
    finite allows nothing.
    """
    known = known if math.isfinite(known) else 0.0
    most = _GROWTH * known + margin
    return known + (np.minimum(other, most) if math.isfinite(other) else 0.0 * most)


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
    return float(np.max(magnitude, initial=0.0, where=np.isfinite(magnitude)))


def is_number(quantity: Quantity) -> bool:
    """Whether a quantity holds numbers, and not names."""
    return quantity.values.dtype.kind in "biufc"


# ----------------------------------------------------------------------------
# Entry by entry, as vectors, and by phase: the comparisons that need no matching.
# ----------------------------------------------------------------------------


def by_value(pair: Pair) -> Entries:
    """Each entry for itself; complex entries are points in the plane, names equal or not."""
    left, right, names = pair.left.ravel(), pair.right.ravel(), label_of(pair.axes)
    if not is_number(pair.reference):
        difference = np.where(left.astype(str) == right.astype(str), 0.0, math.inf)
        return Entries(names, left, right, difference, np.zeros(left.shape))
    allowed = pair.allowed(np.abs(pair.left), pair.axes).ravel()
    return Entries(names, left, right, pair.apart(left, right), allowed)


def by_vector(pair: Pair) -> Entries:
    """The entries along the last axis as one vector: length of the difference."""
    if not pair.axes or not is_number(pair.reference):
        return by_value(pair)
    sides = (pair.left, pair.right, pair.apart(pair.left, pair.right))
    left, right, difference = (np.linalg.norm(np.abs(side), axis=-1) for side in sides)
    axes = pair.axes[:-1]
    allowed = pair.allowed(left, axes, spread=math.sqrt(pair.left.shape[-1]))
    return Entries(label_of(axes), *(one.ravel() for one in (left, right, difference, allowed)))


def by_phase(pair: Pair, period: float) -> Entries:
    """Angles modulo one turn, or another period, in rad; `rtol` and `atol` are in rad.

    Of complex entries the angle counts, where the reference is above the amplitude floor; the
    error estimates turn a phase by themselves over the amplitude.
    """
    left, right = pair.left.ravel(), pair.right.ravel()
    label, places = label_of(pair.axes), np.arange(left.size)
    margin = pair.atol("rad") + pair.rtol
    size = scale_of(np.abs(left)) if np.iscomplexobj(left) else 1.0
    errors = pair.uncertainty(pair.rtol * size)
    if np.iscomplexobj(left) and np.iscomplexobj(right):
        places = np.flatnonzero(np.abs(left) > (pair.rule.floor or 0.0) * size)
        left, right = left[places], right[places]
        # A value of zero has no phase: as far off as can be.
        turned = np.where(right == 0, math.pi, np.abs(np.angle(right * np.conj(left))))
        allowed = margin + errors / np.abs(left)
        left, right = np.angle(left), np.angle(right)
    elif pair.reference.unit == "rad":
        turned = np.abs(np.remainder(left - right + period / 2.0, period) - period / 2.0)
        allowed = np.full(left.shape, margin + errors)
    else:
        raise UsageError(
            f"compare = 'phase' does not fit {pair.reference.path}: "
            "it needs complex numbers or angles in rad"
        )
    same = (left == right) | (np.isnan(left) & np.isnan(right) & bool(pair.rule.nan_equal))
    difference = np.where(same, 0.0, np.where(np.isfinite(turned), turned, math.inf))
    return Entries(lambda place: label(int(places[place])), left, right, difference, allowed)
