"""Motion with play, a batch from contact to contact, against scipy run by run, in this one run.

Both sides run the compressor of Ong (2000, chapter 5). The plain way is `solve_ivp` with an event
at every face and rtol 1e-9, a few runs of it, scaled; its steps are kept below a fifth of a
contact, without which it passes contacts over. CPU time, one thread.
"""

import math
import os
import time
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from rows import Report, Row, reported, seconds
from scipy.integrate import solve_ivp

from vibecalc.impact.linkage import GasForce, Joint, Linkage, Starts, slider_crank_drive
from vibecalc.impact.simulate import simulate

RADIUS, LENGTH, SPEED = 0.0127, 0.060325, 361.0
MASS, STIFFNESS, DAMPING, CLEARANCE = 0.3486, 1.7513e8, 17.513, 3.81e-5
TURN = 2.0 * math.pi / SPEED
MEMBERS, REVOLUTIONS, PLAIN_MEMBERS = 200, 10, 4


class Measured(NamedTuple):
    """CPU seconds for one run over one revolution, and the mean number of contacts in it."""

    seconds: float
    contacts: float


def gas_force() -> GasForce:
    """A pressure curve like that of the source: compression, discharge, expansion."""
    degrees = np.arange(0.0, 361.0, 10.0)
    falling = 2038.0 * 0.4 ** (degrees / 10.0)
    rising = 2038.0 * np.minimum(1.0, np.exp((degrees - 330.0) / 22.0))
    force = np.where(degrees < 60.0, falling, np.where(degrees < 190.0, 0.0, rising))
    force[-1] = force[0]
    return GasForce(np.radians(degrees), force)


def batch(law: str, gap: np.ndarray) -> tuple[Measured, np.ndarray]:
    """All runs at once; also the times of their first contacts."""
    joint = Joint(CLEARANCE, STIFFNESS, DAMPING, DAMPING, law)
    linkage = Linkage(slider_crank_drive(RADIUS, LENGTH, SPEED), gas_force(), MASS, joint)
    start = Starts(gap[:, None], np.zeros((len(gap), 1)))
    started = time.process_time()
    run = simulate(linkage, start, REVOLUTIONS, 100)
    seconds = time.process_time() - started
    count = float(np.mean(run.forces.contacts))
    return Measured(seconds / (len(gap) * REVOLUTIONS), count), run.first_contacts[0]


def plain(law: str, start: float) -> tuple[float, list[float]]:
    """CPU seconds of one run over one revolution, and the times of its contacts."""
    gas = gas_force()
    angles, forces = gas.angle, gas.force

    def rates(now: float, state: list[float], side: int) -> list[float]:
        gap, velocity = state
        angle = SPEED * now
        sine, cosine = math.sin(angle), math.cos(angle)
        rod = math.sqrt(LENGTH**2 - (RADIUS * sine) ** 2)
        pull = RADIUS * sine / rod
        swing = (RADIUS * cosine * LENGTH) ** 2 / rod**3
        pin = SPEED**2 * (RADIUS * cosine - RADIUS * sine * pull + swing)
        rest = CLEARANCE if side > 0 and law == "continuous" else 0.0
        force = DAMPING * velocity + (STIFFNESS * (gap - rest) if side else 0.0)
        return [velocity, pin - (force + np.interp(angle % (2 * math.pi), angles, forces)) / MASS]

    def face_event(face: float, way: int):  # type: ignore[no-untyped-def]
        def crosses(now: float, state: np.ndarray, side: int) -> float:
            return float(state[0] - face)

        crosses.terminal, crosses.direction = True, way  # type: ignore[attr-defined]
        return crosses

    contact = math.pi * math.sqrt(MASS / STIFFNESS)
    now, state, side, made = 0.0, np.array([start, 0.0]), 0, []
    started = time.process_time()
    while now < TURN:
        faces = {1: [(CLEARANCE, -1)], -1: [(0.0, 1)], 0: [(CLEARANCE, 1), (0.0, -1)]}[side]
        answer = solve_ivp(
            rates, (now, TURN), state, method="DOP853", rtol=1e-9, atol=1e-14,
            events=[face_event(*each) for each in faces], args=(side,), max_step=contact / 5,
        )  # fmt: skip
        now, state = float(answer.t[-1]), answer.y[:, -1]
        if answer.status == 1:
            hit = next(k for k, times in enumerate(answer.t_events) if len(times))
            state[0], way = faces[hit]
            side += way
            if side:
                made.append(now)
    return time.process_time() - started, made


def measure() -> Report:
    """One row per contact law."""
    rows = []
    gap = 1e-8 * np.random.default_rng(3).random(MEMBERS)
    for law in ("continuous", "full_deflection"):
        ours, first = batch(law, gap)
        theirs = [plain(law, float(start)) for start in gap[:PLAIN_MEMBERS]]
        spent = float(np.mean([each[0] for each in theirs]))
        apart = max(
            float(np.max(np.abs(np.array(each[1][:4]) - first[k, :4])))
            for k, each in enumerate(theirs)
        )
        rows.append(
            Row(
                f"joint with play, {MEMBERS} runs of {REVOLUTIONS} turns, "
                f"{law.replace('_', ' ')} contact",
                "batch from contact to contact",
                "scipy DOP853 with events, rtol 1e-9",
                spent / ours.seconds,
                error=f"contacts 1 to 4 within {apart / TURN:.0e} turns of scipy's",
                note=f"{seconds(ours.seconds)} against {seconds(spent)} a run and turn, "
                f"{ours.contacts:.1f} contacts in it",
            )
        )
    return Report(
        "Impacts in a joint with play",
        "The compressor of Ong (2000, chapter 5). scipy's steps are kept below a fifth of a "
        f"contact, without which it passes contacts over; {PLAIN_MEMBERS} of its runs are timed.",
        rows,
    )


if __name__ == "__main__":
    reported(measure)
