"""Questions of machines that roll: running state, largest slip, start-up, control."""

from functools import partial
from math import ceil, log

import numpy as np

from vibecalc.core.accuracy.kinds import (
    TURN,
    Counted,
    harmonics,
    peak_over_range,
    periodic,
    time_history,
)
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.numerics.runge_kutta_march import march
from vibecalc.roll.adapters.control import setup
from vibecalc.roll.adapters.start_up import COARSEST, FINEST, SHARE, load_of
from vibecalc.roll.between_kinks import acting_at, running, slot_at, slots_of
from vibecalc.roll.control.loop import disturbance
from vibecalc.roll.mechanism import as_batch, is_mounted, place_at, smooth_angles
from vibecalc.roll.methods import Settings, find
from vibecalc.roll.model import build_roll, fitted_motor, roll_drive
from vibecalc.roll.rates import shell_speed
from vibecalc.roll.running import Running, running_state
from vibecalc.roll.start_up_system import (
    ANGLE,
    SHELL_ANGLE,
    SHELL_SPEED,
    SPEED,
    STATES,
    LoadSteps,
    StartUpSystem,
)
from vibecalc.roll.steady import SteadyTurn, steady_state
from vibecalc.roll.turn import Turn, peak, shell_harmonics
from vibecalc.roll.turn import harmonics as harmonics_of_turn

#: Gauss points of the reference, steps of the marches in s, points of the others
POINTS, STEPS, FOURIER = 14, (2e-3, 1e-3, 5e-4, 2.5e-4), (45, 91, 181, 361)
#: s of a start that are followed; share of the tolerance of a run's second march, its parts
FIRST, FINER, PARTS = 0.1, 0.125, 2
_COLUMNS = [ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED]


