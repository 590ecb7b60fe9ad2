"""Adapter: the run-up of a body on its mounts under all that acts on it."""

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, few_orders
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
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import numbered
from vibecalc.response.adapters.loads import shaking_at, torque_of
from vibecalc.response.resonances import Resonances, idle_warnings
from vibecalc.response.torque_reaction import TAIL

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
    forcing: Forcing = scene.handed_on["forcing"]
    law = torque_of(scene, "isolation")
    if law is None:
        few, tail = few_orders(forcing)
        orders = _Orders(forcing.order, slice(forcing.retained), few, tail)
        return (RunUpSection(_setup(scene, orders, None, start, stop), start, stop),)
    within = law.speeds[(law.speeds > start) & (law.speeds < stop)]
    orders = _Orders(law.order, slice(law.retained), slice(law.retained, None), TAIL)
    return tuple(
        RunUpSection(_setup(scene, orders, law, low, high), low, high)
        for low, high in pairwise([start, *within.tolist(), stop])
    )


class _Orders(NamedTuple):
    """Orders (m,), those kept of them, and those that stand `tail` times for what is left out."""

    order: np.ndarray
    kept: slice
    beyond: slice | np.ndarray
    tail: np.ndarray | float


def _setup(
    scene: Scene, orders: _Orders, law: "TorqueLaw | None", low: float, high: float
) -> RunUpSetup:
    """Rows and resonances between two speeds."""
    system: OnMounts = scene.handed_on.get("on_foundation") or scene.handed_on["on_mounts"]
    forcing: Forcing = scene.handed_on["forcing"]
    order = orders.order
    axis, ends = scene.parts.crank_train.axis, np.array([low, high])
    shaking = shaking_at(order, forcing.per_speed_squared)
    about = np.concatenate([np.zeros(3), axis]) @ system.reach

    def of_orders(
        part: slice | np.ndarray,
    ) -> tuple[Callable[[Readout, bool], HarmonicsAt], Resonances]:
        force = system.felt(shaking[part])
        forces, couple = [force], None
        if law is not None:
            couple = _couple(law.of_orders(part), ends)
            at_ends = couple(ends, errors=True)
            forces += _about(Bounded(at_ends.value, at_ends.error), about)
        resonances = system.resonances(*forces)

        def rows(readout: Readout, passed_on: bool) -> HarmonicsAt:
            given = (readout, order[part], force, resonances, couple, about, passed_on)
            return system.rows(*given)

        return rows, system.with_poles(resonances, *forces)

    kept, resonances = of_orders(orders.kept)
    others, _ = of_orders(orders.beyond)
    beyond = order[orders.beyond]

    def rows(readout: Readout, passed_on: bool = False) -> KeptRows:
        return KeptRows(kept(readout, passed_on), others(readout, passed_on), orders.tail, beyond)

    if law is not None and law.passing is not None:
        from vibecalc.response.adapters.torque_couple import line_frequencies

        line = line_frequencies(scene, high)
        resonances = resonances.beside(line, np.full(line.shape, _NARROW))
    readout = run_up_rows(scene, system)
    travel = system.travel()
    listed = order[orders.kept]
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
        mean=() if law is None else (law.mean_at(low), law.mean_at(high)),
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


def _about(couple: Bounded, axis: np.ndarray) -> list[Bounded]:
    """Loads (orders, f) of the couples (speeds, orders) about an axis (f,), speed by speed."""
    return [
        Bounded(value[:, None] * axis, error[:, None] * np.abs(axis))
        for value, error in zip(couple.value, couple.error, strict=True)
    ]
