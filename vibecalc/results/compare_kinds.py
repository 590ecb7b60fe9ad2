"""Entry by entry, as vectors, and by phase: the comparisons that need no matching."""

import math

import numpy as np

from vibecalc.errors import UsageError
from vibecalc.results.align import Aligned, Entries, labels
from vibecalc.results.record import Quantity, Record
from vibecalc.results.rules import Rule, absolute_tolerance

#: standard errors that two statistics may be apart
_STANDARD_ERRORS = 4.0
#: how much larger an error estimate may be than that of the reference and still count
_GROWTH = 10.0
#: of the terms that cancel: what the last bits of sums and of their inputs may leave of them
_LAST_DIGITS = 1e-13
_FOUND = "optimisation/variable/"


def by_value(aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule) -> Entries:
    """Each entry for itself; complex entries are points in the plane, names equal or not."""
    left, right = aligned.reference.ravel(), aligned.value.ravel()
    names = labels(aligned.axes)
    if left.dtype.kind not in "biufc":
        difference = np.where(left.astype(str) == right.astype(str), 0.0, math.inf)
        return Entries(names, left, right, difference, np.zeros(left.shape))
    allowed = tolerance(np.abs(left), reference, value, rule)
    return Entries(names, left, right, apart(left, right, rule), allowed)


def by_vector(aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule) -> Entries:
    """The entries along the last axis as one vector: length of the difference."""
    if not aligned.axes or aligned.reference.dtype.kind not in "biufc":
        return by_value(aligned, reference, value, rule)
    count = math.sqrt(aligned.reference.shape[-1])
    difference = np.linalg.norm(apart(aligned.reference, aligned.value, rule), axis=-1).ravel()
    left = np.linalg.norm(np.abs(aligned.reference), axis=-1).ravel()
    right = np.linalg.norm(np.abs(aligned.value), axis=-1).ravel()
    allowed = tolerance(left, reference, value, rule, spread=count)
    return Entries(labels(aligned.axes[:-1]), left, right, difference, allowed)


def by_phase(aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule) -> Entries:
    """Angles modulo one turn, in rad; `rtol` and `atol` are in rad.

    Of complex entries the angle counts, where the reference is above the amplitude floor; the
    error estimates turn a phase by themselves over the amplitude.
    """
    names = labels(aligned.axes)
    left, right = aligned.reference.ravel(), aligned.value.ravel()
    margin = absolute_tolerance(rule, "rad") + (rule.rtol or 0.0)
    errors = _doubt(reference, value, rule)
    if np.iscomplexobj(left) and np.iscomplexobj(right):
        amplitude = np.abs(left)
        kept = np.flatnonzero(amplitude > (rule.floor or 0.0) * scale_of(amplitude))
        left, right = left[kept], right[kept]
        names = tuple(names[position] for position in kept)
        # A value of zero has no phase: as far off as can be.
        turned = np.where(right == 0, math.pi, np.abs(np.angle(right * np.conj(left))))
        allowed = margin + errors / np.abs(left)
        left, right = np.angle(left), np.angle(right)
    elif reference.unit == "rad":
        turned = np.abs(np.remainder(left - right + math.pi, 2.0 * math.pi) - math.pi)
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
    magnitude: np.ndarray, reference: Quantity, value: Quantity, rule: Rule, spread: float = 1.0
) -> np.ndarray:
    """What entries may differ by: atol + rtol * max(entry, scale) and both error estimates.

    `magnitude` are the sizes of the compared entries; `spread` multiplies the error estimates,
    for entries made of several. Statistics may be four standard errors apart instead.
    """
    errors = spread * _doubt(reference, value, rule)
    allowed = absolute_tolerance(rule, reference.unit) + errors
    if reference.standard_error is not None or value.standard_error is not None:
        both = math.hypot(reference.standard_error or 0.0, value.standard_error or 0.0)
        return np.full(magnitude.shape, allowed + _STANDARD_ERRORS * spread * both)
    size = np.where(np.isfinite(magnitude), magnitude, 0.0)
    if rule.relative_to == "whole":
        size = np.full(magnitude.shape, scale_of(magnitude))
    return allowed + (rule.rtol or 0.0) * size


def doubt(known: float, own: float, margin: float) -> float:
    """What the error estimates of the reference (`known`) and the value (`own`) allow together.

    The value's counts up to ten times that of the reference, beside the `margin` that is allowed
    anyway: numbers that got worse do not excuse themselves by saying so. An estimate that is not
    finite allows nothing.
    """
    known = known if math.isfinite(known) else 0.0
    return known + (min(own, _GROWTH * known + margin) if math.isfinite(own) else 0.0)


def last_digits(reference: Record) -> float:
    """How much of the terms that cancel may be left: of sums, and of inputs that a search found.

    A search says to how much of itself it knows what it found, an angle to how much of a radian;
    so do both of two results.
    """
    shares = [0.0]
    for path in (path for path in reference if path.startswith(_FOUND)):
        found = reference[path]
        size = 1.0 if found.unit == "rad" else abs(float(found.values))
        if size > 0.0:
            shares.append(found.error_estimate / size)
    return _LAST_DIGITS + 2.0 * max(shares)


def scale_of(magnitude: np.ndarray) -> float:
    """Largest finite entry, zero if there is none."""
    finite = magnitude[np.isfinite(magnitude)]
    return float(finite.max()) if finite.size else 0.0


def _doubt(reference: Quantity, value: Quantity, rule: Rule) -> float:
    numbers = reference.values.dtype.kind in "biufc"
    scale = scale_of(np.abs(reference.values)) if numbers else 0.0
    return doubt(reference.error_estimate, value.error_estimate, (rule.rtol or 0.0) * scale)


def _common(left: np.ndarray, right: np.ndarray) -> type:
    return complex if np.iscomplexobj(left) or np.iscomplexobj(right) else float
