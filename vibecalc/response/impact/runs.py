"""An ensemble of runs: all clearances, members and neighbours as one batch."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import UsageError
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.impact.fixed_step import FixedSteps, SampledRecord, simulate_fixed_steps
from vibecalc.response.impact.linkage import (
    Linkage,
    Starts,
    clearances,
    gaps_of,
    spread_starts,
    velocity_scale,
)
from vibecalc.response.impact.parting import distance
from vibecalc.response.impact.results import GapRecord, Revolutions
from vibecalc.response.impact.simulate import simulate

#: neighbours whose parting is timed, at most, for each clearance
MOST_NEIGHBOURS = 16
#: bytes of spectra that one study may hold
MOST_MEMORY = 2e9


class GapRuns(NamedTuple):
    """One gap in every counted revolution; arrays (C, M, R), harmonics (C, M, R, N + 1).

    `harmonics`, mean magnitude `force` and `peak` in N; `contacts` made and `contact_time`, s,
    per revolution.
    """

    harmonics: ComplexArray
    force: FloatArray
    peak: FloatArray
    contacts: FloatArray
    contact_time: FloatArray


class Forces(NamedTuple):
    """The joints of the cylinder; those without play are None."""

    wrist_pin: GapRuns
    crank_pin: GapRuns | None
    bore: GapRuns | None


class Ensemble(NamedTuple):
    """What M members of C clearances do in R revolutions, followed event by event.

    `dissipated`, `exchanged` (C, M, R), J: energy lost in contacts and films, and all that was
    taken and given. `residual` (C, M, R): the imbalance of energy over the energy exchanged.
    `distances` (C, P, T + 1): how far the first P members are from neighbours, at the start and
    after each of all T revolutions, see `parting.py`.
    """

    forces: Forces
    dissipated: FloatArray
    exchanged: FloatArray
    residual: FloatArray
    distances: FloatArray


class Study(NamedTuple):
    """Clearances (C,) of the wrist pin, m; members of each; revolutions; highest order."""

    clearance: FloatArray
    members: int
    discard: int
    revolutions: int
    orders: int


def follow_events(
    linkage: Linkage,
    clearance: FloatArray,
    start: Starts,
    revolutions: int,
    orders: int,
    samples: int = 0,
    subdivision: int = 1,
) -> Revolutions:
    """The event-exact motion of a batch (B,) that differs in clearance and start (B, G)."""
    return simulate(
        linkage.drive,
        linkage.gas,
        linkage.mass,
        linkage.wrist_pin._replace(clearance=clearance),
        start.gap,
        start.velocity,
        revolutions=revolutions,
        orders_kept=orders,
        crank_joint=linkage.crank_pin,
        rod_mass=linkage.rod_mass,
        wall=linkage.bore,
        samples=samples,
        subdivision=subdivision,
    )


def run_ensemble(linkage: Linkage, study: Study, perturbation: float) -> Ensemble:
    """Run a study event by event; its first members have neighbours that start beside them.

    `perturbation`, m, is how much further the joint of a neighbour is open at the start. Raises
    UsageError for a study that does not fit into memory, and what the motion raises.
    """
    members, neighbours = study.members, min(study.members, MOST_NEIGHBOURS)
    _refuse_large(linkage, study, members + neighbours)
    start = spread_starts(linkage, study.clearance, members)
    nearby = start.gap[:, :neighbours].copy()
    nearby[..., 0] += perturbation
    start = Starts(
        np.concatenate([start.gap, nearby], axis=1),
        np.concatenate([start.velocity, start.velocity[:, :neighbours]], axis=1),
    )
    shape = start.gap.shape
    each = np.repeat(study.clearance, shape[1])
    state = Starts(*(part.reshape(-1, shape[2]) for part in start))
    gaps, velocities = [state.gap[:, None]], [state.velocity[:, None]]
    # the revolutions to forget need no spectra
    for turns, highest in ((study.discard, 1), (study.revolutions, study.orders)):
        if turns:
            run = follow_events(linkage, each, state, turns, highest)
            gaps.append(run.end_gap)
            velocities.append(run.end_velocity)
            state = Starts(run.end_gap[:, -1], run.end_velocity[:, -1])
    gap, velocity = (
        np.concatenate(part, axis=1).reshape(*shape[:2], -1, shape[2])
        for part in (gaps, velocities)
    )
    apart = distance(
        gap[:, :neighbours] - gap[:, members:],
        velocity[:, :neighbours] - velocity[:, members:],
        clearances(linkage, study.clearance)[:, None, None],
        velocity_scale(linkage, study.clearance)[:, None, None],
    )
    exchanged, residual, lost = run.axial.exchanged, run.axial.relative_error, run.axial.dissipated
    if run.lateral is not None:
        exchanged = exchanged + run.lateral.exchanged
        residual = np.maximum(residual, run.lateral.relative_error)
        lost = lost + run.lateral.dissipated
    return Ensemble(
        _forces(run, shape[:2], members),
        _members(lost, shape[:2], members),
        _members(exchanged, shape[:2], members),
        _members(residual, shape[:2], members),
        apart,
    )


def run_fixed_steps(linkage: Linkage, study: Study, method: str, steps: int) -> Forces:
    """The same members by a method of fixed step, `steps` to a revolution.

    Raises UsageError for a study that does not fit into memory, and what the method raises.
    """
    _refuse_large(linkage, study, study.members)
    start = spread_starts(linkage, study.clearance, study.members)
    shape = start.gap.shape
    run = simulate_fixed_steps(
        linkage.drive,
        linkage.gas,
        linkage.mass,
        linkage.wrist_pin._replace(clearance=np.repeat(study.clearance, study.members)),
        start.gap.reshape(-1, shape[2]),
        start.velocity.reshape(-1, shape[2]),
        method=method,
        steps=steps,
        revolutions=study.discard + study.revolutions,
        orders_kept=study.orders,
        crank_joint=linkage.crank_pin,
        rod_mass=linkage.rod_mass,
        wall=linkage.bore,
    )
    return _forces(run, shape[:2], study.members, study.discard)


def _refuse_large(linkage: Linkage, study: Study, members: int) -> None:
    count, turns = len(study.clearance), study.revolutions
    runs = count * members * gaps_of(linkage)
    size = 16.0 * runs * turns * (study.orders + 1)
    if size > MOST_MEMORY:
        raise UsageError(
            f"the spectra of {count} x {members} runs of {turns} revolutions with {study.orders} "
            f"orders take {size / 1e9:.3g} GB, more than {MOST_MEMORY / 1e9:g}: ask for fewer "
            f"members, revolutions or orders"
        )


def _members(values: np.ndarray, shape: tuple[int, ...], members: int) -> np.ndarray:
    """(C * all, ...) as (C, members, ...)."""
    return values.reshape(*shape, *values.shape[1:])[:, :members]


def _forces(
    run: Revolutions | FixedSteps, shape: tuple[int, ...], members: int, discard: int = 0
) -> Forces:
    def gap_runs(gap: GapRecord | SampledRecord) -> GapRuns:
        columns = (
            gap.force_harmonics,
            gap.mean_absolute_force,
            gap.peak_force,
            gap.impact_count.astype(np.float64),
            gap.contact_time,
        )
        return GapRuns(*(_members(column, shape, members)[:, :, discard:] for column in columns))

    return Forces(
        gap_runs(run.wrist_pin),
        None if run.crank_pin is None else gap_runs(run.crank_pin),
        None if run.wall is None else gap_runs(run.wall),
    )
