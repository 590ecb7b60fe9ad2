"""Motion with play in the joints, from contact to contact, for a batch of runs at once."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.contact import side_of
from vibecalc.response.impact.ledger import enter_energy, open_ledger
from vibecalc.response.impact.model import Drive, GasForce, Joint, Train, assemble_train, starts
from vibecalc.response.impact.results import Revolutions, collect
from vibecalc.response.impact.setup import make_setup
from vibecalc.response.impact.sweep import State, sweep
from vibecalc.response.impact.trace import open_trace


def simulate(
    drive: Drive,
    gas: GasForce,
    mass: ArrayLike,
    joint: Joint,
    gap: ArrayLike,
    gap_velocity: ArrayLike,
    *,
    revolutions: int,
    orders_kept: int,
    crank_joint: Joint | None = None,
    rod_mass: ArrayLike | None = None,
    wall: Joint | None = None,
    samples: int = 0,
    subdivision: int = 1,
) -> Revolutions:
    """Run B machines that differ in anything but their drive and gas force, from crank angle 0.

    Parameters
    ----------
    drive, gas, joint, crank_joint, wall
        See `model.py`, which has the equations and the signs. The clearance of `wall` is the
        whole lateral play of the piston in the bore.
    mass, rod_mass : (B,) or a number, kg
        Of the piston with what moves with it, and of the rod's reciprocating point mass, which
        belongs to a crank joint with play.
    gap, gap_velocity : (B, G), or (B,) with one gap; m and m/s
        Start of the gaps, in the order wrist pin, crank pin, bore.
    revolutions, orders_kept : int
        How far to run, and the highest order of the force spectra.
    samples : int
        Equal crank angles at which the last revolution is sampled.
    subdivision : int
        Parts that every panel of crank angle is cut into; the results do not depend on it.

    Returns
    -------
    Revolutions
        Events are exact to rounding. The error estimates are those of one revolution from its
        own start: runs part exponentially, so that no method can give the state of a single run
        after many revolutions, and only statistics of many runs are results.

    Raises
    ------
    NumericalFailure
        Contacts too short or too strongly damped to be followed, a run that sticks at the jump
        of a full-deflection law, a state that is not finite.
    UsageError
        Parts that do not fit together.
    """
    start, speed = starts(gap), starts(gap_velocity)
    members = start.shape[1]
    rod = None if rod_mass is None else np.asarray(rod_mass, dtype=np.float64)
    piston = np.asarray(mass, dtype=np.float64)
    train = assemble_train(members, piston, joint, crank_joint, rod, wall)
    setup = make_setup(train, drive, gas, orders_kept, subdivision)
    state = _first_state(train, start, speed)
    ledger = open_ledger(setup, revolutions)
    trace = open_trace(len(start), members, samples, revolutions - 1)
    everyone = np.arange(members)
    enter_energy(ledger, setup, everyone, 0 * everyone, state.gap, state.velocity)
    running = everyone
    while len(running):
        sweep(setup, state, ledger, trace, running)
        running = everyone[state.revolution < revolutions]
    return collect(setup, state, ledger, trace)


def _first_state(train: Train, gap: FloatArray, velocity: FloatArray) -> State:
    members = gap.shape[1]

    def zeros() -> np.ndarray:
        return np.zeros(members, dtype=np.int64)

    on_lower, on_upper = gap == 0.0, gap == train.gaps.clearance
    return State(
        gap.copy(),
        velocity.copy(),
        side_of(train.gaps, gap),
        on_upper.astype(np.int64) - on_lower.astype(np.int64),
        zeros(),
        np.zeros(members),
        zeros(),
        zeros(),
        zeros(),
        zeros(),
    )
