"""Adapter: the periodic motion of rotor, pistons and shell, and the studies made of it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.excitation.crank_forces import train_excitation
from vibecalc.excitation.inertia_forces import couples_of, forces_of, size_of_terms
from vibecalc.kinematics.adapter import exact_motion
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.roll.adapters.motor import emit_motor, uncertain
from vibecalc.roll.adapters.readings import (
    MachineTurn,
    TurnSolutions,
    emit_spectra,
    extremes_of,
    leak_of,
    machine_turn,
    numbers_of,
    peaks_of,
    spectra_of,
    spectrum_paths,
    time_history,
)
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch, is_mounted
from vibecalc.roll.methods import Settings, find
from vibecalc.roll.model import RollParts, build_roll, fitted_motor, roll_drive
from vibecalc.roll.results import FORCES, ROLL, SHAKING, VARIABLES
from vibecalc.roll.running import Running, motion_of_turn, running_state
from vibecalc.roll.sensitivity import changes, sensitivity
from vibecalc.roll.tables import Roll
from vibecalc.roll.turn import (
    Turn,
    by_cylinder,
    classical,
    constant_speed,
    level,
    readings,
    shell_harmonics,
    spectrum,
)

# ----------------------------------------------------------------------------
# Adapter: rotor, pistons and shell in the periodic motion that their motor gives them.
# ----------------------------------------------------------------------------

_ROUNDING = 32.0 * EPSILON
#: zero for the exact motion, so that all of it is error
_ZERO = ("energy/residual", "momentum_residual")
#: safety of a difference of settings where the case has chosen the points
_CHOSEN = 2.0


#: dB; what rounding leaves in a level
_STUDY_ROUNDING = 1e-11
#: dB below the largest harmonic, from which on there is only rounding
_SILENT = 240.0
#: parameters are altered by this share, up and down
_SHARE = 0.1
#: crank angles at which forces are held against those of the textbook
_GRID = 1441


def run_roll(scene: Scene) -> None:
    """Emit the running state, its spectra and balances, and what the case asks for next to it."""
    response = scene.case.response
    assert response is not None and response.roll is not None
    options, parts = response.roll, build_roll(scene.case)
    machine, drive = as_batch(parts.machine), roll_drive(parts)
    fitted = fitted_motor(parts.motor)
    checked = drive
    if fitted is not None:
        checked = drive._replace(circuit=fitted.other)
        drive = drive._replace(circuit=fitted.circuit)
    _cite(scene)
    running = running_state(
        machine, drive, rtol=scene.case.accuracy.rtol, orders=options.orders,
        started_at=options.started_at,
        points=options.points if options.method == "collocation" else None,
        between_points=scene.wants(*_below("cycle")),
    )  # fmt: skip
    if fitted is not None:
        running = uncertain(machine, checked, running, options.started_at)
    solutions = _solutions(options, machine, drive, checked, running)
    run = RollRun(scene, options, parts, machine, drive, running, solutions)
    run.emit_spectra()
    run.emit_numbers()
    run.emit_time_history()
    run.emit_stability()
    if fitted is not None and scene.wants(*_below("motor")):
        emit_motor(scene, options, machine, fitted, running, (solutions.solution, solutions.other))
    for asked, part, emit in (
        (options.interpolations, "interpolation", run.emit_interpolations),
        (options.compare, "method", run.emit_methods),
        (options.sensitivity, "sensitivity", run.emit_sensitivity),
        (options.classical, "classical", run.emit_classical),
        (options.classical, "shaking", run.emit_shaking),
    ):
        if asked and scene.wants(*_below(part)):
            emit()


def _below(part: str) -> tuple[str, ...]:
    return below(f"{ROLL}/{part}/")


def _solutions(
    options: Roll, machine: RollMachine, drive: RollDrive, checked: RollDrive, running: Running
) -> TurnSolutions:
    """The motion by the method of the case, from its setting and a finer (or coarser) one.

    `checked` is the drive of the check: that of the motion, but for what a fit leaves open.
    """
    one, other = (
        machine_turn(machine, chosen, state)
        for chosen, state in ((drive, running.state), (checked, running.check))
    )
    if options.method == "collocation":
        # with points of the case nobody has checked whether these are enough
        near = running.coarse
        if near is None:
            return TurnSolutions(one, other, safety=_CHOSEN if options.points else 1.0)
        last, before = running.state.points, running.check.points
        steps = (last - before) / (before - near.points)
        return TurnSolutions(one, other, coarse=machine_turn(machine, drive, near), steps=steps)
    computed = find(options.method, machine, drive, _settings(options, running, options.points))
    each = [
        MachineTurn(machine, drive, turn, motion_of_turn(turn))
        for turn in (computed.turn, computed.finer)
    ]
    return TurnSolutions(each[0], each[1], computed.order, best=(one, other))


def _settings(options: Roll, running: Running, points: int | None) -> Settings:
    fading = float(np.max(np.abs(running.multiplier)))
    return Settings(points, options.step, options.started_at, running.state.momentum, fading)


def _cite(scene: Scene) -> None:
    scene.cite(
        "Gauss collocation over the crank angle on panels split at every kink, Newton's method",
        "running state, its speed and its stability",
        "docs/theory_roll.md; cf. Ascher, Mattheij and Russell (1995), section 5.4",
    )
    scene.cite(
        "Lagrange's equations of rotor, pistons and shell, exact kinematics",
        "roll of the shell",
        "Herold (1977), equations 44 to 91 with their misprints corrected",
    )


@dataclass(frozen=True)
class RollRun:
    """A running state with what it was found from, and all that is emitted of it."""

    scene: Scene
    options: Roll
    parts: RollParts
    machine: RollMachine
    drive: RollDrive
    running: Running
    solutions: TurnSolutions

    @property
    def orders(self) -> np.ndarray:
        """Orders of the spectra."""
        return np.arange(1, self.options.orders + 1)

    @property
    def names(self) -> np.ndarray:
        """Names of the cylinders."""
        return np.array(self.parts.names, dtype=object)

    def emit_spectra(self) -> None:
        """Harmonics of all variables, with the errors that the settings show."""
        names = [name for name in (*VARIABLES, *FORCES) if self.scene.wants(*spectrum_paths(name))]
        spectra = self.solutions.read(lambda seen: spectra_of(seen, self.options.orders, names))
        leak, found = leak_of(self.solutions.solution), {}
        for name, (values, rounding) in spectra[0].items():
            error = self.solutions.error(*(each[name][0] for each in spectra)) + rounding
            found[name] = Bounded(values, error + leak * np.max(np.abs(values), initial=0.0))
        emit_spectra(self.scene, found, {"order": self.orders, "cylinder": self.names})

    def emit_numbers(self) -> None:
        """Speed, slip, torque, balances."""
        each, leak = self.solutions.read(numbers_of), leak_of(self.solutions.solution)
        extremes: frozenset[str] = frozenset()
        names = ("speed_variation", "largest_slip", "largest_torque")
        if self.scene.wants(*(f"{ROLL}/{name}" for name in names)):
            for values_of, more in zip(each, self.solutions.read(extremes_of), strict=True):
                values_of.update(more)
                extremes = frozenset(more)
        for name, number in each[0].items():
            values = [values_of[name].value for values_of in each]
            # a margin without end has no error
            finite = np.all(np.isfinite(values))
            single = name in extremes
            apart = float(self.solutions.error(*values, single=single)) if finite else 0.0
            error = apart + number.error + (_ROUNDING + leak) * number.size
            if name in _ZERO:
                error = max(error, abs(number.value))
            self.scene.emit(f"{ROLL}/{name}", number.value, error, terms=number.size)

    def emit_time_history(self) -> None:
        """Variables and forces over the turn, and the largest of the forces."""
        if self.scene.wants(*_below("cycle")):
            histories = self.solutions.read(time_history)
            angles, values_of = histories[0]
            axes = {"cylinder": self.names, "crank_angle": angles}
            for name, values in values_of.items():
                rounding = _ROUNDING * float(np.max(np.abs(values), initial=0.0))
                error = self.solutions.error(*(each[name] for _, each in histories)) + rounding
                self.scene.emit(f"{ROLL}/cycle/{name}", values, error, axes)
        if self.scene.wants(*(f"{ROLL}/{name}_peak" for name in FORCES)):
            peaks = self.solutions.read(peaks_of)
            for name, (values, left) in peaks[0].items():
                apart = self.solutions.error(*(each[name][0] for each in peaks), single=True)
                error = apart + left + _ROUNDING * values
                self.scene.emit(f"{ROLL}/{name}_peak", values, error, {"cylinder": self.names})

    def emit_stability(self) -> None:
        """Floquet multipliers."""
        value, error = self.running.multiplier[0], self.running.multiplier_error[0]
        largest = Bounded(np.max(np.abs(value)), np.max(error))
        found = {
            "multiplier": Bounded(value, error),
            "largest_multiplier": largest,
            "trivial_multipliers": 1 if is_mounted(self.machine) else 3,
        }
        axes = {"multiplier": np.arange(1, len(value) + 1)}
        self.scene.emit_all({f"{ROLL}/{name}": one for name, one in found.items()}, axes)

    def levels(self, turn: Turn, drive: RollDrive | None = None) -> FloatArray:
        """Levels of the shell's acceleration; orders that are nothing but rounding are -inf."""
        values = shell_harmonics(self.machine, drive or self.drive, turn, self.options.orders)
        found = level(values)[0]
        return np.where(found > np.max(found) - _SILENT, found, -np.inf)

    def emit_interpolations(self) -> None:
        """Levels with every interpolation of the gas tables, and what these differ by."""
        levels, uncertainty = [], []
        for interpolation in self.parts.interpolations:
            drive = self.drive._replace(gas=roll_drive(self.parts, interpolation).gas)
            running = running_state(
                self.machine, drive, rtol=self.scene.case.accuracy.rtol,
                orders=self.options.orders, started_at=self.options.started_at,
            )  # fmt: skip
            each = [self.levels(one.turn, drive) for one in (running.state, running.check)]
            levels.append(each[0])
            uncertainty.append(np.abs(_apart(*each)))
        if not levels:
            return
        values, error = np.array(levels), np.array(uncertainty) + _STUDY_ROUNDING
        axes = {"interpolant": self.parts.interpolations, "order": self.orders}
        self.scene.emit(f"{ROLL}/interpolation/level", values, error, axes)
        known = np.all(np.isfinite(values), axis=0)
        lowest, highest = (np.where(known, f(values, axis=0), 0.0) for f in (np.min, np.max))
        spread, off = highest - lowest, 2.0 * np.max(error)
        self.scene.emit(f"{ROLL}/interpolation/spread", spread, off, axes)

    def emit_methods(self) -> None:
        """Levels by other methods, less those of the method of the case, and the work of each."""
        asked = _settings(self.options, self.running, None)
        levels, uncertainties, works = [], [], []
        names = tuple(dict.fromkeys(self.options.compare))
        state, check = self.running.state, self.running.check
        level, twin = self.levels(state.turn), self.levels(check.turn)
        for name in names:
            turn, finer, work = state.turn, check.turn, state.evaluations
            if name != "collocation":
                turn, finer, _, work = find(name, self.machine, self.drive, asked)
            each = [self.levels(one) for one in (turn, finer)]
            levels.append(each[0])
            # no other method is known better than it agrees with collocation
            apart = np.abs(_apart(each[0], level)) + np.abs(_apart(level, twin))
            uncertainties.append(np.maximum(2.0 * np.abs(_apart(*each)), apart) + _STUDY_ROUNDING)
            works.append(work)
        axes = {"method": names, "order": self.orders}
        values, error = np.array(levels), np.array(uncertainties)
        self.scene.emit(f"{ROLL}/method/level", values, error, axes)
        self.scene.emit(f"{ROLL}/method/difference", _apart(values, level), error, axes)
        self.scene.emit(f"{ROLL}/method/work", works, 0.0, axes)

    def emit_sensitivity(self) -> None:
        """Slopes of the levels by every parameter, and what ten percent more and less of each do.

        All for the orders that are there at all.
        """
        levels = self.levels(self.running.state.turn)
        orders = [int(n) for n in self.orders[np.isfinite(levels)]]
        of = (self.machine, self.drive, orders, self.parts.names)
        given: dict[str, Any] = {
            "points": self.running.state.points, "started_at": self.options.started_at
        }  # fmt: skip
        slopes = sensitivity(*of, **given)
        altered = changes(*of, (1.0 + _SHARE, 1.0 - _SHARE), **given)
        axes = {"parameter": slopes.parameters, "order": orders}
        self.scene.emit(f"{ROLL}/sensitivity/level", slopes.value, slopes.error, axes)
        for word, change in zip(("more", "less"), altered, strict=True):
            path = f"{ROLL}/sensitivity/ten_percent_{word}"
            axes = {"parameter": change.parameters, "order": orders}
            self.scene.emit(path, change.value, change.error, axes)
            for name, reason in change.lost:
                self.scene.warn(
                    f"sensitivity: no result for ten percent {word} of {name}: {reason}"
                )
        self.scene.cite(
            "central differences in the logarithm of each parameter, extrapolated",
            "slopes of the levels of the shell",
            "docs/theory_roll.md, section 2",
        )
        self.scene.cite(
            "the running state of the machine with each parameter ten percent larger and smaller",
            "what to change on the machine",
            "docs/theory_roll.md, section 2",
        )

    def emit_classical(self) -> None:
        """What constant speed and a fixed shell get wrong in the forces at the pistons."""
        numbers = self.orders.astype(float)
        each = self.solutions.read(lambda seen: _mistakes(seen, numbers))
        axes = {"cylinder": self.names, "order": self.orders}
        for name in FORCES:
            largest = np.max(np.abs(each[0][name][0]))
            of_force = (mistakes[name] for mistakes in each)
            for what, *values in zip(_MISTAKES, *of_force, strict=True):
                error = self.solutions.error(*values) + 1e-13 * largest
                self.scene.emit(f"{ROLL}/classical/{name}_{what}", values[0], error, axes)

    def emit_shaking(self) -> None:
        """What the textbook says of the body's shaking."""
        best = self.solutions.best or (self.solutions.other,)
        emit_shaking(self.scene, self.solutions.solution, best[0], self.options.orders)


