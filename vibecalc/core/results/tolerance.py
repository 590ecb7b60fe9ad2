"""Did every result reach `[accuracy] rtol`? What did not is said, with what it reached."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.record import ROUNDING, Quantity, Record

MOST_NAMES = 4
#: what a result is called that its error exceeds
UNRESOLVED = "unresolved"
#: a magnitude of a few error estimates is what cancelling leaves
ZERO = 4.0
#: sums that are there to show what cancels
CANCELLING = "excitation/balance/"
#: zero for the exact solution, so that all of it is error
CHECKS = (
    *("/certificate", "_residual", "energy/residual"),
    *("measurement/fit/misfit", "measurement/signal/residual", "measurement/reading/residual"),
)
#: where a peak stands: it is flat there, so that half the digits of its height are known
PLACES = ("/peak_time", "/peak_speed", "/worst_angle", "_peak_time")
#: a chaotic motion: what counts of its statistics is their standard error
CHAOTIC = "response/impact/"
#: differences of results, whose digits are those of what is left of them; so is the least motion of
#: a plate, where translation and rotation cancel but for what is out of phase
DIFFERENCES = (
    "measurement/quiet/amplitude",
    "measurement/quiet/all_orders_amplitude",
    "response/roll/sensitivity/",
    "response/roll/classical/",
    "response/roll/method/",
    "/interpolation/spread",
    "response/roll/motor/table/",
    "/motor/worst_difference",
    "/motor/rms_difference",
    "/motor/fit_change",
    "/motor/dynamics_change",
    "tuning/sensitivity/",
    "tuning/active/",
    "hardware/buy/penalty",
    "hardware/damper_pair/penalty",
    "tuning/each/",
    "pendulum/jump/swing",
)

#: levels and phases of harmonics: of a weak one they show an error that is small next to the
#: largest
SPECTRA = ("response/roll/level/", "response/roll/phase_lag/")
#: works of one turn, of which that of the motor feeds the others
ENERGIES = "response/roll/energy/"

#: where a search ends, and what its bounds are worth there: a minimum is flat
SEARCHED = tuple(
    f"response/control/tuned/{name}"
    for name in ("gain", "acceleration_feedback", "speed_feedback", "multiplier", "residual")
)
#: the largest of what is examined
EVALUATED = ("response/control/full/largest_slip",)

#: read off a march in time by looking at it (as well as the looks are close together), and borders
#: of start angles, which are enclosed to a width of their own
MARCH = "response/start_up/"
LOOKED = ("_peak", "_low", "_high", "/turn/shell_acceleration")

#: uncertainties of what was read, of which two digits tell all; bounds are searched for
UNCERTAIN = ("measurement/uncertainty/", "measurement/candidate/level_bound")

#: of a shaft line: read off a march in time by looking at it, first orders of a small quantity,
#: differences of nearly equal responses, maps for pictures, ends of searches and their prices
LINE_STUDIES = (
    *(
        f"response/torsion/transient/{name}"
        for name in ("torque_", "peak", "half_range", "quasi_steady", "steady_", "overshoot")
    ),
    *(f"response/torsion/transient/{name}" for name in ("lag", "dynamic_factor")),
    *(
        f"response/torsion/variable_inertia/{name}"
        for name in ("wedge/", "unstable/", "relative_variation", "change", "largest_change")
    ),
    *(f"response/torsion/variable_inertia/{name}" for name in ("secondary/", "speeds/change")),
    "response/torsion/variable_inertia/growth",
    *(f"damper_design/{name}" for name in ("chart/", "basin/", "active/", "pull", "sensitivity")),
    *(f"damper_design/{name}" for name in ("stiffness", "damping", "own_", "ring/")),
    *(f"damper_design/{name}_speed" for name in ("worst", "heat", "travel")),
    *(f"damper_design/table/{name}_speed" for name in ("worst", "heat", "travel")),
)

_ORDERS = "where too few orders are kept, more help ([excitation] orders)"
#: results that mean all orders, whose error counts those that [excitation] orders leaves out
_CUT = ("kinematics/", "excitation/", "isolation/", "response/", "optimisation/")
_UNCUT = ("response/torsion/", "response/roll/", "response/control/", "response/start_up/")
_RESONANCE = "next to an undamped resonance only damping does"
_CANCELS = "what is left of large numbers that cancel has no more digits to give"
_MARCH = "a march in time keeps to the tolerance in each step, not over all of them"
#: what helps, by the beginnings of paths; the first that fits counts
_ADVICE = (
    (("response/roll/", "response/control/"), (_CANCELS,)),
    ((MARCH,), (_MARCH,)),
    (("response/modes/", "isolation/modes/", "isolation/support_force/static"), (_CANCELS,)),
    (("response/torsion/",), (_CANCELS, _RESONANCE)),
    (("kinematics/", "excitation/", "response/switching/"), (_ORDERS,)),
    (("isolation/", "response/", "optimisation/"), (_ORDERS, _RESONANCE)),
)


def reached(quantity: Quantity, record: Record | None = None) -> float | None:
    """Error estimate over the largest finite magnitude; None for what cancels to zero.

    With the `record` a part of a balance is measured by the whole of it, and levels and phases of
    harmonics by these themselves, in whose place they stand.

    A total that cancels to rounding of its terms has no relative accuracy: its estimate says that
    it is zero. Where more than rounding hides a value it is infinite or above 1, and missed.
    Neither has a statistic, whose standard error is far above what the numbers cost.
    """
    size = np.abs(quantity.values)
    largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
    error = quantity.error_estimate
    if cancels(quantity) or quantity.path.startswith(CANCELLING):
        return None
    if quantity.path.endswith(CHECKS):
        return None
    if record is not None and _harmonics(quantity.path) in record:
        return None
    if record is not None and quantity.path.startswith(ENERGIES):
        whole = record.get(f"{ENERGIES}motor")
        largest = max(largest, 0.0 if whole is None else float(np.max(np.abs(whole.values))))
    if quantity.path.endswith(PLACES) or any(part in quantity.path for part in DIFFERENCES):
        return None
    if quantity.path.startswith(UNCERTAIN) or quantity.path in (*SEARCHED, *EVALUATED):
        return None
    if quantity.path.startswith(LINE_STUDIES):
        return None
    if quantity.standard_error is not None or quantity.path.startswith(CHAOTIC):
        return None
    if quantity.path.startswith(MARCH) and (
        quantity.path.endswith(LOOKED) or "/start_angles/" in quantity.path
    ):
        return None
    return float(error) / largest if largest else np.inf


def cancels(quantity: Quantity) -> bool:
    """Whether all entries are what cancelling leaves: a few error estimates, these of rounding."""
    size, error = np.abs(quantity.values), quantity.estimate
    largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
    if largest == 0.0:
        return error.is_zero(0.0)
    return largest <= ZERO * float(error) and error <= ROUNDING * error.terms


def _harmonics(path: str) -> str:
    """Path of the harmonics whose levels or phases stand under `path`; empty for other results."""
    stem = next((stem for stem in SPECTRA if path.startswith(stem)), "")
    return f"response/roll/{path.removeprefix(stem)}" if stem else ""


def tolerance_warning(record: Record, rtol: float) -> str | None:
    """One sentence that names the results with a relative error estimate above `rtol`."""
    relative = {path: reached(quantity, record) for path, quantity in record.items()}
    missed = {path: share for path, share in relative.items() if share is not None and share > rtol}
    if not missed:
        return None
    worst = sorted(missed, key=lambda path: -missed[path])
    shares = {path: f"{share:.1e}" if share < 1.0 else UNRESOLVED for path, share in missed.items()}
    named = ", ".join(f"{path} ({shares[path]})" for path in worst[:MOST_NAMES])
    more = f" and {len(worst) - MOST_NAMES} more" if len(worst) > MOST_NAMES else ""
    return (
        f"not within rtol = {rtol:g} of their largest magnitude, by their error estimates: "
        f"{named}{more}; {_advice(worst)}"
    )


def remedy(quantity: Quantity, case: Mapping[str, Any]) -> str:
    """What would make the error of a result smaller, in words: where it comes from tells."""
    path, error = quantity.path.removeprefix("optimisation/start/"), quantity.estimate
    if quantity.standard_error:
        return "more members or revolutions in [response.impact], whose scatter is the error"
    orders = (case.get("excitation") or {}).get("orders")
    if orders is not None and path.startswith(_CUT) and not path.startswith(_UNCUT):
        return f"more orders than [excitation] orders = {orders} keeps"
    if error <= ROUNDING * error.terms:
        return "nothing but another bound (the value lies on it to rounding)"
    rtol = (case.get("accuracy") or {}).get("rtol")
    return "a smaller [accuracy] rtol" + ("" if rtol is None else f" than {rtol:g}")


def _advice(paths: list[str]) -> str:
    """What helps these results, each thing said once."""
    fitting = [
        next((words for starts, words in _ADVICE if path.startswith(starts)), (_CANCELS,))
        for path in paths
    ]
    every = (_ORDERS, _RESONANCE, _CANCELS, _MARCH)
    said = [words for words in every if any(words in w for w in fitting)]
    return "; ".join(said)


# ----------------------------------------------------------------------------
# How many results reach `[accuracy] rtol`, which one is worst, and which are not held to it.
# ----------------------------------------------------------------------------

#: why results are not held to the tolerance, by the beginnings of their paths; the first that fits
_STARTS: tuple[tuple[tuple[str, ...], str], ...] = (
    ((CANCELLING,), "sums that are there to show what cancels"),
    (SPECTRA, "levels and phases, for which the harmonics behind them stand"),
    (UNCERTAIN, "uncertainties, of which two digits tell all"),
    (SEARCHED, "ends of searches, where a minimum is flat"),
    (EVALUATED, "the largest of what is examined"),
    (LINE_STUDIES, "marches in time, differences, maps and ends of searches of a shaft line"),
    ((CHAOTIC,), "statistics, whose standard error is far larger"),
)
_PLACE = "places of peaks, which are flat there"
_DIFFERENCE = "differences of results, with the digits that are left"
_LOOKED = "read off a march in time, as well as its steps show"
_CHECK = "checks that are zero for the exact solution, so that all of them is error"
_ZERO = "zero to rounding of their own terms"


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
    exempt: dict[str, int] = {}
    for path, quantity in record.items():
        if not _has_error(quantity):
            continue
        own = reached(quantity, record)
        if own is None:
            why = _why(quantity)
            exempt[why] = exempt.get(why, 0) + 1
            continue
        held, met = held + 1, met + int(own <= rtol)
        if own > share:
            worst, share = path, own
    ranked = sorted(exempt.items(), key=lambda one: (-one[1], one[0]))
    return ToleranceSummary(rtol, held, met, worst, max(share, 0.0), tuple(ranked))


def _has_error(quantity: Quantity) -> bool:
    return quantity.values.size > 0 and quantity.values.dtype.kind in "fc"


def _why(quantity: Quantity) -> str:
    path = quantity.path
    if not cancels(quantity) and path.endswith(CHECKS):
        return _CHECK
    for starts, words in _STARTS:
        if path.startswith(starts):
            return words
    if path.endswith(PLACES):
        return _PLACE
    if any(part in path for part in DIFFERENCES):
        return _DIFFERENCE
    if quantity.standard_error is not None:
        return _STARTS[-1][1]
    if path.startswith(MARCH) and (path.endswith(LOOKED) or "/start_angles/" in path):
        return _LOOKED
    return _ZERO
