"""The highest peaks of the run-ups of many points of a sweep at once."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.isolation.adapters.body_run_up import run_up_rows
from vibecalc.isolation.adapters.common import emit_run_up_peaks, isolation_of
from vibecalc.isolation.rows import Jet, Readout, body_rows, with_left_out
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest_peaks
from vibecalc.isolation.run_up_poles import pole_sums
from vibecalc.isolation.run_up_samples import Machines
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.response.modal_damping import damped_poles
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import MaskedSpeeds, Resonances
from vibecalc.response.system import MountedBody

#: machines times orders that are worked on at once
_MOST_AT_ONCE = 600

#: some of the machines (n,) and the range of speeds in rad/s that they pass
Some = Callable[[np.ndarray, float, float], Machines]


def run_up_peaks(scene: PointsScene) -> None:
    """Emit the highest peak of each point and its speed; points with a mode that nothing damps are
    run alone."""
    span = isolation_of(scene).run_up
    if span is None:
        raise ValueError("the case has no run-up")
    forcing: Forcing = scene.handed_on["forcing"]
    system = scene.handed_on["on_mounts"]
    read = run_up_rows(scene, system)
    some, alone = machines_of_bodies(
        scene.count, system.matrices, system.shapes, read.rows, forcing.order,
        system.felt(forcing.per_speed_squared), forcing.retained, *few_orders(forcing),
    )  # fmt: skip
    scene.alone |= alone
    machines = np.flatnonzero(~scene.alone)
    peak = RunUpPeak(*np.zeros((4, scene.count, read.rows.still.shape[-3])))
    for whole, part in zip(peak, peaks_of(some, machines, span.start, span.stop), strict=True):
        whole[machines] = part
    results = RunUpPeak(*(part[:, read.row_of] for part in peak))
    emit_run_up_peaks(scene, results, read.lever_rows)


def peaks_of(some: Some, machines: np.ndarray, start: float, stop: float) -> RunUpPeak:
    """Highest peaks (n, rows) of some of the machines (n,) in a range of speeds in rad/s."""
    none = some(machines[:0], start, stop)
    step = max(_MOST_AT_ONCE // len(none.orders), 1)
    parts = [list(np.zeros((4, 0, none.rows)))]
    for first in range(0, len(machines), step):
        given = some(machines[first : first + step], start, stop)
        parts.append([part.reshape(-1, given.rows) for part in highest_peaks(given)])
    return RunUpPeak(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def machines_of_bodies(
    count: int,
    matrices: Linear,
    shapes: Modes,
    readout: Readout,
    orders: np.ndarray,
    load: Bounded,
    used: int,
    few: np.ndarray,
    tail: np.ndarray | float,
) -> tuple[Some, np.ndarray]:
    """Run-ups of some of `count` bodies, and which bodies have to be run alone (count,).

    `load` (..., orders, f) is per squared crank speed; the first `used` orders are kept, those at
    the places `few` stand, `tail` times, for what is left out.
    """

    def each(own: int, *parts: np.ndarray) -> list[np.ndarray]:
        """Parts with `own` axes of each body."""
        return [np.broadcast_to(part, (count, *part.shape[part.ndim - own :])) for part in parts]

    still, rising = each(3, *readout[:2])
    readout = readout._replace(still=still, rising=rising)
    load, matrices = Bounded(*each(2, *load)), Linear(*each(2, *matrices))
    shapes = Modes(
        *(each(own, part)[0] for part, own in zip(shapes, (1, 1, 2, 2, 1, 1), strict=True))
    )
    tail = np.broadcast_to(tail, count)
    first, rows = load[:, :used], readout.still.shape[1]
    system, poles = MountedBody(matrices=matrices, shapes=shapes), damped_poles(matrices, shapes)
    met = system.resonances(first)
    found = system.with_poles(met, first, poles).sought()
    sums, dependent = pole_sums(poles, shapes, readout, orders[:used], first)
    none = np.zeros(0)

    def some(members: np.ndarray, start: float, stop: float) -> Machines:
        def jets_at(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
            machine = members[row // rows]
            own = Linear(*(part[machine] for part in matrices))
            read = readout.rows(machine[:, None], (row % rows)[:, None])
            kept, beyond = (
                body_rows(own, read, orders[which], load[machine][:, which])
                for which in (slice(used), few)
            )
            at = with_left_out(kept, beyond, tail[machine], orders[few])
            jet = at(speed, slopes=True, errors=errors)
            return Jet(*(part[:, 0] if part.size else part for part in jet))

        def look(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
            return sums.jets(members[row // rows], speed, row % rows)

        return Machines(
            jets_at, lambda machine, speed: sums.values(members[machine], speed), orders[:used],
            start, stop, Resonances(*(part[members] for part in found[:4])), rows,
            MaskedSpeeds(none, none, none, none, none), np.zeros(len(members) * rows, dtype=bool),
            look,
        )  # fmt: skip

    return some, np.any(met.exposed() > 0.0, axis=-1) | dependent
