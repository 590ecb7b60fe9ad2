"""An ideal change from one operation to another at constant speed, within no time."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.response.switching.follow import Transient, follow
from vibecalc.response.switching.free_motion import decay_bound, modal_size
from vibecalc.response.switching.readings import columns, steady_peaks
from vibecalc.response.switching.steady import steady_motion, steady_state
from vibecalc.response.switching.system import Loads, ModalSystem, Piece, modal_loads

#: turns that are shown at least, and at most without being asked
_TURNS, _MOST_TURNS = 8, 5000


def instantaneous(
    system: ModalSystem,
    loads: Loads,
    before: int,
    after: int,
    speed: float,
    *,
    angle: float = 0.0,
    duration: float | None = None,
    buckets: int = 400,
    tolerance: float = 0.05,
) -> Transient:
    """Change from the operation `before` to `after` at the crank angle `angle`, time 0.

    The body has moved steadily under the first; from time 0 the second loads it. The motion is
    the steady one under the second plus the free motion from the difference of the two states,
    in closed form, for modes below, at and above critical damping. Parameters and errors are those
    of `follow`; without a `duration` (s) it is as long as the free motion may take to settle.

    Raises
    ------
    NumericalFailure
        As `follow`, or settling takes more than 5000 turns and no duration is given.
    """
    if duration is None:
        duration = _until_settled(system, loads, before, after, speed, angle, tolerance)
    pieces = [Piece(duration, speed, speed, after)]
    return follow(
        system, loads, pieces, angle=angle, before=before, buckets=buckets, tolerance=tolerance
    )


def _until_settled(
    system: ModalSystem,
    loads: Loads,
    before: int,
    after: int,
    speed: float,
    angle: float,
    tolerance: float,
) -> float:
    modal = modal_loads(system, loads)
    old, new = (steady_motion(system, modal, which, speed) for which in (before, after))
    at = np.asarray(angle)
    states = [steady_state(motion, modal.orders, speed, at) for motion in (old, new)]
    size = modal_size(system, states[0] - states[1])
    peaks: WithError = steady_peaks(system, new, modal.orders, speed)
    whole = np.sqrt(2.0 * peaks.value[columns(len(system.shape)).energy])
    whole = max(float(whole), float(np.sqrt(np.sum(modal_size(system, states[0]) ** 2))))
    turn = 2.0 * np.pi / abs(speed)
    factor, rate = decay_bound(system)
    # each mode down to its share of the tolerance
    excess = factor * size * np.sqrt(len(size))
    level = tolerance * whole
    lasting = excess > level
    times = np.log(excess[lasting] / level) / rate[lasting] if np.any(lasting) else np.zeros(1)
    longest = float(np.max(times))
    if not longest <= _MOST_TURNS * turn:
        raise NumericalFailure(
            f"after the change the body swings for about {longest:.3g} s before it settles, "
            f"{longest / turn:.3g} turns; give the duration to be followed, or more damping"
        )
    return max(1.2 * longest, _TURNS * turn)
