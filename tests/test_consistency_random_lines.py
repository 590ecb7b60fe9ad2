"""Claim: what random shaft lines do is what their equations of motion say, with everything at once.

Gears rigid and elastic, branches, loops, equal branches, dampers, couplings over torque and
frequency, propellers, misfires and dampings that follow the speed, against the full matrices of
`dense_line.py`. In time: load steps, misfires, short circuits, torques over time, changes of speed
of small lines, against these matrices and DOP853 of scipy from the steady vibration before.
"""

import copy
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest
from dense_line import Cylinder, DenseLine, cylinder_of, ends, half_range
from long_but import long_but
from random_lines import random_change, random_line
from scipy.integrate import solve_ivp

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

ROOT = "response/torsion/"
#: of the size of a result
TOLERANCE = 1e-8
#: of them those that have all kinds of parts, dampings and loads together; the rest are long
USUAL = (0, 2, 4, 5)


class Results:
    """Arrays of a run, without its prefix."""

    def __init__(self, case):
        checked = validate(copy.deepcopy(case))
        assert not check_machine(checked)
        self.record = run_case(checked)

    def __contains__(self, path):
        return ROOT + path in self.record

    def __getitem__(self, path):
        return np.asarray(self.record[ROOT + path].values)

    def labels(self, path):
        return [str(one) for one in self.record[ROOT + path].axes[0].values]


