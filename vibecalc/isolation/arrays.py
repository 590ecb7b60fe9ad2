"""The highest peaks of the run-ups of many points of a sweep at once."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.isolation.adapters.body_run_up import run_up_rows
from vibecalc.isolation.adapters.common import emit_run_up_peaks, isolation_of
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.rows import HarmonicsAt, Jet, Readout, body_rows, with_left_out
from vibecalc.isolation.run_up_machines import Machines, highest_peaks
from vibecalc.isolation.run_up_peaks import Ground, RunUpPeak
from vibecalc.isolation.run_up_poles import PoleSums, pole_sums
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.response.modal_damping import damped_poles
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import MaskedSpeeds, Resonances
from vibecalc.response.system import MountedBody

# ----------------------------------------------------------------------------
# What the isolation models hand on. Points with a mode that nothing damps are run alone.
# ----------------------------------------------------------------------------

#: some of the machines (n,), and a row of each -> these rows over speeds (n,), one by one
RowsAt = Callable[[np.ndarray, np.ndarray], HarmonicsAt]

_NONE = np.zeros(0)


class RunUps(NamedTuple):
    """Run-ups of all points (machines,), as `RunUpSetup` is of one; `sums` are a quick look."""

    rows_at: RowsAt
    orders: np.ndarray
    resonances: Resonances
    rows: int
    row_of: np.ndarray
    lever_rows: int
    sums: PoleSums


def hand_on(scene: PointsScene, system: OnMounts) -> None:
    """Of the bodies of all points, under the shaking."""
    forcing: Forcing = scene.handed_on["forcing"]
    load = system.felt(forcing.per_speed_squared)
    few, tail = few_orders(forcing)
    read = run_up_rows(scene, system)
    given, alone = run_ups_of_bodies(
        scene.count, system.matrices, system.shapes, read.rows, forcing.order, load,
        forcing.retained, few, tail,
    )  # fmt: skip
    scene.alone |= alone
    scene.handed_on["run_up"] = given._replace(row_of=read.row_of, lever_rows=read.lever_rows)


def run_ups_of_bodies(
    count: int,
    matrices: Linear,
    shapes: Modes,
    readout: Readout,
    orders: np.ndarray,
    load: Bounded,
    used: int,
    few: np.ndarray,
    tail: np.ndarray | float,
) -> tuple[RunUps, np.ndarray]:
    """Run-ups of `count` bodies, and which of them have to be run alone (count,).

    `load` (..., orders, f) is per squared crank speed; the first `used` orders are kept, those at
    the places `few` stand, `tail` times, for what is left out.
    """
    readout, tail = _of_each(readout, count), np.broadcast_to(tail, count)
    load = Bounded(*(np.broadcast_to(part, (count, *part.shape[-2:])) for part in load))
    matrices = Linear(*(np.broadcast_to(part, (count, *part.shape[-2:])) for part in matrices))
    axes = (1, 1, 2, 2, 1, 1)
    shapes = Modes(
        *(
            np.broadcast_to(part, (count, *part.shape[-own:]))
            for part, own in zip(shapes, axes, strict=True)
        )
    )
    first = load[:, :used]
    system, poles = MountedBody(matrices=matrices, shapes=shapes), damped_poles(matrices, shapes)
    met = system.resonances(first)
    resonances = system.with_poles(met, first, poles)
    sums, dependent = pole_sums(poles, shapes, readout, orders[:used], first)

    def rows_at(machine: np.ndarray, row: np.ndarray) -> HarmonicsAt:
        some = Linear(*(part[machine] for part in matrices))
        read = _read(readout, machine, row)
        kept, beyond = (
            body_rows(some, read, orders[which], load[machine][:, which])
            for which in (slice(used), few)
        )
        return with_left_out(kept, beyond, tail[machine], orders[few])

    rows = readout.still.shape[1]
    given = RunUps(rows_at, orders[:used], resonances, rows, np.arange(rows), 0, sums)
    return given, np.any(met.exposed() > 0.0, axis=-1) | dependent


def _of_each(readout: Readout, count: int) -> Readout:
    still, rising = (
        np.broadcast_to(part, (count, *part.shape[-3:])) for part in (readout.still, readout.rising)
    )
    return Readout(still, rising, readout.uncertainty)


def _read(readout: Readout, machine: np.ndarray, row: np.ndarray) -> Readout:
    """The readout of one row of each machine."""
    return readout.rows(machine[:, None], row[:, None])


# ----------------------------------------------------------------------------
# The peaks of all points, some machines at a time.
# ----------------------------------------------------------------------------

#: machines times orders that are worked on at once
_MOST_AT_ONCE = 600


def run_up_peaks(scene: PointsScene) -> None:
    """Emit the highest peak of each point and its speed."""
    given: RunUps = scene.handed_on["run_up"]
    span = isolation_of(scene).run_up
    if span is None:
        raise ValueError("the case has no run-up")
    peak = RunUpPeak(*np.zeros((4, scene.count, given.rows)))
    machines = np.flatnonzero(~scene.alone)
    found = peaks_of(given, machines, span.start, span.stop)
    for whole, part in zip(peak, found, strict=True):
        whole[machines] = part
    results = RunUpPeak(*(part[:, given.row_of] for part in peak))
    emit_run_up_peaks(scene, results, given.lever_rows)


def peaks_of(given: RunUps, machines: np.ndarray, start: float, stop: float) -> RunUpPeak:
    """Highest peaks (n, rows) of some of the machines (n,) in a range of speeds in rad/s."""
    peak = RunUpPeak(*np.zeros((4, len(machines), given.rows)))
    most = max(_MOST_AT_ONCE // len(given.orders), 1)
    for first in range(0, len(machines), most):
        part = slice(first, first + most)
        found = highest_peaks(_some(given, machines[part], start, stop))
        for whole, rows in zip(peak, found, strict=True):
            whole[part] = rows.reshape(-1, given.rows)
    return peak


def _some(given: RunUps, members: np.ndarray, start: float, stop: float) -> Machines:
    rows, sums = given.rows, given.sums

    def jets_at(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
        at = given.rows_at(members[row // rows], row % rows)
        jet = at(speed, slopes=True, errors=errors)
        return Jet(*(part[:, 0] if part.size else part for part in jet))

    def look(speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet:
        assert not errors
        return sums.jets(members[row // rows], speed, row % rows)

    def harmonics_at(machine: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return sums.values(members[machine], speed)

    resonances = given.resonances.sought()
    total = len(members) * rows
    ends = np.full(total, float(start)), np.full(total, float(stop))
    return Machines(
        Ground(jets_at, given.orders, *ends, look),
        harmonics_at,
        resonances.frequency[members],
        resonances.damping_ratio[members],
        resonances.exposed()[members],
        np.zeros(total, dtype=bool),
        MaskedSpeeds(_NONE, _NONE, _NONE, _NONE, _NONE),
    )