def roll_topics(scene: Scene) -> list[Topic]:
    """What [response.roll] asks: harmonics of the shell's acceleration, and the largest slip."""
    response, case = scene.case.response, scene.case
    if response is None or response.roll is None:
        return []
    options, parts = response.roll, build_roll(case)
    drive, machine = roll_drive(parts), as_batch(parts.machine)
    fitted = fitted_motor(parts.motor)
    if fitted is not None:
        drive = drive._replace(circuit=fitted.circuit)
    orders, started = np.arange(1.0, options.orders + 1), options.started_at
    points = options.points if options.method == "collocation" else None

    def run(rtol: float, points: int | None = None) -> Running:
        return running_state(machine, drive, rtol=rtol, orders=options.orders,
                             started_at=started, points=points, between_points=True)  # fmt: skip

    own = run(case.accuracy.rtol, points)
    slip = _slip(own, float(np.max(drive.synchronous_speed)))
    if drive.circuit is not None:  # its fluxes have no plain equations of motion here
        return [slip]

    def spectrum(turn: Turn, shell: FloatArray | None = None) -> ComplexArray:
        if shell is None:
            return np.asarray(shell_harmonics(machine, drive, turn, orders)[0])
        return np.asarray(harmonics_of_turn(turn, shell, orders)[0])

    def as_run(rtol: float) -> Answer:
        found = run(rtol)
        # of the levels before these nothing is left
        left = [one for one in (found.coarse, found.check, found.state) if one is not None]
        work = sum(_evaluations(one) for one in left)
        return Answer(spectrum(found.state.turn), float(work))

    def split(count: float) -> Answer:
        found = steady_state(machine, drive, int(count), started_at=started,
                             tolerance=1e-9 if count < 5 else 1e-13)  # fmt: skip
        if not found.solved[0]:
            raise NumericalFailure(f"no running state is found with {int(count)} points")
        return Answer(spectrum(found.turn), float(found.evaluations))

    fading = float(np.max(np.abs(own.multiplier)))

    def chosen(method: str, points: int | None, step: float | None) -> Answer:
        asked = Settings(points, step, started, own.state.momentum, fading)
        found = find(method, machine, drive, asked)
        return Answer(spectrum(found.turn), float(found.work))

    solvers = [
        Solver("collocation", as_run, "rtol", (1e-3, 1e-5, 1e-7, 1e-9, 1e-11),
               None if points else case.accuracy.rtol),
        Solver("collocation, points", split, "points a panel", (1, 2, 3, 4, 5, 6, 8, 10), points,
               "geometric"),
        Solver("fourier", lambda n: chosen("fourier", int(n), None), "points a turn", FOURIER,
               None),
        Solver("shooting", lambda _: chosen("shooting", None, None), default=None),
    ]  # fmt: skip
    if 1 + ceil(log(1e-12) / log(max(fading, 1e-12))) <= 40:
        solvers += [
            Solver(method, partial(chosen, method, None), "time step [s]", steps, None)
            for method, steps in (("euler", STEPS), ("rk4", STEPS[:3]))
        ]
    fine = steady_state(machine, drive, POINTS, started_at=started, start=own.state)
    if not fine.solved[0]:
        raise NumericalFailure(f"collocation with {POINTS} points loses the running state")
    turn, rates = fine.turn, running(parts.machine, drive)
    start = np.array([0.0, fine.solution.left[0, 0, 0], 0.0, turn.shell_speed[0, 0]])
    if is_mounted(machine):
        start[2:] = fine.solution.left[0, 0, 1:3]
    else:
        start[3] = shell_speed(place_at(machine, drive, np.zeros((1, 1))), own.state.momentum,
                               start[None, 1:2])[0, 0]  # fmt: skip
    nodes = turn.crank_angle[0]

    def by_angle(angle: float, states: FloatArray) -> FloatArray:
        """Time, crank speed, angle and speed of the shell in rows, over the crank angle."""
        found = []
        for w, theta, s in states[:, 1:].tolist():
            crank, shell = rates(angle, w, theta, s)
            found.append((1.0 / w, crank / w, s / w, shell / w))
        return np.array(found)

    def read(_: FloatArray, states: FloatArray) -> ComplexArray:
        path = states[:-1]
        along = zip(nodes.tolist(), path.tolist(), strict=True)
        shell = [rates(angle, *row[1:])[1] for angle, row in along]
        again = Turn(turn.crank_angle, turn.weight, path[None, :, 0], path[None, :, 1],
                     path[None, :, 3], path[None, :, 2], states[-1:, 0])  # fmt: skip
        return spectrum(again, np.array(shell)[None])

    ask = Ask("spectrum", f"harmonics 1 to {options.orders} of the shell's acceleration",
              "response/roll/shell_acceleration", 4.0,
              "other numbers of points prove the error, multipliers the stability")  # fmt: skip
    scale = np.array([TURN / start[1], start[1], 1e-2, 1.0])
    unknown = (1, 2, 3) if is_mounted(machine) else (1,)
    times = np.concatenate([[0.0], nodes, [TURN]])
    return [slip, periodic(ask, solvers, by_angle, start, unknown, unknown, times, read, scale,
                           lambda: spectrum(turn), fine.solution.edges[0])]  # fmt: skip


def _evaluations(state: SteadyTurn) -> int:
    """Of the right-hand side, those of the multipliers and readings between points included."""
    return max(state.evaluations, int(getattr(state.problem.rhs, "evaluations", 0)))


def _slip(own: Running, synchronous: float) -> Topic:
    """The largest slip within a turn of the running state found, whose error does not count."""
    turn = own.state.turn
    known = float(turn.crank_angle[0][np.argmin(turn.crank_speed[0])])

    def slowest(angles: FloatArray) -> FloatArray:
        return -evaluate(own.state.solution, np.mod(angles, TURN))[0, :, 0]

    def closer(_: float) -> Answer:
        counted = Counted(slowest)
        top, _ = peak(counted, (turn.crank_angle[0], -turn.crank_speed[0]))
        return Answer(synchronous + top, float(counted.asked))

    ask = Ask("largest slip", "within a turn of the running state", "response/roll/largest_slip",
              12.0, "up to four peaks are followed, to the last digit")  # fmt: skip
    solver = Solver("closer and closer samples", closer)
    ends = known - 0.5 * TURN, known + 0.5 * TURN
    return peak_over_range(ask, solver, lambda angles: synchronous + slowest(angles), ends, known,
                           around=True)  # fmt: skip