def pairs(found: Results, case) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Path, what the program has, what the equations say."""
    given = cylinder_of(found.record, case)
    line, order = DenseLine(case, lambda speed: given), given.order
    silent = dict.fromkeys(case["response"]["torsion"].get("misfire", ()), 0.0)
    speed, stations = case["machine"]["speed"], len(line.names)
    now = line.at(speed, silent)
    sections, held = line.heat(now, speed)
    rings = slice(len(line.sections) - len(line.dampers), None)
    yield "angle", found["angle"], now.angle[:stations]
    yield "torque", found["torque"], now.torque
    yield "torque_mean", found["torque_mean"], now.torque_mean
    yield "torque_half_range", found["torque_half_range"], half_range(order, now.torque)
    yield "angle_half_range", found["angle_half_range"], half_range(order, now.angle[:stations])
    yield "section_heat", found["section_heat"], sections
    yield "station_heat", found["station_heat"], held
    if line.dampers:
        travel = np.max(np.abs(ends(order, (line.network @ now.angle)[rings])), axis=0)
        # a point mass of order n hangs on R / n^2, and swings by 1 + n^2 of the twist
        for place, one in enumerate(case["machine"]["shaft_line"]["dampers"]):
            travel[place] *= 1.0 + one["order"] ** 2 if one["kind"] == "pendulum" else 1.0
        yield "damper/heat", found["damper/heat"], sections[rings]
        yield "damper/travel", found["damper/travel"], travel
    if line.gears:
        low, high = (now.gear_mean + one for one in ends(order, now.gear))
        yield "gear/mean_torque", found["gear/mean_torque"], now.gear_mean
        yield "gear/alternating_torque", found["gear/alternating_torque"], 0.5 * (high - low)
        path = "gear/minimum_torque"
        yield path, *least_of_gears(found[path], order, now)
    if "modes/undamped_frequency" in found and not _varies(case):
        undamped = found["modes/undamped_frequency"]
        yield "modes/undamped_frequency", undamped**2, line.undamped(speed) ** 2
    asked = case["response"]["torsion"]["speeds"]
    every = [line.at(at, silent) for at in np.linspace(asked["from"], asked["to"], 7)]
    seen = np.array([half_range(order, one.torque) for one in every]).T
    yield "speeds/torque_half_range", found["speeds/torque_half_range"], seen
    if line.gears:
        seen = np.array([half_range(order, one.gear) for one in every]).T
        yield "speeds/gear_torque", found["speeds/gear_torque"], seen
    if "conditions/torque_half_range" in found:
        out = [{}, *({one["name"]: 0.0} for one in line.train["cylinders"])]
        each = [line.at(speed, one) for one in out]
        worst = np.array([half_range(order, one.torque) for one in each])
        yield "conditions/torque_half_range", found["conditions/torque_half_range"], worst
        if line.gears:
            path = "conditions/gear_minimum_torque"
            rows = zip(found[path], each, strict=True)
            yield path, *np.moveaxis([least_of_gears(has, order, now) for has, now in rows], 1, 0)


def least_of_gears(has, order, now) -> tuple[np.ndarray, np.ndarray]:
    """Least torques (gears,) that the program has, and by the equations, of gears with a mean."""
    low, high = (now.gear_mean + one for one in ends(order, now.gear))
    least = np.where(now.gear_mean < 0.0, -high, low)
    carries = np.abs(now.gear_mean) > 1e-9 * np.abs(now.gear_mean).max(initial=0.0)
    return np.where(carries, has, 0.0), np.where(carries, least, 0.0)


def _varies(case) -> bool:
    """Whether a coupling has another stiffness at each frequency or torque."""
    return any(
        {"over_frequency", "over_mean_torque"} & set(one.get("coupling", ()))
        for one in case["machine"]["shaft_line"]["shafts"]
    )


@pytest.mark.parametrize("seed", long_but(range(200), *USUAL))
def test_random_lines_do_what_their_equations_of_motion_say(seed: int) -> None:
    case = random_line(seed)
    off = []
    for path, has, says in pairs(Results(case), case):
        assert has.shape == says.shape, path
        size = np.max(np.abs(says), initial=0.0)
        worst = np.max(np.abs(has - says), initial=0.0)
        if not worst <= TOLERANCE * size:
            off.append(f"{path}: off by {worst:.3g} of {size:.6g}")
    assert off == []


# ----------------------------------------------------------------------------
# In time.
# ----------------------------------------------------------------------------

TIME = f"{ROOT}transient/"
WANTED = frozenset([
    *(f"{ROOT}excitation/{one}" for one in ("gas", "inertia", "mean_indicated_pressure")),
    *(f"{TIME}{one}" for one in ("history/torque", "peak", "peak_time")),
])  # fmt: skip
#: of the largest torque of any section
IN_TIME = 2e-6
#: share of a change of speed in which the acceleration grows, and in which it fades
SWING = 0.1
PASSES = ("run_up", "run_down")
#: stiff lines over several cycles, which the other integrator takes long for
LONG = {3, 18, 22, 23, 29}


class Change:
    """Own angles of stations and rings about the prescribed motion of the crank.

    What the mean torques leave over the inertias take together, of a change of speed the station
    that balances the line.
    """

    def __init__(self, case, given: Cylinder):
        self.case, self.line = case, DenseLine(case, lambda speed: given)
        self.asked = case["response"]["torsion"]["transient"]
        line, kind = self.line, self.asked["kind"]
        self.passes, self.order = kind in PASSES, given.order
        self.begin = self.asked["from"] if self.passes else case["machine"]["speed"]
        self.end = self.asked["to"] if self.passes else self.begin
        #: speed whose dampings hold throughout
        self.held = 0.5 * (self.begin + self.end)
        springs, dashpots = line.section_laws(self.held, np.zeros(1), np.zeros(len(line.rows)))
        self.springs, self.dashpots = springs[:, 0].real, dashpots
        self.basis, network = line.basis, line.network
        stiffness = np.diag(line.ground) + network.T @ (self.springs[:, None] * network)
        damping = np.diag(line.absolute(self.held)) + network.T @ (dashpots[:, None] * network)
        self.mass, self.damping, self.stiffness = (
            self.basis.T @ one @ self.basis for one in (np.diag(line.inertia), damping, stiffness)
        )
        # torques are those of three speeds, as they go with its powers up to the second
        speeds = self.begin * np.array([0.5, 1.0, 1.5])
        powers = np.linalg.inv(np.vander(speeds, 3, increasing=True))
        self.loads = []
        for silent in ("", self.asked.get("cylinder", "")):
            parts = zip(*(self._loads(one, silent) for one in speeds), strict=True)
            self.loads.append([np.tensordot(powers, np.array(one), 1) for one in parts])

    def _loads(self, speed: float, silent: str):
        """Torques by order (stations + rings, m), and means of what drives and is driven.

        The station that balances the line goes on as before when a cylinder falls silent.
        """
        line, less = self.line, np.zeros(self.line.count)
        _, load, _ = line.loads(speed, {silent: 0.0} if silent else {})
        for place, station in enumerate(line.line["stations"]):
            if silent and station.get("cylinder") == silent:
                less[place] -= line.fires(silent)[0] * line.cylinder(speed).mean
        return load, line.loads(speed, {})[2] + self.balanced(less)

    def balanced(self, torque):
        """Torques less what slows the line as a whole."""
        line = self.line
        moving = line.ratio @ (line.inertia * line.ratio)
        return torque - line.inertia * line.ratio * (line.ratio @ torque) / moving

    @property
    def borders(self) -> list[float]:
        """Times at which something jumps or has a corner."""
        first, asked = self.asked["time_before"], self.asked
        if self.passes:
            length = asked["duration"]
            inner = [first + share * length for share in (0.0, SWING, 1.0 - SWING, 1.0)]
            return [0.0, *inner, inner[-1] + asked["time_after"]]
        rows = asked["history"]["time"][1:] if "history" in asked else []
        return [0.0, first, *(first + one for one in rows), first + asked["time_after"]]

    def motion(self, time: float) -> tuple[float, float]:
        """Speed and acceleration of the crank."""
        if not self.passes:
            return self.begin, 0.0
        length = self.asked["duration"]
        share = min(max((time - self.asked["time_before"]) / length, 0.0), 1.0)
        top = (self.end - self.begin) / (length * (1.0 - SWING))
        growth = min(share / SWING, (1.0 - share) / SWING, 1.0)
        passed = min(share, SWING) ** 2 / (2.0 * SWING)
        passed += min(max(share - SWING, 0.0), 1.0 - 2.0 * SWING)
        fading = max(share - (1.0 - SWING), 0.0)
        passed += fading - fading**2 / (2.0 * SWING)
        return self.begin + top * length * passed, top * growth

    def jolt(self, since: float):
        """Torque of the change on its station, in the sense of the angles of this."""
        line, asked, found = self.line, self.asked, np.zeros(self.line.count)
        place = line.names.index(asked["on"])
        if asked["kind"] == "load_step":
            found[place] = -line.sense[place] * asked["torque"]
            return self.balanced(found)
        if "history" in asked:
            size = np.interp(since, asked["history"]["time"], asked["history"]["torque"])
        else:
            size = sum(
                one["amplitude"] * np.exp(-since / one["time_constant"])
                * np.sin(one.get("frequency", 0.0) * since + one["phase"])
                for one in asked["terms"]
            )  # fmt: skip
        found[place] = -line.sense[place] * size
        return found

    def push(self, after: bool) -> Callable[[float, float], np.ndarray]:
        """Accelerations of the coordinates by what acts at a time and an angle of the crank."""
        line, first, jolts = self.line, self.asked["time_before"], after and "on" in self.asked
        to_rates = np.linalg.solve(self.mass, self.basis.T)
        by_order, means = self.loads[after]
        by_order, means = to_rates @ by_order, means @ to_rates.T
        driven = line.names.index(line.line.get("balanced_by", line.names[-1]))
        pull = -line.inertia * line.ratio
        pull[driven] -= line.ratio @ pull / line.ratio[driven]
        still = to_rates @ pull

        def at(time: float, angle: float) -> np.ndarray:
            speed, acceleration = self.motion(time)
            wave = np.exp(1j * self.order * angle)
            found = means[0] + speed * (means[1] + speed * means[2]) + acceleration * still
            for power, one in enumerate(by_order):
                found = found + speed**power * (one @ wave).real
            return found + to_rates @ self.jolt(time - first) if jolts else found

        return at

    def steady(self) -> np.ndarray:
        """State at the begin: coordinates, their rates, the angle of the crank."""
        by_order, means = self.loads[0]
        powers = self.begin ** np.arange(3)
        load, mean = np.tensordot(powers, by_order, 1), powers @ means
        place = np.linalg.pinv(self.stiffness, rcond=1e-13) @ (self.basis.T @ mean)
        rate = np.zeros_like(place)
        for one, row in zip(self.order * self.begin, load.T, strict=True):
            dynamic = self.stiffness + 1j * one * self.damping - one**2 * self.mass
            angle = np.linalg.solve(dynamic, self.basis.T @ row)
            place, rate = place + angle.real, rate + (1j * one * angle).real
        return np.concatenate([place, rate, [0.0]])

    def marched(self) -> Iterator[tuple[float, float, Callable[[np.ndarray], np.ndarray]]]:
        """From border to border what gives the torques of sections (sections, k) at times (k,)."""
        count, state = len(self.mass), self.steady()
        held = -np.linalg.solve(self.mass, np.hstack([self.stiffness, self.damping]))
        network = self.line.network @ self.basis
        for number, (first, last) in enumerate(pairwise(self.borders)):
            push = self.push(after=number > 0)

            def rates(time: float, x: np.ndarray, push: Callable = push) -> np.ndarray:
                bend = push(time, x[-1]) + held @ x[:-1]
                return np.concatenate([x[count:-1], bend, [self.motion(time)[0]]])

            found = solve_ivp(
                rates, (first, last), state, "DOP853", rtol=1e-8, atol=1e-12, dense_output=True
            )
            assert found.success
            state = found.y[:, -1]

            def sections(times: np.ndarray, of: Callable = found.sol) -> np.ndarray:
                x = of(times)
                springs = self.springs[:, None] * (network @ x[:count])
                return springs + self.dashpots[:, None] * (network @ x[count:-1])

            yield first, last, sections


@pytest.mark.parametrize("seed", long_but(range(30), *set(range(30)) - LONG))
def test_random_lines_move_as_another_integrator_says(seed: int) -> None:
    case = random_change(seed)
    checked = validate(copy.deepcopy(case))
    assert not check_machine(checked)
    record = run_case(checked, wanted=WANTED)
    has = {name: record[TIME + name] for name in ("history/torque", "peak", "peak_time")}
    change = Change(case, cylinder_of(record, case))
    peak, at = (np.asarray(has[name].values) for name in ("peak", "peak_time"))
    at = np.minimum(at, change.borders[-1])  # the end is right to a rounding
    history = has["history/torque"]
    time, size = np.asarray(history.axes[-1].values), peak.max()
    worst = int(np.argmax(peak))
    met = np.zeros(len(peak))
    for first, last, sections in change.marched():
        seen = sections(np.linspace(first, last, 400))
        assert np.all(np.abs(seen).max(axis=1) <= peak + IN_TIME * size)
        # there may be none, which scipy refuses
        inside, here = (np.flatnonzero((one >= first) & (one <= last)) for one in (time, at))
        along = sections(np.append(time[inside], last))[worst, :-1]
        off = np.abs(along - np.asarray(history.values)[inside])
        assert np.max(off, initial=0.0) <= IN_TIME * size
        met[here] = np.abs(sections(np.append(at[here], last))[here, range(len(here))])
    assert np.abs(met - peak).max() <= IN_TIME * size
