"""Topics of impacts: the first contacts in a joint with play, and the mean force of an ensemble.

Runs part exponentially, so that only the beginning of one run can be held to a truth; of later
turns only statistics of many runs are results, with a standard error of their own.
"""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.contacts import by_events, play_of
from vibecalc.accuracy.yardsticks.integrators import march_fixed, march_scipy
from vibecalc.machine.joints import build_joints
from vibecalc.pipeline.scene import Scene
from vibecalc.response.impact.ensemble import mean_over_runs
from vibecalc.response.impact.linkage import Linkage, Starts, central_start, spread_starts
from vibecalc.response.impact.panels import DEGREE
from vibecalc.response.impact.runs import Study, follow_events, run_fixed_steps
from vibecalc.response.impact.series import REACH

if TYPE_CHECKING:
    from vibecalc.case.response_tables import Impact

#: angles at which the gap is compared, and how many of them the first eighth of a turn holds
SAMPLES, SHOWN = 96, 12
STEPS = (48.0, 96.0, 192.0, 384.0, 768.0, 1536.0, 3072.0)
RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
REFERENCE_MEMBERS, REFERENCE_STEPS = 256, 2048
FIXED_STEPS = (128.0, 256.0, 512.0, 1024.0)


def topics(scene: Scene) -> list[Topic]:
    """Both topics at the case's middle clearance; the first only where one gap is all there is."""
    options = scene.case.response.impact if scene.case.response else None
    if options is None or scene.case.machine.joints is None:
        return []
    excitation = scene.case.excitation
    linkage = build_joints(
        scene.case.machine,
        excitation.working if excitation else None,
        gas_towards_crank=options.pressure == "towards_crank",
    ).linkage
    own = (float(scene.case.machine.joints.wrist_pin.clearance),)
    chosen = sorted(options.clearances or own)
    clearance = float(chosen[len(chosen) // 2])
    found = [_ensemble(linkage, clearance, options)]
    if linkage.crank_pin is None and linkage.bore is None:
        found.insert(0, _first_contacts(linkage, clearance))
    return found


def _first_contacts(linkage: Linkage, clearance: float) -> Topic:
    speed = linkage.drive.speed
    times = 2.0 * np.pi / (SAMPLES * speed) * np.arange(1, SHOWN + 1)
    play = play_of(linkage, clearance)
    centre = central_start(linkage, np.array([clearance]))
    start = np.array([centre.gap[0, 0], centre.velocity[0, 0]])
    # in the contact springs and films a step of the series reaches so far
    fastest = np.pi / play.contact + float(linkage.wrist_pin.contact_damping) / linkage.mass
    pieces = fastest * times[-1] / REACH + len(linkage.gas.angle) * SHOWN / SAMPLES + SHOWN
    atol = 1e-3 * clearance * np.array([1.0, 1.0 / play.contact])

    def exact(subdivision: float) -> Answer:
        run = follow_events(linkage, np.array([clearance]), centre, 1, 1, SAMPLES, int(subdivision))
        return Answer(run.wrist_pin.gap[0, 1 : SHOWN + 1], DEGREE * pieces * subdivision)

    def fixed(method: str, steps: float) -> Answer:
        run = march_fixed(play.rates, start, 0.0, float(times[-1]), int(steps), method)
        every = int(steps) // SHOWN
        return Answer(run.states[every::every, 0], run.evaluations)

    def adaptive(method: str, rtol: float) -> Answer:
        grid = np.concatenate([[0.0], times])
        run = march_scipy(play.rates, start, grid, rtol, rtol * atol, method)
        return Answer(run.states[1:, 0], run.evaluations)

    def kinks() -> np.ndarray:
        return np.asarray(linkage.gas.angle) / speed

    def events(rtol: float) -> Answer:
        gap, work = by_events(play, start, times, rtol, kinks())
        return Answer(gap, work)

    def reference() -> Reference:
        ours = exact(2.0).values
        theirs, _ = by_events(play, start, times, 1e-13, kinks())
        agreement = float(np.max(np.abs(ours - theirs)) / np.max(np.abs(ours)))
        return Reference(
            ours,
            agreement,
            "power series from contact to contact on halved panels; DOP853 with events at rtol "
            f"1e-13 agrees to {agreement:.1e}",
        )

    return Topic(
        stage="impact",
        name="first contacts",
        words=f"gap of the wrist pin at {SHOWN} angles of the first eighth of a turn, clearance "
        f"{clearance:.4g} m (the first method follows the whole turn)",
        quantity="response/impact/first_turn_force",
        unit="m",
        work="evaluations of the forces",
        reference=reference,
        ladders=(
            Ladder(
                "from contact to contact",
                f"power series of degree {DEGREE}, contacts found as roots of them",
                "parts of a panel",
                (1.0, 2.0, 3.0),
                exact,
                default=1.0,
                theory="the result does not depend on it",
                citation="docs/theory.md",
            ),
            Ladder(
                "Euler", "explicit Euler across the contacts", "steps", STEPS,
                lambda steps: fixed("euler", steps), theory="order 1",
            ),
            Ladder(
                "RK4",
                "classical Runge-Kutta across the contacts",
                "steps",
                STEPS,
                lambda steps: fixed("rk4", steps),
                theory="order 4 within a contact, less at its ends",
                citation="Ong (2000), chapter 5",
            ),
            Ladder(
                "RK45", "scipy's pair of Dormand and Prince across the contacts", "rtol", RTOLS,
                lambda rtol: adaptive("RK45", rtol),
            ),
            Ladder(
                "DOP853", "scipy across the contacts", "rtol", RTOLS,
                lambda rtol: adaptive("DOP853", rtol),
            ),
            Ladder(
                "DOP853 with events", "scipy from contact to contact", "rtol",
                (1e-3, 1e-6, 1e-9, 1e-12), events,
            ),
        ),
        default_extra=2.0,
        default_why="its work is counted from its bound on the steps",
    )  # fmt: skip


def _ensemble(linkage: Linkage, clearance: float, options: "Impact") -> Topic:
    def study(members: int) -> Study:
        return Study(np.array([clearance]), members, 0, 1, 1)

    def exact_forces(members: int) -> np.ndarray:
        start = spread_starts(linkage, np.array([clearance]), members)
        flat = Starts(*(part.reshape(-1, part.shape[-1]) for part in start))
        run = follow_events(linkage, np.full(members, clearance), flat, 1, 1)
        return np.asarray(run.wrist_pin.mean_absolute_force[:, 0])

    def exact(members: float) -> Answer:
        return Answer(np.array([np.mean(exact_forces(int(members)))]), members)

    def fixed(steps: float) -> Answer:
        forces = run_fixed_steps(linkage, study(options.members), "rk4", int(steps))
        return Answer(mean_over_runs(forces.wrist_pin.force).value, options.members)

    def reference() -> Reference:
        forces = exact_forces(REFERENCE_MEMBERS)
        mean, doubt = np.mean(forces), np.std(forces, ddof=1) / np.sqrt(len(forces))
        other = run_fixed_steps(
            linkage, study(REFERENCE_MEMBERS), "dormand_prince", REFERENCE_STEPS
        )
        apart = abs(float(mean_over_runs(other.wrist_pin.force).value[0]) / mean - 1.0)
        agreement = max(apart, float(doubt / mean))
        return Reference(
            np.array([mean]),
            agreement,
            f"{REFERENCE_MEMBERS} members from contact to contact, standard error "
            f"{doubt / mean:.1e}; the same with {REFERENCE_STEPS} fixed steps are {apart:.1e} off",
        )

    members = sorted({2, 8, 32, 64} | {options.members})
    return Topic(
        stage="impact",
        name="mean force of an ensemble",
        words=f"mean force of the wrist pin over the first turn from spread starts, clearance "
        f"{clearance:.4g} m; the case itself discards {options.discard} turns and counts "
        f"{options.revolutions}",
        quantity="response/impact/mean_force",
        unit="N",
        work="runs over one turn",
        reference=reference,
        ladders=(
            Ladder(
                "from contact to contact",
                "N members whose starts are spread by an additive recurrence",
                "members",
                tuple(float(x) for x in members),
                exact,
                default=float(options.members),
                theory="standard error of order 1/2",
                citation="Niederreiter (1992), ch. 3",
            ),
            Ladder(
                "RK4",
                f"{options.members} members with N fixed steps per turn",
                "steps",
                FIXED_STEPS,
                fixed,
                citation="Ong (2000), chapter 5",
            ),
        ),
        default_extra=float(options.members) / 2.0,
        default_why="a few members may come close by chance: their number is chosen for the "
        "standard error, which is stored with the result",
    )
