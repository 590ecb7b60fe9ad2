"""How much damping of the primary system leaves nothing to gain from an absorber: largest response.

Where the largest response lies at a finite frequency, a weak damper on a free secondary lowers it:
to first order |H| changes by the factor 1 - 4 z1 z2 x^2 / |1 - x^2 + 2 i z1 x|^2, below one. It is
of no use where the largest response is the limit at x = 0 (nothing but K1 acts) or at x -> infinity
(nothing but J1 acts), which no spring and damper to a secondary changes. The threshold is the
damping at which the primary system alone comes down to that limit, and so is the same for every
mass ratio.
"""

import math
from typing import NamedTuple

from vibecalc.errors import NumericalFailure
from vibecalc.response.absorber.model import transfer_of


class Threshold(NamedTuple):
    """`primary_damping` from which on no absorber helps: infinite (none), a number, or zero.

    `exact` is the number in words, `why` the reason. `bounded_damped`: the largest response is
    finite with a damped primary system; where it is not, there is no optimum to be had.
    """

    primary_damping: float
    exact: str
    why: str
    bounded_damped: bool = True


_NONE = "the peak lies at a finite frequency for every damping, and a weak damper lowers it"
_SLOW = "from there on the largest response is the static one, which no absorber changes"
_FAST = (
    "from there on the largest response is the limit at high frequency, where the inertia J1 acts "
    "alone; only a mass fastened rigidly lowers it, to 1 / (1 + m) of it"
)
_GROWS = "with damping in the primary system the response grows with frequency without bound"
_ALWAYS = "the response grows with frequency without bound, damped or not"
_ROOT = 1.0 / math.sqrt(2.0)
_NEVER = Threshold(math.inf, "none", _NONE)
_UNBOUND = Threshold(0.0, "0", _GROWS, False)

_TABLE = {
    ("force", "displacement"): Threshold(_ROOT, "1 / sqrt 2", _SLOW),
    ("force", "velocity"): _NEVER,
    ("force", "acceleration"): Threshold(_ROOT, "1 / sqrt 2", _FAST),
    ("force", "transmitted_force"): _NEVER,
    ("base", "displacement"): _NEVER,
    ("base", "velocity"): Threshold(
        0.5 * math.sqrt(1.0 + math.sqrt(2.0)), "sqrt(1 + sqrt 2) / 2",
        "from there on the largest response is the limit 2 z1 at high frequency, where c1 drives J1"
        " alone; only a mass fastened rigidly lowers it",
    ),
    ("base", "acceleration"): _UNBOUND,
    ("base", "transmitted_force"): _UNBOUND,
    ("unbalance", "displacement"): Threshold(_ROOT, "1 / sqrt 2", _FAST),
    ("unbalance", "velocity"): Threshold(0.0, "0", _ALWAYS, False),
    ("unbalance", "acceleration"): Threshold(0.0, "0", _ALWAYS, False),
    ("unbalance", "transmitted_force"): _UNBOUND,
}  # fmt: skip


def threshold(excitation: str = "force", response: str = "displacement") -> Threshold:
    """Threshold for the largest response (H-infinity), the same for every mass ratio.

    Raises NumericalFailure for a response of the secondary: locked, it has no relative motion,
    and its own motion is not what an absorber is for.
    """
    transfer_of(excitation, response)  # refuses unknown names
    found = _TABLE.get((excitation, response))
    if found is None:
        raise NumericalFailure(f"{response} is no response of the primary system: no threshold")
    return found
