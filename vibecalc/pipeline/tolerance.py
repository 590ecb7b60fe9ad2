"""Did every result reach `[accuracy] rtol`? What did not is said, with what it reached."""

import numpy as np

from vibecalc.results.record import Quantity, Record

MOST_NAMES = 4
#: a magnitude of a few error estimates is what cancelling leaves
ZERO = 4.0
#: sums that are there to show what cancels
CANCELLING = "excitation/balance/"
#: where a summit stands: it is flat there, so that half the digits of its height are known
PLACES = ("/peak_time", "/peak_speed", "/worst_angle")
#: a chaotic motion: what counts of its statistics is their standard error
CHAOTIC = "response/impact/"

_ORDERS = "where too few orders are kept, more help ([excitation] orders)"
_RESONANCE = "beside an undamped resonance only damping does"
_CANCELS = "what is left of large numbers that cancel has no more digits to give"
#: what helps, by the beginnings of paths; the first that fits counts
_ADVICE = (
    (("response/modes/", "isolation/modes/", "isolation/support_force/static"), (_CANCELS,)),
    (("kinematics/", "excitation/", "response/switching/"), (_ORDERS,)),
    (("isolation/", "response/", "optimisation/"), (_ORDERS, _RESONANCE)),
)


def reached(quantity: Quantity) -> float | None:
    """Error estimate over the largest finite magnitude; None for what cancels to zero.

    A total that cancels has no relative accuracy: its estimate says that it is zero. Neither has a
    statistic, whose standard error is far above what the numbers cost.
    """
    size = np.abs(quantity.values)
    largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
    if largest <= ZERO * quantity.error_estimate or quantity.path.startswith(CANCELLING):
        return None
    if quantity.path.endswith(PLACES):
        return None
    if quantity.standard_error is not None or quantity.path.startswith(CHAOTIC):
        return None
    return quantity.error_estimate / largest


def tolerance_warning(record: Record, rtol: float) -> str | None:
    """One sentence that names the results with a relative error estimate above `rtol`."""
    relative = {path: reached(quantity) for path, quantity in record.items()}
    missed = {path: share for path, share in relative.items() if share is not None and share > rtol}
    if not missed:
        return None
    worst = sorted(missed, key=lambda path: -missed[path])
    named = ", ".join(f"{path} ({missed[path]:.1e})" for path in worst[:MOST_NAMES])
    more = f" and {len(worst) - MOST_NAMES} more" if len(worst) > MOST_NAMES else ""
    return (
        f"not within rtol = {rtol:g} of their largest magnitude, by their error estimates: "
        f"{named}{more}; {_advice(worst)}"
    )


def _advice(paths: list[str]) -> str:
    """What helps these results, each thing said once."""
    fitting = [
        next((words for starts, words in _ADVICE if path.startswith(starts)), (_CANCELS,))
        for path in paths
    ]
    said = [words for words in (_ORDERS, _RESONANCE, _CANCELS) if any(words in w for w in fitting)]
    return "; ".join(said)
