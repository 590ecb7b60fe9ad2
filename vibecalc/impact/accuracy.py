"""Questions of impacts: the first contacts in a joint with play.

Runs part exponentially, so that only the beginning of one run can be held to a truth.
"""

import math

import numpy as np

from vibecalc.core.accuracy.kinds import TURN, time_history
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.impact.linkage import central_start
from vibecalc.impact.model import joints_of
from vibecalc.impact.setup import DEGREE, REACH
from vibecalc.impact.simulate import simulate
from vibecalc.numerics.rounding import FloatArray

#: angles a turn at which the gap is compared, and how many of them the first eighth holds
SAMPLES, SHOWN = 96, 12


def impact_topics(scene: Scene) -> list[Topic]:
    """The gap of the wrist pin at the case's middle clearance, where it is the only play."""
    options, joints = scene.case.response, scene.case.machine.joints
    if options is None or options.impact is None or joints is None:
        return []
    linkage = joints_of(scene.case).linkage
    if linkage.crank_pin is not None or linkage.bore is not None:
        return []
    chosen = sorted(options.impact.clearances or (float(joints.wrist_pin.clearance),))
    clearance, drive = float(chosen[len(chosen) // 2]), linkage.drive
    joint, mass = linkage.wrist_pin, float(linkage.mass)
    stiffness = float(joint.stiffness)
    contact = math.pi * math.sqrt(mass / stiffness)
    rest = clearance if joint.law == "continuous" else 0.0
    strength = -np.square(drive.orders * drive.speed) * drive.displacement
    angle, force = np.asarray(linkage.gas.angle), np.asarray(linkage.gas.force)
    centre = central_start(linkage, np.array([clearance]))
    start = np.array([centre.gap[0, 0], centre.velocity[0, 0]])
    times = TURN / (SAMPLES * drive.speed) * np.arange(SHOWN + 1)

    def rates(time: float, state: FloatArray) -> FloatArray:
        gap, velocity = state.tolist()
        pin = float((strength @ np.exp(1j * drive.orders * drive.speed * time)).real)
        turned = (drive.speed * time) % TURN
        gas = float(np.interp(turned, angle, force, period=TURN)) if force.size else 0.0
        side = (gap > clearance) - (gap < 0.0)
        own = float(joint.film_damping) * velocity
        if side != 0:
            own = stiffness * (gap - (rest if side > 0 else 0.0))
            own += float(joint.contact_damping) * velocity
        return np.array([velocity, pin - (own + gas) / mass])

    # in the contact springs and films a step of the series reaches so far
    fastest = np.pi / contact + float(joint.contact_damping) / mass
    pieces = fastest * times[-1] / REACH + len(angle) * SHOWN / SAMPLES + SHOWN

    def exact(parts: float) -> Answer:
        run = simulate(
            linkage.with_clearance(np.array([clearance])), centre, 1, 1, SAMPLES, int(parts)
        )
        return Answer(run.gap[0, 0, 1 : SHOWN + 1], DEGREE * pieces * parts)

    ask = Ask("first contacts", "gap of the first eighth of a turn",
              "response/impact/first_turn_force", 2.0, "a bound on its steps")  # fmt: skip
    solver = Solver("from contact to contact", exact, "parts of a panel", (1, 2, 3))
    scale = 1e-3 * clearance * np.array([1.0, 1.0 / contact])
    return [time_history(ask, solver, rates, start, times, lambda rows: rows[:, 0], scale,
                         lambda: exact(2.0).values, stops=angle / drive.speed,
                         max_step=0.2 * contact)]  # fmt: skip
