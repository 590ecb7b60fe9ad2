"""Did every result reach `[accuracy] rtol`? What did not is said, with what it reached."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE, DIAGNOSTICS, HELPS, TURNING
from vibecalc.core.results.record import (
    AT_START,
    CANCELS,
    CHECK,
    ORDERS,
    ROUNDING,
    SPECTRUM,
    STATISTIC,
    TURN,
    UNCERTAINTY,
    Entry,
    Quantity,
    Record,
)

MOST_NAMES = 4
#: what a result is called that its error exceeds
UNRESOLVED = "unresolved"
#: a magnitude of a few error estimates is what cancelling leaves
ZERO = 4.0
_NO_SCALE = "zero to rounding"
#: that of an optimum, in any of the methods
_BALANCE = "/kkt_residual"
#: begins the paths of results at the start of a search, and of a machine that it has found
#: all of a fit, whose points may lie between the samples of curves
_OF_FIT = "fit/"
_SEARCH = re.compile(f"{AT_START}|find/[^/]+/machine/")


def reached(quantity: Quantity, record: Record | None = None) -> float | None:
    """Error estimate over the largest finite magnitude; None for what is not held to a tolerance.

    With the `record` a part of a balance is measured by the whole of it, and levels and phases of
    harmonics by these themselves, in whose place they stand.

    A total that cancels to rounding of its terms has no relative accuracy: its estimate says that
    it is zero. Where more than rounding hides a value it is infinite or above 1, and missed.
    """
    if why_exempt(quantity, record):
        return None
    largest, whole = _largest(quantity), _whole(quantity.path)
    if record is not None and whole in record:
        largest = max(largest, _largest(record[whole]))
    return float(quantity.error_estimate) / largest if largest else np.inf


def why_exempt(quantity: Quantity, record: Record | None = None) -> str:
    """Why a result is not held to the tolerance, empty if it is."""
    known = entry_of(quantity.path)
    reason = CHECK if is_check(quantity.path) else known.exempt if known else ""
    if reason == SPECTRUM and (record is None or _harmonics(quantity.path) not in record):
        reason = ""
    if reason != CHECK and cancels(quantity):
        return _NO_SCALE
    if quantity.path.startswith(_OF_FIT):
        return UNCERTAINTY
    return reason or STATISTIC * (quantity.standard_error is not None)


def is_check(path: str) -> bool:
    """Whether a result is zero for the exact solution."""
    known = entry_of(path)
    return known.exempt == CHECK if known else path.endswith(_BALANCE)


def entry_of(path: str) -> Entry | None:
    """What the catalogue has of a result, also of one of a machine that a search has met."""
    return CATALOGUE.get(path[_begin(path) :])


def is_diagnostic(path: str) -> bool:
    """Whether a result hangs on rounding and on the path of a search, so that none is the same."""
    known = entry_of(path)
    return known.diagnostic if known else _fits(path, DIAGNOSTICS)


def circle_of(quantity: Quantity) -> str:
    """After what an angle is the same: `TURN`, `CYCLE`, or empty for what is no such angle."""
    known = entry_of(quantity.path)
    if known is not None:
        return known.circle
    return TURN if quantity.unit == "rad" and _fits(quantity.path, TURNING) else ""


def _fits(path: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(path, pattern) for pattern in patterns)


def _begin(path: str) -> int:
    """Where the own path of a result begins, after that of a search."""
    found = _SEARCH.match(path)
    return found.end() if found else 0


def _whole(path: str) -> str:
    """Path of the result that one is a part of."""
    known = entry_of(path)
    return path[: _begin(path)] + known.part_of if known and known.part_of else ""


def _harmonics(path: str) -> str:
    """Path of the harmonics of which levels or phases stand under `path`."""
    folder, _, name = path.rpartition("/")
    return f"{folder.rpartition('/')[0]}/{name}"


def _largest(quantity: Quantity) -> float:
    size = np.abs(quantity.values)
    return float(np.max(size, initial=0.0, where=np.isfinite(size)))


def cancels(quantity: Quantity) -> bool:
    """Whether all entries are what cancelling leaves: a few error estimates, these of rounding."""
    largest, error = _largest(quantity), quantity.estimate
    if largest == 0.0:
        return error.is_zero(0.0)
    return largest <= ZERO * float(error) and error <= ROUNDING * error.terms


def tolerance_warning(record: Record, rtol: float) -> str | None:
    """One sentence that names the results with a relative error estimate above `rtol`."""
    relative = {path: reached(quantity, record) for path, quantity in record.items()}
    missed = {path: share for path, share in relative.items() if share is not None and share > rtol}
    if not missed:
        return None
    worst = sorted(missed, key=lambda path: -missed[path])
    shares = {path: f"{share:.1e}" if share < 1.0 else UNRESOLVED for path, share in missed.items()}
    named = ", ".join(f"{path} ({shares[path]})" for path in worst[:MOST_NAMES])
    # each thing that helps is said once
    advice = "; ".join(dict.fromkeys(words for path in worst for words in helps(path)))
    more = f" and {len(worst) - MOST_NAMES} more" if len(worst) > MOST_NAMES else ""
    return f"accuracy not reached (relative error above rtol = {rtol:g}): {named}{more}; {advice}"


def remedy(quantity: Quantity, case: Mapping[str, Any]) -> str:
    """What would make the error of a result smaller, in words: where it comes from tells."""
    error = quantity.estimate
    if quantity.standard_error:
        return "more members or revolutions in [response.impact] (the error is statistical)"
    orders = (case.get("excitation") or {}).get("orders")
    if orders is not None and ORDERS in helps(quantity.path):
        return f"more orders in [excitation] (now {orders})"
    if error <= ROUNDING * error.terms:
        return "only another bound (the value equals it to rounding)"
    rtol = (case.get("accuracy") or {}).get("rtol")
    return "a smaller [accuracy] rtol" + ("" if rtol is None else f" than {rtol:g}")


def helps(path: str) -> tuple[str, ...]:
    """What lets a result meet the tolerance."""
    beginning = path[_begin(path) :]
    fitting = [start for start in HELPS if beginning.startswith(start)]
    return HELPS[max(fitting, key=len)] if fitting else (CANCELS,)


# ----------------------------------------------------------------------------
# How many results reach `[accuracy] rtol`, which one is worst, and which are not held to it.
# ----------------------------------------------------------------------------


class ToleranceSummary(NamedTuple):
    """Of all results with entries: how many are held to `rtol`, how many of these `met` it.

    `worst` is the path with the largest error estimate over size (`share`), empty for none;
    `exempt` pairs reasons with how many results they keep from being held to it.
    """

    rtol: float
    held: int
    met: int
    worst: str
    share: float
    exempt: tuple[tuple[str, int], ...]


def summarised(record: Record, rtol: float) -> ToleranceSummary:
    """Read off the error estimates of a record; what is exempt is decided by `tolerance.reached`.

    Counts, numbers of rows and texts, which have no error, are neither held nor exempt.
    """
    worst, share, held, met = "", -1.0, 0, 0
    exempt: Counter[str] = Counter()
    for path, quantity in record.items():
        if not quantity.values.size or quantity.values.dtype.kind not in "fc":
            continue
        share_reached = reached(quantity, record)
        if share_reached is None:
            exempt[why_exempt(quantity, record)] += 1
            continue
        held, met = held + 1, met + int(share_reached <= rtol)
        if share_reached > share:
            worst, share = path, share_reached
    ranked = sorted(exempt.items(), key=lambda one: (-one[1], one[0]))
    return ToleranceSummary(rtol, held, met, worst, max(share, 0.0), tuple(ranked))
