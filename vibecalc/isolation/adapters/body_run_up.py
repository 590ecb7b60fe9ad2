"""Adapter: the run-up of a body on its mounts under all that acts on it."""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.rows import HarmonicsAt, Readout, body_rows, joined_rows, with_left_out
from vibecalc.isolation.run_up import Range
from vibecalc.isolation.torque_reaction import couple_between
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import numbered
from vibecalc.response.adapters.loads import LoadsOverSpeed, loads_over_speed
from vibecalc.response.resonances import Resonances

# ----------------------------------------------------------------------------
# The run-up of a body: all orders of the shaking and of the torque that reaches the mounts.
#
# Between two gas cards the torque is linear in the speed, so each such part of the range is a
# run-up of its own.
# ----------------------------------------------------------------------------

#: damping ratio from which a resonance of a shaft line is looked for
_NARROW = 1e-3


class RunUpSection(NamedTuple):
    """A part of a run-up, between two speeds in rad/s.

    `order` (m,) has those kept, `beyond` (n,) some of those left out, which stand `factor` times
    for all of them. `rows_of` makes rows of any readout of the coordinates of the `system` for
    both, of forces that its mounts have passed on or else of motions. `mean` has the constant
    couples about the crankshaft at both ends.
    """

    system: OnMounts
    start: float
    stop: float
    order: np.ndarray
    beyond: np.ndarray
    factor: np.ndarray | float
    resonances: Resonances
    rows_of: Callable[[Readout, bool], tuple[HarmonicsAt, HarmonicsAt]]
    mean: tuple[Bounded, ...]

    @property
    def step(self) -> float:
        """Of the orders, which are whole numbers times this: 1/2 where a cycle is two turns."""
        return float(self.order[0] / numbered(self.order)[0])

    def given(self, readout: Readout, shows: np.ndarray, passed_on: bool = False) -> Range:
        """What a search of some rows takes."""
        return self.counted(*self.rows_of(readout, passed_on), shows)

    def counted(self, kept: HarmonicsAt, left_out: HarmonicsAt, shows: np.ndarray) -> Range:
        """The same of rows of both kinds of orders, in whole numbers."""
        met, step = self.resonances, self.step
        met = met._replace(frequency=met.frequency / step)
        rows = with_left_out(kept, left_out, self.factor, self.beyond / step)
        return Range(rows, numbered(self.order), met, self.start, self.stop, shows)


def sections(scene: Scene) -> tuple[RunUpSection, ...]:
    """The run-up in one part, or in several, cut at the speeds of the gas cards."""
    span = isolation_of(scene).run_up
    if span is None:
        raise ValueError("the case has no run-up")
    loads = loads_over_speed(scene, "isolation", span.start, span.stop)
    ends = pairwise(loads.speeds.tolist())
    return tuple(_section(scene, loads._replace(speeds=np.array(part))) for part in ends)


def _section(scene: Scene, loads: LoadsOverSpeed) -> RunUpSection:
    """Between two speeds, under the shaking and the torque of the cylinders, if that acts."""
    system: OnMounts = scene.handed_on.get("on_foundation") or scene.handed_on["on_mounts"]
    order, law, kept = loads.order, loads.law, loads.retained
    low, high = loads.speeds.tolist()
    about = np.concatenate([np.zeros(3), loads.axis]) @ system.reach

    def driven(part: slice) -> tuple[Callable[[Readout, bool], HarmonicsAt], Resonances]:
        """Rows of some orders, and what these may meet."""
        forces = [system.felt(load) for load in loads.some(part)]
        couple = None if law is None else couple_between(law.of_orders(part), low, high)
        met = system.resonances(*forces)

        def rows(readout: Readout, passed_on: bool) -> HarmonicsAt:
            return body_rows(
                system.matrices, readout, order[part], forces[0], system.undriven(met), couple,
                about, system.spectral, passed_on,
            )  # fmt: skip

        return rows, system.with_poles(met, *forces)

    (rows, resonances), (left_out, _) = driven(slice(kept)), driven(slice(kept, None))
    # the torque that a shaft line passes on has resonances of its own
    resonances = resonances.beside(loads.line, np.full(loads.line.shape, _NARROW))
    return RunUpSection(
        system, low, high, order[:kept], order[kept:], loads.tail, resonances,
        lambda readout, passed_on: (rows(readout, passed_on), left_out(readout, passed_on)),
        () if law is None else (law.mean_at(low), law.mean_at(high)),
    )  # fmt: skip


class RunUpRows(NamedTuple):
    """Rows of a run-up: in pitch the pitch couple / lever, then forces of the mounts.

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
