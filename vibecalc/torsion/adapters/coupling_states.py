"""Couplings whose stiffness and damping follow what the line does: load, heat, vibration."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.numerics.synthesis import sum_error, synthesis
from vibecalc.torsion.adapters.critical import asked_range, met_criticals
from vibecalc.torsion.adapters.motion import Motion, blocks, mean_torques, solved
from vibecalc.torsion.adapters.setup import Setup, natural_of, undamped_modes
from vibecalc.torsion.couplings import Conditions, Coupling, CouplingStates, Moved

# ----------------------------------------------------------------------------
# The line at a speed and a frequency, under the conditions that its couplings are in.
# ----------------------------------------------------------------------------


#: speeds of the range at which errors of stiffnesses are read, next to the operating one
_READ = 5


def _spread(solver: "_Solver") -> float:
    """Largest relative error of a stiffness or loss factor, from errors of the conditions."""
    setup, none, largest = solver.plain, np.zeros(1), 0.0
    some = [setup.speed]
    if setup.torsion.speeds is not None:
        some += np.linspace(setup.torsion.speeds.start, setup.torsion.speeds.stop, _READ).tolist()
    speed = np.unique(some)
    found, errors = solver(speed), solver.errors(speed)
    for c, moved, share in solver.moves(found, errors):
        own, other = (
            solver.couplings[c].values(mean, temperature, none, amplitude)
            for mean, temperature, amplitude in (found[..., c], moved[..., c])
        )
        for before, after in zip(own, other, strict=True):
            largest = max(largest, float(np.max(np.abs(after / before - 1.0) * share)))
    return largest


def coupled(setup: Setup) -> Setup:
    """The same with what its couplings depend on; as it is where they depend on nothing."""
    varying = tuple(one for one in setup.shaft.couplings if one.varies)
    if not varying:
        return setup
    plain = setup._replace(model=setup.model._replace(couplings=None))
    critical = cache(lambda: met_criticals(found))
    solver = _Solver(plain, varying)
    spread = cache(lambda: _spread(solver))
    states = CouplingStates(varying, solver, critical, spread, solver.moved)
    model = plain.model._replace(couplings=states)
    undamped = cache(partial(undamped_modes, model, setup.speed))
    natural = natural_of(setup.torsion, model, undamped, setup.speed)
    found = plain._replace(model=model, undamped=undamped, natural=natural)
    return found


# ----------------------------------------------------------------------------
# Temperatures and vibratory torques that stand: those which the vibration under them gives.
#
# From cold, and from no vibration, half of what is missing is added, which follows the way that a
# coupling warms; from there Newton's method with slopes by differences goes on to the last digits.
# ----------------------------------------------------------------------------

#: half steps from cold, and how near to standing they come before Newton's method takes over
_WARMING, _NEAR = 200, 1e-2
#: steps of Newton's method, what counts as standing, and what it may be content with
_STEPS, _STANDS, _ROUGH = 25, 1e-13, 1e-9
#: of a value, the step by which slopes are taken
_STEP = 1e-6
#: rows of conditions, and which rows of a coupling follow them
_MEAN, _TEMPERATURE, _AMPLITUDE = range(3)
_FOLLOW = ("mean_torque", "over_temperature", "amplitude")


class _Solver:
    """Gives the conditions at speeds; each speed is solved once.

    Loads, gas and heat are those of the speeds that the case asks for: beyond them the conditions
    at the nearest end count.
    """

    def __init__(self, plain: Setup, couplings: tuple[Coupling, ...]):
        self.plain, self.couplings = plain, couplings
        unknowns = [
            (kind, place)
            for place, one in enumerate(couplings)
            for kind in (_TEMPERATURE, _AMPLITUDE)
            if getattr(one, _FOLLOW[kind]) is not None
        ]
        #: of what is looked for (q,): kind of condition and place of the coupling
        self.kind, self.place = np.array(unknowns, dtype=int).reshape(-1, 2).T
        self.known: dict[float, FloatArray] = {}
        self.first, self.last = asked_range(plain)

    def __call__(self, speed: FloatArray) -> Conditions:
        speed = np.clip(speed, self.first, self.last)
        new = np.array([one for one in speed.tolist() if one not in self.known])
        for part in blocks(self.plain, len(new)):
            at = new[part]
            rows = np.moveaxis(self._found(at), 1, 0)
            self.known.update(zip(at.tolist(), rows, strict=True))
        every = np.array([self.known[one] for one in speed.tolist()])
        return np.moveaxis(every.reshape(len(speed), 3, len(self.couplings)), 1, 0)

    def mean(self, speed: FloatArray) -> Bounded:
        """Own mean torques (u, c)."""
        element = [one.element for one in self.couplings]
        ratio = np.array([one.ratio for one in self.couplings])
        return mean_torques(self.plain, speed).section[:, element] / ratio

    def _found(self, speed: FloatArray) -> Conditions:
        mean = self.mean(speed).value
        cold = np.broadcast_to([one.temperature for one in self.couplings], mean.shape)
        begin = np.stack([mean, cold, np.zeros_like(mean)])
        return self._standing(speed, begin) if len(self.kind) else begin

    def _standing(self, speed: FloatArray, begin: Conditions) -> Conditions:
        last = np.full(len(self.kind), np.inf)
        for column in np.flatnonzero(self.kind == _TEMPERATURE):
            rows = self.couplings[self.place[column]].over_temperature
            last[column] = rows.at[-1] if rows is not None else np.inf
        x = self._read(begin)
        for _ in range(_WARMING):
            missing = self._answer(speed, begin, x) - x
            if np.all(np.abs(missing) <= _NEAR * self._size(x)):
                break
            self._check_heat(speed, begin, x, missing, last)
            x = np.minimum(x + 0.5 * missing, last)
        else:
            self._fail(speed, x, missing)
        before = np.inf
        for _ in range(_STEPS):
            share = float(np.max(np.abs(missing) / self._size(x)))
            if share <= _STANDS or (share <= _ROUGH and share > 0.25 * before):
                return self._with(begin, x)
            before = share
            slope = self._slope(speed, begin, x, missing + x)
            step = np.linalg.solve(np.eye(x.shape[1]) - slope, missing[..., None])[..., 0]
            x = np.minimum(x + step, last)
            missing = self._answer(speed, begin, x) - x
            self._check_heat(speed, begin, x, missing, last)
        return self._fail(speed, x, missing)

    def _size(self, x: FloatArray) -> FloatArray:
        """What a change of the unknowns counts by; no less than 1 K and 1 N m."""
        return np.maximum(np.abs(x), 1.0)

    def _read(self, conditions: Conditions) -> FloatArray:
        return np.stack(
            [conditions[one, :, at] for one, at in zip(self.kind, self.place, strict=True)], -1
        )

    def _with(self, conditions: Conditions, x: FloatArray) -> Conditions:
        found = conditions.copy()
        found[self.kind, :, self.place] = x.T
        return found

    def frozen(self, conditions: Conditions) -> Setup:
        """The line with its couplings in these conditions, at the speeds they belong to."""
        nowhere = Bounded(np.zeros((0, 0)), np.zeros((0, 0)))
        states = CouplingStates(self.couplings, lambda _: conditions, lambda: nowhere)
        return self.plain._replace(model=self.plain.model._replace(couplings=states))

    def _answer(self, speed: FloatArray, begin: Conditions, x: FloatArray) -> FloatArray:
        """The unknowns (u, q) that the vibration with the unknowns x gives."""
        setup = self.frozen(self._with(begin, x))
        state = solved(setup.model, setup.drive, speed)
        answer = np.empty_like(x)
        for column, (kind, place) in enumerate(zip(self.kind, self.place, strict=True)):
            one = self.couplings[place]
            torque, twist = state.torque[..., one.element], state.twist[..., one.element]
            if kind == _TEMPERATURE:
                work = np.imag(torque * twist.conj())
                power = 0.5 * np.sum(state.frequency * work, axis=-1)
                answer[:, column] = one.temperature + one.resistance * power
            else:
                half = synthesis(setup.drive.cycles, torque).half_range
                answer[:, column] = half / abs(one.ratio)
        return answer

    def _slope(
        self, speed: FloatArray, begin: Conditions, x: FloatArray, answer: FloatArray
    ) -> FloatArray:
        """Slopes (u, q, q) of what is given by what is taken."""
        columns = []
        for column in range(x.shape[1]):
            step = _STEP * self._size(x[:, column])
            moved = x.copy()
            moved[:, column] += step
            columns.append((self._answer(speed, begin, moved) - answer) / step[:, None])
        return np.stack(columns, axis=-1)

    def _check_heat(
        self,
        speed: FloatArray,
        begin: Conditions,
        x: FloatArray,
        missing: FloatArray,
        last: FloatArray,
    ) -> None:
        """Raise NumericalFailure where an element at the end of its rows still warms."""
        runs = (x >= last) & (missing > 0.0)
        if not np.any(runs):
            return
        row, column = (int(one[0]) for one in np.nonzero(runs))
        one, rpm = self.couplings[self.place[column]], speed[row] * 30.0 / np.pi
        gained = (missing[row, column] + last[column] - one.temperature) / one.resistance
        left = (last[column] - one.temperature) / one.resistance
        raise NumericalFailure(
            f"coupling {one.name!r} at {rpm:.6g} rpm: thermal runaway. At the last row of its "
            f"table, {last[column] - 273.15:.4g} degC, its vibration heats it with {gained:.4g} W, "
            f"and {left:.4g} W leave it: it has no steady temperature there. A larger coupling, "
            "rows of higher temperatures, or a range of speeds without this one"
        )

    def _fail(self, speed: FloatArray, x: FloatArray, missing: FloatArray) -> Conditions:
        share = np.abs(missing) / self._size(x)
        row, column = np.unravel_index(int(np.argmax(share)), share.shape)
        one, rpm = self.couplings[self.place[column]], speed[row] * 30.0 / np.pi
        name = "temperature" if self.kind[column] == _TEMPERATURE else "amplitude"
        raise NumericalFailure(
            f"coupling {one.name!r} at {rpm:.6g} rpm: its {name} does not come to stand; "
            f"the last step still misses {share[row, column]:.2g} of it"
        )

    # what errors of the conditions do

    def moves(
        self, found: Conditions, errors: Conditions
    ) -> Iterator[tuple[int, Conditions, FloatArray]]:
        """Of each coupling, by place, each condition that it follows moved, error over move."""
        for kind, rows in enumerate(_FOLLOW):
            for c, one in enumerate(self.couplings):
                if getattr(one, rows) is not None:
                    moved = found.copy()
                    step = _STEP * np.maximum(np.abs(found[kind, :, c]), 1.0)
                    moved[kind, :, c] += step
                    yield c, moved, errors[kind, :, c] / step

    def errors(self, speed: FloatArray) -> Conditions:
        """Errors of the conditions (u, c): of mean torques, and of what is found by iteration."""
        found, mean = self(speed), self.mean(speed)
        errors = np.zeros_like(found)
        errors[_MEAN] = mean.error
        if not len(self.kind):
            return errors
        setup, x = self.frozen(found), self._read(found)
        motion = Motion(setup, speed, bounded=True)
        answer = self._answer(speed, found, x)
        off = np.abs(answer - x) + 4.0 * EPSILON * np.abs(x)
        for column, (kind, place) in enumerate(zip(self.kind, self.place, strict=True)):
            one = self.couplings[place]
            if kind == _TEMPERATURE:
                heat = motion.heat(np.array([one.element]))
                off[:, column] += one.resistance * heat.errors[:, 0]
            else:
                torque = motion.state.torque[..., one.element]
                off[:, column] += sum_error(torque) / abs(one.ratio)
        for _, moved, share in self.moves(found, errors):
            if np.any(share):
                off += np.abs(self._answer(speed, moved, x) - answer) * share[:, None]
        slope = self._slope(speed, found, x, answer)
        amplified = np.abs(np.linalg.inv(np.eye(x.shape[1]) - slope))
        return self._with(errors, (amplified @ off[..., None])[..., 0])

    def moved(self, speed: FloatArray) -> Moved:
        """By what couplings depend on and is not known exactly, at speeds (s,) in any order."""
        at, place = np.unique(speed, return_inverse=True)
        found, errors = self(at), self.errors(at)
        base = _parts(self.frozen(found), at)
        total = [np.zeros(one.shape) for one in base]
        for _, moved, share in self.moves(found, errors):
            other = _parts(self.frozen(moved), at)
            for sum_, one, first in zip(total, other, base, strict=True):
                sum_ += np.abs(one - first) * share.reshape(-1, *([1] * (first.ndim - 1)))
        return Moved(*(one[place.ravel()] for one in total))


def _parts(setup: Setup, speed: FloatArray) -> tuple[FloatArray, ...]:
    state = solved(setup.model, setup.drive, speed)
    work = np.imag(state.torque * state.twist.conj())
    heat = 0.5 * np.sum(state.frequency[..., None] * work, axis=1)
    return state.angle, state.twist, state.torque, heat