_MISTAKES = ("peak", "error", "error_by_order")


def _mistakes(
    solved: MachineTurn, numbers: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray, np.ndarray]]:
    """Peak, largest error over the peak, error of the harmonics; for each force, each cylinder."""
    machine, drive, turn = solved[:3]
    right, plain = readings(machine, drive, turn), classical(machine, drive, turn)
    # peaks and errors on an even grid, the same for every setting
    even = solved.motion(np.linspace(0.0, 2.0 * np.pi, _GRID))
    flat, exact = classical(machine, drive, even), readings(machine, drive, even)
    mistakes = {}
    for name, force in plain.items():
        textbook, true = flat[name][0], np.asarray(getattr(exact, name))[0]
        peak = np.max(np.abs(true), axis=0)
        off = np.max(np.abs(textbook - true), axis=0)
        held = by_cylinder(constant_speed(turn), force, numbers)[0]
        mistakes[name] = (
            np.max(np.abs(textbook), axis=0),
            off / np.where(peak > 0.0, peak, 1.0),
            held - spectrum(turn, right, name, numbers)[0],
        )
    return mistakes


def _apart(one: FloatArray, other: FloatArray) -> FloatArray:
    """Differences of levels; none where both are zero, or one of them."""
    both = np.isfinite(one) & np.isfinite(other)
    return np.where(both, np.where(both, one, 0.0) - np.where(both, other, 0.0), 0.0)