def start_up_topics(scene: Scene) -> list[Topic]:
    """Speeds of crank and shell at the end of the first tenth of a second of a start."""
    response = scene.case.response
    if response is None or response.start_up is None:
        return []
    options, parts = response.start_up, build_roll(scene.case)
    machine, drive, end = parts.machine, roll_drive(parts), min(options.duration, FIRST)
    load = load_of(options)
    if len(load.time) > 1 and load.time[1] > end:  # a later change is brought forward
        load = LoadSteps(np.array([0.0, 0.5 * end]), load.factor[:2])
    start = np.array([options.crank_angle, options.speed, 0.0, 0.0])
    tolerance = min(max(SHARE * scene.case.accuracy.rtol, FINEST), COARSEST)
    slots, synchronous = slots_of(machine, drive), float(drive.synchronous_speed)
    acting = acting_at(machine, drive, slots)

    def rates(time: float, y: FloatArray) -> FloatArray:
        b, w, theta, s = y.tolist()
        part = int(np.searchsorted(drive.motor.threshold, synchronous - w, side="right"))
        row = int(np.searchsorted(load.time, time, side="right")) - 1
        found = acting(b, w, theta, s, int(slot_at(slots, y[:1])[0]), part, 1 if w >= 0.0 else -1,
                       float(load.factor[row]))  # fmt: skip
        return np.array([y[1], found.crank, y[3], found.shell])

    def marched(tolerance: float, pieces: int) -> Answer:
        system = StartUpSystem(machine, drive, load, tolerance)
        first = np.zeros((1, STATES))
        first[0, _COLUMNS] = start
        found = march(
            system, np.zeros(1), first, system.first_intervals(first, 0.0), np.array([end]),
            absolute=tolerance * system.scale, stops=load.time[None, :], parts=pieces, keep=False,
        )  # fmt: skip
        work = 6 * (int(found.steps[0]) + int(found.rejected[0])) + 1
        return Answer(found.state[0, [SPEED, SHELL_SPEED]], float(work))

    def twice(tolerance: float) -> Answer:
        fine = marched(tolerance * FINER, PARTS)
        return fine._replace(work=fine.work + marched(tolerance, 1).work)

    ask = Ask("motion", f"speeds of crank and shell after {end:g} s",
              "response/start_up/history/crank_speed_low", 4.0,
              "a second march to an eighth of the tolerance proves the error")  # fmt: skip
    settings = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
    solver = Solver("two marches", twice, "tolerance of a step", settings, tolerance)
    size = np.array([1.0, synchronous, 1e-3, 1.0])
    return [time_history(ask, solver, rates, start, np.array([0.0, end]),
                         lambda states: states[-1, [1, 3]], size,
                         lambda: marched(1e-11, 4).values, stops=load.time)]  # fmt: skip


def control_topics(scene: Scene) -> list[Topic]:
    """The load on the rotor: the reply to it is a closed form at each order."""
    response = scene.case.response
    if response is None or response.control is None:
        return []
    given = setup(scene.case)
    orders, machine, drive = len(given.orders), given.machine, given.drive
    edges = smooth_angles(machine, drive)

    def own(_: float) -> Answer:
        found = disturbance(machine, drive, orders)
        points = 10 + ceil(0.5 * orders * np.pi / 18.0)
        values = np.append(found.mean.value + 0j, found.at(given.target).value)
        return Answer(values, float((len(edges) - 1) * (2 * points + 4)))

    def signal(angle: FloatArray) -> FloatArray:
        place = place_at(machine, drive, np.asarray(angle, dtype=float)[None])
        return np.asarray(place.load[0] - 0.5 * given.target**2 * place.moved.crank_slope[0])

    ask = Ask("load", f"mean and harmonics 1 to {orders} of the load on the rotor",
              "response/control/disturbance", 6.0,
              "two rules prove the error, for any table of gas forces")  # fmt: skip
    solver = Solver("two Gauss rules", own)
    return [harmonics(ask, [solver], signal, np.arange(orders + 1), edges)]
