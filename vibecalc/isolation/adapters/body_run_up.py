"""Adapter: the run-up of a body on its mounts under all that acts on it."""

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import (
    KeptRows,
    RunUpSection,
    RunUpSetup,
    isolation_of,
)
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.rows import (
    HarmonicsAt,
    Readout,
    joined_rows,
    with_left_out,
)
from vibecalc.isolation.torque_reaction import couple_by_differences, linear_couple
from vibecalc.numerics.cycle_peak import numbered
from vibecalc.response.adapters.loads import LoadsOverSpeed, loads_over_speed
from vibecalc.response.resonances import Resonances, idle_warnings

if TYPE_CHECKING:
    from vibecalc.response.adapters.torque_couple import TorqueLaw

# ----------------------------------------------------------------------------
# The run-up of a body: all orders of the shaking and of the torque that reaches the mounts.
#
# Between two gas cards the torque is linear in the speed, so each such part of the range is a
# run-up of its own.
# ----------------------------------------------------------------------------

#: damping ratio from which a resonance of a shaft line is looked for
_NARROW = 1e-3


def body_sections(scene: Scene, start: float, stop: float) -> tuple[RunUpSection, ...]:
    """The range from `start` to `stop`, cut at the speeds of the gas cards within it."""
    loads = loads_over_speed(scene, "isolation", start, stop)
    return tuple(
        RunUpSection(_setup(scene, loads._replace(speeds=np.array(ends))), *ends)
        for ends in pairwise(loads.speeds.tolist())
    )


def _setup(scene: Scene, loads: LoadsOverSpeed) -> RunUpSetup:
    """Rows and resonances between two speeds."""
    system: OnMounts = scene.handed_on.get("on_foundation") or scene.handed_on["on_mounts"]
    order, law, ends = loads.order, loads.law, loads.speeds
    about = np.concatenate([np.zeros(3), loads.axis]) @ system.reach

    def of_orders(part: slice) -> tuple[Callable[[Readout, bool], HarmonicsAt], Resonances]:
        forces = [system.felt(load) for load in loads.some(part)]
        couple = None if law is None else _couple(law.of_orders(part), ends)
        resonances = system.resonances(*forces)

        def rows(readout: Readout, passed_on: bool) -> HarmonicsAt:
            given = (readout, order[part], forces[0], resonances, couple, about, passed_on)
            return system.rows(*given)

        return rows, system.with_poles(resonances, *forces)

    kept, resonances = of_orders(slice(loads.retained))
    others, _ = of_orders(slice(loads.retained, None))
    listed, beyond = order[: loads.retained], order[loads.retained :]

    def rows(readout: Readout, passed_on: bool = False) -> KeptRows:
        return KeptRows(kept(readout, passed_on), others(readout, passed_on), loads.tail, beyond)

    resonances = resonances.beside(loads.line, np.full(loads.line.shape, _NARROW))
    readout = run_up_rows(scene, system)
    travel = system.travel()
    harmonics = numbered(listed)
    step = float(listed[0] / harmonics[0])
    return RunUpSetup(
        rows=with_left_out(*rows(readout.rows, True)[:3], beyond / step),
        harmonics=harmonics,
        step=step,
        resonances=resonances._replace(frequency=resonances.frequency / step),
        shows=readout.shows,
        row_of=readout.row_of,
        lever_rows=readout.lever_rows,
        idle=lambda first, last: idle_warnings(resonances, listed, first, last),
        system=system,
        rows_of=rows,
        travel=None if travel is None else with_left_out(*rows(travel)[:3], beyond / step),
        mean=() if law is None else tuple(map(law.mean_at, ends)),
    )


class RunUpRows(NamedTuple):
    """Rows of a run-up: in pitch the couple over the lever, then forces of the mounts.

    Rows that repeat another are one, `row_of` (results,) tells which; `shows` (..., modes, rows)
    which modes are seen in a row.
    """

    rows: Readout
    row_of: np.ndarray
    lever_rows: int
    shows: np.ndarray


def run_up_rows(scene: Scene, system: OnMounts) -> RunUpRows:
    """What a run-up of this system reads, by the mounts and, in pitch, over the lever."""
    first, row_of = system.alike()
    readout, shows = system.forces().rows(..., first), system.shows()[..., first]
    if isolation_of(scene).model != "pitch":
        return RunUpRows(readout, row_of, 0, shows)
    from vibecalc.isolation.adapters.pitch import lever_of

    readout = joined_rows(system.couple_over(lever_of(scene, system)), readout)
    shows = np.concatenate([np.ones_like(shows[..., :1]), shows], axis=-1)
    return RunUpRows(readout, np.concatenate([[0], 1 + row_of]), 1, shows)


def _couple(law: "TorqueLaw", ends: np.ndarray) -> HarmonicsAt:
    """Couple that the shaking lacks, as a function of the speed."""
    if law.passing is not None:
        return couple_by_differences(law.lacking_at, *ends.tolist())
    return linear_couple(ends, *map(law.lacking_at, ends))