# ----------------------------------------------------------------------------
# Adapter: what the textbook says of the body's shaking, next to the roll that it leaves out.
#
# At constant speed, in a shell that does not turn, masses shake the body by a force and a couple,
# and gas and motor are inner forces. Both can be balanced to nothing, and the shell rolls still.
# ----------------------------------------------------------------------------

DIRECTIONS = ("x", "y", "z")


def emit_shaking(scene: Scene, solved: MachineTurn, finer: MachineTurn, orders: int) -> None:
    """Force and couple of the masses at the mean speed found, orders 1 .. `orders`, and peaks.

    The peaks are of all orders.
    """
    train = scene.parts.crank_train
    motion, _ = exact_motion(scene.case, train, orders)
    driven = train_excitation(train, scene.parts.rotating_masses, motion, scene.case.machine)
    speed, other = (2.0 * np.pi / float(one.turn.period[0]) for one in (solved, finer))
    square, uncertainty = speed**2, abs(speed**2 - other**2)
    numbers, retained = np.arange(1, motion.highest_order + 1), motion.highest_order
    for name, value, error in (
        ("force", *forces_of(driven)),
        ("couple", *couples_of(driven)),
    ):
        off = square * error + uncertainty * np.abs(value)
        axes = {"order": numbers[:orders], "direction": DIRECTIONS}
        rounding = square * error
        scene.emit(
            f"{SHAKING}/{name}",
            square * value[:orders],
            off[:orders],
            axes,
            terms=size_of_terms(rounding[:orders]),
        )
        peak = cycle_peak(square * value[:retained].T, numbers)
        spread = off[:retained].sum(0) + motion.tail * square * np.abs(value[retained:]).sum(0)
        axes = {"direction": DIRECTIONS}
        terms = size_of_terms(peak.error + rounding[:retained].sum(0))
        scene.emit(f"{SHAKING}/{name}_peak", peak.value, peak.error + spread, axes, terms=terms)
    scene.cite(
        "d'Alembert sums of the crank train at the mean speed found",
        "forces and couples that constant speed and a fixed shell leave",
        "Biezeno and Grammel, Technische Dynamik, 2nd ed. 1953, ch. XI",
    )
