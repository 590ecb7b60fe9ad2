"""The highest peaks of the run-ups of many points of a sweep at once."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.columns import PointsScene
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.isolation.adapters.common import emit_run_up_peaks, isolation_of
from vibecalc.isolation.model import PitchParts
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.pitch import Pitch, pitch_resonances
from vibecalc.isolation.rigid_body import mount_readout
from vibecalc.isolation.rows import (
    HarmonicsAt,
    Jet,
    Readout,
    body_rows,
    distinct,
    pitch_readout,
    pitch_rows,
    with_left_out,
)
from vibecalc.isolation.run_up_machines import Machines, highest_peaks
from vibecalc.isolation.run_up_peaks import Ground, RunUpPeak
from vibecalc.isolation.run_up_poles import PoleSums, pitch_sums, pole_sums
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.response.modal_damping import damped_poles, with_damped_poles
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import MaskedSpeeds, Resonances

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


def hand_on_pitch(
    scene: PointsScene,
    forcing: Forcing,
    parts: PitchParts,
    pitch: Pitch,
    couple: Bounded,
    lever: np.ndarray,
) -> None:
    """Of bodies that pitch, under couples (..., orders) per squared crank speed."""
    count, used = scene.count, forcing.retained
    readout, row_of = distinct(
        pitch_readout(
            pitch, lever, parts.position, parts.stiffness, parts.damping, parts.structural
        )
    )
    few, tail = few_orders(forcing)
    pitch = pitch._replace(
        **{
            name: np.broadcast_to(value, count)
            for name, value in pitch._asdict().items()
            if name != "rounding"
        }
    )
    readout, tail = _of_each(readout, count), np.broadcast_to(tail, count)
    couple = Bounded(*(np.broadcast_to(part, (count, part.shape[-1])) for part in couple))
    resonances = _of_points(pitch_resonances(pitch, couple[..., :used]), count)
    orders = forcing.orders[:used]
    sums, dependent = pitch_sums(pitch, readout, orders, couple[..., :used])
    scene.alone |= np.any(resonances.exposed() > 0.0, axis=-1) | dependent

    def rows_at(machine: np.ndarray, row: np.ndarray) -> HarmonicsAt:
        one = pitch._replace(
            **{
                name: value[machine]
                for name, value in pitch._asdict().items()
                if name != "rounding"
            }
        )
        read = _read(readout, machine, row)
        kept, beyond = (
            pitch_rows(one, read, forcing.orders[which], couple[machine][..., which])
            for which in (slice(used), few)
        )
        return with_left_out(kept, beyond, tail[machine])

    rows = readout.spring.shape[1]
    scene.handed_on["run_up"] = RunUps(rows_at, orders, resonances, rows, row_of, 1, sums)


def hand_on_bodies(scene: PointsScene, forcing: Forcing, system: OnMounts, load: Bounded) -> None:
    """Of rigid bodies, under loads (..., orders, f) per squared crank speed."""
    count, used, mounts = scene.count, forcing.retained, system.mounts
    whole = mount_readout(mounts.position, mounts.stiffness, mounts.damping, mounts.structural)
    keep = system.freedoms
    readout = _of_each(
        whole._replace(spring=whole.spring[..., keep], damper=whole.damper[..., keep]), count
    )
    few, tail = few_orders(forcing)
    tail = np.broadcast_to(tail, count)
    load = Bounded(*(np.broadcast_to(part, (count, *part.shape[-2:])) for part in load))
    first = load[:, :used]
    matrices = Matrices(
        *(np.broadcast_to(part, (count, *part.shape[-2:])) for part in system.matrices)
    )
    axes = {name: 1 + name.startswith("shape") for name in Modes._fields}
    shapes = Modes(
        *(
            np.broadcast_to(part, (count, *part.shape[-axes[name] :]))
            for name, part in system.shapes._asdict().items()
        )
    )
    met = _of_points(system.resonances(first), count)
    poles = damped_poles(matrices, shapes)
    resonances = with_damped_poles(met, matrices, shapes, first, poles)
    orders = forcing.orders[:used]
    sums, dependent = pole_sums(poles, shapes, readout, orders, first)
    scene.alone |= np.any(met.exposed() > 0.0, axis=-1) | dependent

    def rows_at(machine: np.ndarray, row: np.ndarray) -> HarmonicsAt:
        some = Matrices(*(part[machine] for part in matrices))
        read = _read(readout, machine, row)
        kept, beyond = (
            body_rows(some, read, forcing.orders[which], load[machine][:, which])
            for which in (slice(used), few)
        )
        return with_left_out(kept, beyond, tail[machine])

    count_of_rows = len(mounts.names)
    row_of = np.arange(count_of_rows)
    scene.handed_on["run_up"] = RunUps(rows_at, orders, resonances, count_of_rows, row_of, 0, sums)


def _of_points(resonances: Resonances, count: int) -> Resonances:
    frequency, ratio, width, idle = resonances[:4]
    modes = frequency.shape[-1]
    one = (np.broadcast_to(part, (count, modes)) for part in (frequency, ratio, width))
    return Resonances(*one, np.broadcast_to(idle, (count, *idle.shape[-2:])))


def _of_each(readout: Readout, count: int) -> Readout:
    spring, damper = (
        np.broadcast_to(part, (count, *part.shape[-3:]))
        for part in (readout.spring, readout.damper)
    )
    return Readout(spring, damper, readout.uncertainty)


def _read(readout: Readout, machine: np.ndarray, row: np.ndarray) -> Readout:
    """The readout of one row of each machine."""
    pick = (machine, row)
    return readout._replace(
        spring=readout.spring[pick][:, None], damper=readout.damper[pick][:, None]
    )


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
    most = max(_MOST_AT_ONCE // len(given.orders), 1)
    for first in range(0, len(machines), most):
        members = machines[first : first + most]
        found = highest_peaks(_some(given, members, span.start, span.stop))
        for whole, part in zip(peak, found, strict=True):
            whole[members] = part.reshape(len(members), -1)
    row_of = given.row_of
    emit_run_up_peaks(scene, RunUpPeak(*(part[:, row_of] for part in peak)), given.lever_rows)


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
