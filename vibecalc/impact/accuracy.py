"""Accuracy of impacts: the first contacts in a joint, and the mean force of an ensemble."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import Rates, march_fixed, march_scipy
from vibecalc.core.accuracy.topic import Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.impact.linkage import Linkage, Starts, central_start, spread_starts
from vibecalc.impact.model import build_joints
from vibecalc.impact.runs import Study, follow_events, run_fixed_steps
from vibecalc.impact.setup import DEGREE, REACH
from vibecalc.impact.statistics import mean_over_runs

if TYPE_CHECKING:
    from vibecalc.response.tables import Impact

# ----------------------------------------------------------------------------
# Topics of impacts: the first contacts in a joint with play, and the mean force of an ensemble.
#
# Runs part exponentially, so that only the beginning of one run can be held to a truth; of later
# turns only statistics of many runs are results, with a standard error of their own.
# ----------------------------------------------------------------------------

#: angles at which the gap is compared, and how many of them the first eighth of a turn holds
SAMPLES, SHOWN = 96, 12
STEPS = (48.0, 96.0, 192.0, 384.0, 768.0, 1536.0, 3072.0)
RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
REFERENCE_MEMBERS, REFERENCE_STEPS = 256, 2048
FIXED_STEPS = (128.0, 256.0, 512.0, 1024.0)


def impact_topics(scene: Scene) -> list[Topic]:
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
        solvers=(
            Solver(
                "from contact to contact",
                f"power series of degree {DEGREE}, contacts found as roots of them",
                "parts of a panel",
                (1.0, 2.0, 3.0),
                exact,
                default=1.0,
                theory="the result does not depend on it",
                citation="docs/theory.md",
            ),
            Solver(
                "Euler", "explicit Euler across the contacts", "steps", STEPS,
                lambda steps: fixed("euler", steps), theory="order 1",
            ),
            Solver(
                "RK4",
                "classical Runge-Kutta across the contacts",
                "steps",
                STEPS,
                lambda steps: fixed("rk4", steps),
                theory="order 4 within a contact, less at its ends",
                citation="Ong (2000), chapter 5",
            ),
            Solver(
                "RK45", "scipy's pair of Dormand and Prince across the contacts", "rtol", RTOLS,
                lambda rtol: adaptive("RK45", rtol),
            ),
            Solver(
                "DOP853", "scipy across the contacts", "rtol", RTOLS,
                lambda rtol: adaptive("DOP853", rtol),
            ),
            Solver(
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
        mean, uncertainty = np.mean(forces), np.std(forces, ddof=1) / np.sqrt(len(forces))
        other = run_fixed_steps(
            linkage, study(REFERENCE_MEMBERS), "dormand_prince", REFERENCE_STEPS
        )
        apart = abs(float(mean_over_runs(other.wrist_pin.force).value[0]) / mean - 1.0)
        agreement = max(apart, float(uncertainty / mean))
        return Reference(
            np.array([mean]),
            agreement,
            f"{REFERENCE_MEMBERS} members from contact to contact, standard error "
            f"{uncertainty / mean:.1e}; with {REFERENCE_STEPS} fixed steps {apart:.1e} apart",
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
        solvers=(
            Solver(
                "from contact to contact",
                "N members whose starts are spread by an additive recurrence",
                "members",
                tuple(float(x) for x in members),
                exact,
                default=float(options.members),
                theory="standard error of order 1/2",
                citation="Niederreiter (1992), ch. 3",
            ),
            Solver(
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


# ----------------------------------------------------------------------------
# A piston with play in its wrist pin as a plain system of two states, for integrators.
# ----------------------------------------------------------------------------


class Play(NamedTuple):
    """One gap: rates of (gap, velocity), with the side given or found; lengths in m.

    `rates_on(side)` keeps the law of one side (-1 below, 0 free, 1 above the clearance), however
    far the gap goes; `rates` takes it from the gap.
    """

    clearance: float
    contact: float
    rates: Rates
    rates_on: Callable[[int], Rates]


def play_of(linkage: Linkage, clearance: float) -> Play:
    """The wrist pin of a linkage that has no other play.

    Raises NumericalFailure for a linkage with more than one gap.
    """
    if linkage.crank_pin is not None or linkage.bore is not None:
        raise NumericalFailure("this plain system has one gap only")
    drive, joint, mass = linkage.drive, linkage.wrist_pin, float(linkage.mass)
    stiffness = float(joint.stiffness)
    in_contact, in_film = float(joint.contact_damping), float(joint.film_damping)
    rest = clearance if joint.law == "continuous" else 0.0
    strength = -np.square(drive.orders * drive.speed) * drive.displacement
    turning = 1j * drive.orders * drive.speed
    angle, force = np.asarray(linkage.gas.angle), np.asarray(linkage.gas.force)

    def acceleration(time: float, gap: float, velocity: float, side: int) -> float:
        pin = float((strength @ np.exp(turning * time)).real)
        turned = (drive.speed * time) % (2.0 * math.pi)
        gas = float(np.interp(turned, angle, force, period=2.0 * math.pi)) if force.size else 0.0
        if side == 0:
            own = in_film * velocity
        else:
            own = stiffness * (gap - (rest if side > 0 else 0.0)) + in_contact * velocity
        return pin - (own + gas) / mass

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        gap, velocity = float(state[0]), float(state[1])
        side = (gap > clearance) - (gap < 0.0)
        return np.array([velocity, acceleration(time, gap, velocity, side)])

    def rates_on(side: int) -> Rates:
        def on_side(time: float, state: np.ndarray) -> np.ndarray:
            gap, velocity = float(state[0]), float(state[1])
            return np.array([velocity, acceleration(time, gap, velocity, side)])

        return on_side

    return Play(clearance, math.pi * math.sqrt(mass / stiffness), rates, rates_on)


def by_events(
    play: Play, start: np.ndarray, times: np.ndarray, rtol: float, kinks: np.ndarray
) -> tuple[np.ndarray, int]:
    """Gap (k,) at `times` (k,), from contact to contact with the events of scipy's DOP853.

    Steps end at the `kinks` (s) of the gas force and stay below a fifth of a contact, without
    which contacts are passed over. Also evaluations of the right-hand side.

    Raises
    ------
    NumericalFailure
        scipy gives up.
    """
    from scipy.integrate import solve_ivp

    stops = np.append(kinks[(kinks > 0.0) & (kinks < times[-1])], times[-1])
    now, state = 0.0, start.astype(float)
    side = int(state[0] > play.clearance) - int(state[0] < 0.0)
    found, evaluations = np.full(len(times), np.nan), 0
    while now < times[-1]:
        faces = {1: [(play.clearance, -1)], -1: [(0.0, 1)]}.get(
            side, [(play.clearance, 1), (0.0, -1)]
        )
        answer = solve_ivp(
            play.rates_on(side),
            (now, float(stops[stops > now][0])),
            state,
            method="DOP853",
            rtol=rtol,
            atol=rtol * np.array([1e-3 * play.clearance, 1e-3 * play.clearance / play.contact]),
            events=[_crossing(*face) for face in faces],
            max_step=play.contact / 5.0,
            dense_output=True,
        )
        if not answer.success:
            raise NumericalFailure(f"DOP853 with events gave up: {answer.message}")
        evaluations += int(answer.nfev)
        then = float(answer.t[-1])
        here = (times > now) & (times <= then)
        if np.any(here):
            found[here] = answer.sol(times[here])[0]
        now, state = then, answer.y[:, -1].copy()
        if answer.status == 1:
            hit = next(k for k, each in enumerate(answer.t_events) if len(each))
            state[0], way = faces[hit]
            side += way
    return found, evaluations


def _crossing(face: float, way: int) -> Callable[[float, np.ndarray], float]:
    def crosses(time: float, state: np.ndarray) -> float:
        return float(state[0] - face)

    crosses.terminal, crosses.direction = True, way  # type: ignore[attr-defined]
    return crosses
