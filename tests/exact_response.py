"""The response of a body on its suspension in many digits, from the case alone.

Written for tests from docs/theory_mounts.md, slow and obvious. Numbers are mpmath's, at the
caller's precision. What the program chooses (the speeds of a curve) is read from the result.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import mpmath
import numpy as np
from exact_body import BodyTruth, about_centre, solve
from exact_motion import Motion, exact_motion
from exact_parts import matrix
from exact_peaks import cycle_peak
from exact_rod import fourier
from exact_train import Shaking, Vector, frame_of, masses_of, shaking_of
from mpmath import mpc, mpf

from vibecalc.core.results.record import Record
from vibecalc.isolation.tables import Isolation
from vibecalc.parts.weight_tables import Counterweight
from vibecalc.schema import Case

#: a path, the entries of the result that are compared, and their exact values
Truth = tuple[str, np.ndarray, Any]
RUN_UP_SPEEDS = 4
EXACT = {"in": mpf("0.0254"), "lbf": mpf("4.4482216152605"), "s": mpf(1)}


def pistons_of(case: Case) -> Motion:
    """Motion of the pistons, in fewer digits than are carried: it is the slowest of all."""
    train, options = case.machine.crank_train, case.kinematics
    terms = options.terms or 1 if options is not None and options.series == "truncated" else None
    lengths = (train.crank_radius, train.rod_length, train.wrist_pin_offset)
    return exact_motion(*map(mpf, lengths), terms, digits=22)


def loads_of(
    case: Case,
    working: Sequence[str] | None,
    balanced_for: Sequence[str] | None,
    *,
    pistons: bool = True,
    throws: bool = True,
    motion: Motion | None = None,
) -> Shaking:
    """Forces and couples per squared speed of a machine of which some cylinders work.

    Without `throws` all but what turns at the crank pins and the weights for it; without `pistons`
    that alone.
    """
    train = case.machine.crank_train
    idle = "stopped" if case.excitation is None else case.excitation.idle
    with_piston, at_pin = masses_of(case)
    runs = [
        int(working is None or idle == "unloaded" or c.name in working) for c in train.cylinders
    ]
    cylinders = [
        c.model_copy(
            update={
                "reciprocating_mass": mpf(on * int(pistons)) * piston,
                "rotating_mass": mpf(on * int(throws)) * pin,
            }
        )
        for c, on, piston, pin in zip(train.cylinders, runs, with_piston, at_pin, strict=True)
    ]
    weights = [
        Counterweight.model_construct(
            name=c.name,
            unbalance=pin * mpf(train.crank_radius),
            phase=mpf(c.crank_phase) + mpmath.pi,
            position=c.position,
        )
        for c, pin in zip(train.cylinders, at_pin, strict=True)
        if throws and c.name in (balanced_for or ())
    ]
    written = {
        "cylinders": tuple(cylinders),
        "counterweights": (*(train.counterweights if pistons else ()), *weights),
        "balance_shafts": train.balance_shafts if pistons else (),
        **dict.fromkeys(("rod", "reciprocating_mass", "piston_mass", "pin_mass")),
        "rotating_mass": mpf(0),
    }
    machine = case.machine.model_copy(update={"crank_train": train.model_copy(update=written)})
    motion = pistons_of(case) if motion is None else motion
    shaking = shaking_of(case.model_copy(update={"machine": machine}), motion)
    if pistons and train.rod is not None and train.rod.inertia is not None:
        return _with_rods(case, shaking, runs)
    return shaking


def _with_rods(case: Case, shaking: Shaking, runs: list[int]) -> Shaking:
    """Couples dJ phi'' of the rods, and dJ phi' phi'' where their torque counts."""
    train, frame = case.machine.crank_train, frame_of(case)
    rod = train.rod
    assert rod is not None and rod.crank_pin_to_mass_centre is not None
    radius, length, offset = map(
        mpf, (train.crank_radius, train.rod_length, train.wrist_pin_offset)
    )
    place = mpf(rod.crank_pin_to_mass_centre)
    difference = mpf(rod.inertia) - mpf(rod.mass) * place * (length - place)
    bears = case.excitation is None or case.excitation.driven_machine != "cancels_torque"

    def signal(angle: mpf) -> mpf:
        sine = (radius * mpmath.sin(angle) - offset) / length
        cosine = mpmath.sqrt(1 - sine**2)
        rate = radius * mpmath.cos(angle) / (length * cosine)
        bend = (-radius * mpmath.sin(angle) / length + sine * rate**2) / cosine
        return bend + (rate * bend if bears else 0)

    reach = (radius + abs(offset)) / length
    decay = -mpmath.log(reach / (1 + mpmath.sqrt(1 - reach**2)))
    samples = 2 * max(shaking.orders) + int(60 / decay)
    couple = list(shaking.couple)
    axis = frame.axis * difference
    for row, (n, turn) in enumerate(
        zip(shaking.orders, fourier(signal, shaking.orders, samples), strict=True)
    ):
        for cylinder, on in zip(train.cylinders, runs, strict=True):
            lead = mpf(cylinder.crank_phase) - mpf(cylinder.bank_angle)
            couple[row] = couple[row] + axis * (on * turn * mpmath.expj(n * lead))
    return shaking._replace(couple=couple)


class SystemTruth(BodyTruth):
    """Matrices of a case, given or assembled, with its modal damping; no load yet."""

    def __init__(self, case: Case) -> None:
        body, mounts = case.machine.body, case.machine.mounts
        assert body is not None and mounts is not None
        if mounts.stiffness_matrix is None:
            isolation = Isolation.model_construct(model="rigid_body", up="z", gravity=0.0)
            nothing = Shaking([], [], [])
            super().__init__(case.model_copy(update={"isolation": isolation}), nothing)
        else:
            self.kept = np.arange(6)
            self.mass = exact_matrix(body.mass_matrix)
            self.stiffness = exact_matrix(mounts.stiffness_matrix)
            self.damping = matrix([[0] * 6 for _ in range(6)])
            if mounts.damping_matrix is not None:
                self.damping = exact_matrix(mounts.damping_matrix)
            self.loss = self.stiffness * mpf(mounts.loss_factor or 0)
        self.frequency, self.shapes = self.modes()
        for frequency, shape in zip(self.frequency, self.shapes, strict=True):
            moved = self.mass @ shape
            ratio = mpf(mounts.modal_damping or 0)
            self.damping = self.damping + np.outer(moved, moved) * (2 * ratio * frequency)

    def motion(self, speed: mpf) -> list[Vector]:
        """Six coordinates of each order. An array times a number is fast, the reverse is not."""
        found = []
        for n, load in zip(self.orders, self.load, strict=True):
            w = n * speed
            lag = (self.loss + self.damping * w) * mpc(0, 1)
            found.append(solve(self.stiffness - self.mass * w**2 + lag, load * speed**2))
        return found

    def driven_by(self, shaking: Shaking) -> "SystemTruth":
        """The same system under a load."""
        self.orders = shaking.orders
        self.load = [np.concatenate(p) for p in zip(shaking.force, shaking.couple, strict=True)]
        return self


def exact_matrix(entry: Any) -> np.ndarray:
    """A matrix of a case in SI: entries as stored, the factors of the units exact."""
    factors = [_factor(unit) for unit in entry.units or ("", "", "")]
    return matrix(
        [
            [mpf(value) * factors[(i >= 3) + (j >= 3)] for j, value in enumerate(row)]
            for i, row in enumerate(entry.values)
        ]
    )


def _factor(unit: str) -> mpf:
    if "lbf" not in unit:
        return mpf(1)
    inches = {"/in": -1, "*in": 1}
    power = next((p for words, p in inches.items() if words in unit), 0)
    return EXACT["lbf"] * EXACT["in"] ** power


def root_of(weight: np.ndarray) -> np.ndarray:
    """F with F^T F = weight."""
    lower = mpmath.cholesky(mpmath.matrix(weight.tolist()))
    return np.array(lower.T.tolist(), dtype=object).reshape(6, 6)


def order_mean(weight: np.ndarray, state: Vector) -> mpf:
    """Mean energy of one order."""
    return mpmath.re(np.array([mpmath.conj(q) for q in state]) @ (weight @ state)) / 4


def order_peak(weight: np.ndarray, state: Vector) -> mpf:
    """Highest energy of one order."""
    return order_mean(weight, state) + abs(state @ (weight @ state)) / 4


def whole_peak(weight: np.ndarray, states: list[Vector], orders: Sequence[int]) -> mpf:
    """Highest energy of all orders together: half the square of the greatest length."""
    root = root_of(weight)
    rows = np.array([root @ state for state in states], dtype=object).T.tolist()
    return cycle_peak(rows, list(orders))[0] ** 2 / 2


def response_results(case: Case, record: Record) -> Iterator[Truth]:
    """Every result of the motion, its operations and its run-up next to its exact value."""
    options, system = case.response, SystemTruth(case)
    assert options is not None
    working = None if case.excitation is None else case.excitation.working
    balanced = None if case.excitation is None else case.excitation.balanced_for
    pistons = pistons_of(case)
    system.driven_by(loads_of(case, working, balanced, motion=pistons))
    yield from _modes(case, record, system)
    speed = mpf(case.machine.speed)
    motion = system.motion(speed)
    yield from _motion(record, system, speed, motion)
    for name, weight, states in _kinds(system, speed, motion, system.orders):
        stem = f"response/{name}_energy"
        kept = record[f"{stem}/mean_by_order"].axes[0].values.tolist()
        means = [order_mean(weight, state) for state in states]
        peaks = [order_peak(weight, state) for state in states]
        yield _reported(record, f"{stem}/mean_by_order", _kept(kept, means))
        yield _reported(record, f"{stem}/peak_by_order", _kept(kept, peaks))
        yield _reported(record, f"{stem}/mean", mpmath.fsum(means))
        yield _reported(record, f"{stem}/peak", whole_peak(weight, states, system.orders))
    if options.run_up is not None:
        yield from _run_up(record, system)
    if options.operations:
        yield from _operations(case, record, system, pistons)


def _reported(record: Record, path: str, exact: Any) -> Truth:
    return path, record[path].values, exact


def _kept(kept: list[int], values: list[Any], absent: Any = 0) -> list[Any]:
    return [values[n - 1] if n <= len(values) else absent for n in kept]


def _kinds(
    system: SystemTruth, speed: mpf, motion: list[Vector], orders: Sequence[int]
) -> Iterator[tuple[str, np.ndarray, list[Vector]]]:
    rates = [x * mpc(0, n) * speed for n, x in zip(orders, motion, strict=True)]
    yield "kinetic", system.mass, rates
    yield "potential", system.stiffness, motion


def _modes(case: Case, record: Record, system: SystemTruth) -> Iterator[Truth]:
    stem, frequency, shapes = "response/modes", system.frequency, system.shapes
    yield _reported(record, f"{stem}/natural_frequency", frequency)
    yield _reported(record, f"{stem}/shape", [v.tolist() for v in shapes])
    share = [about_centre(system.mass, v) for v in shapes]
    yield _reported(record, f"{stem}/energy_fraction", share)
    ratio = [
        v @ (system.damping @ v) / (2 * w) + v @ (system.loss @ v) / (2 * w**2)
        for v, w in zip(shapes, frequency, strict=True)
    ]
    yield _reported(record, f"{stem}/damping_ratio", ratio)
    weights = np.array([system.mass[i, i] for i in range(6)], dtype=object)
    alike = [
        [(u @ (weights * v)) ** 2 / ((u @ (weights * u)) * (v @ (weights * v))) for v in shapes]
        for u in shapes
    ]
    yield _reported(record, f"{stem}/assurance", alike)
    orders = record[f"{stem}/nearest_order"].values.tolist()
    speed = mpf(case.machine.speed)
    away = [n * speed / w - 1 for n, w in zip(orders, frequency, strict=True)]
    yield _reported(record, f"{stem}/distance", away)


def _motion(
    record: Record, system: SystemTruth, speed: mpf, motion: list[Vector]
) -> Iterator[Truth]:
    held = [
        (system.stiffness + (system.loss + system.damping * (n * speed)) * mpc(0, 1)) @ x
        for n, x in zip(system.orders, motion, strict=True)
    ]
    for names, suffix, rows in (
        (("translation", "rotation"), "_harmonics", motion),
        (("ground_force", "ground_couple"), "", held),
    ):
        for name, start in zip(names, (0, 3), strict=True):
            path = f"response/{name}{suffix}"
            kept = record[path].axes[0].values.tolist()
            part = [row[start : start + 3].tolist() for row in rows]
            yield _reported(record, path, _kept(kept, part, [mpf(0)] * 3))
            peaks = [cycle_peak([[r[i] for r in part]], system.orders)[0] for i in range(3)]
            yield _reported(record, f"response/{name}_peak", peaks)


def _run_up(record: Record, system: SystemTruth) -> Iterator[Truth]:
    speeds = record["response/run_up/kinetic_energy"].axes[0].values
    chosen = _telling(record, system, speeds)
    exact: dict[str, list[mpf]] = {"kinetic": [], "potential": []}
    for index in chosen.tolist():
        speed = mpf(float(speeds[index]))
        for name, weight, states in _kinds(system, speed, system.motion(speed), system.orders):
            exact[name].append(mpmath.fsum(order_mean(weight, state) for state in states))
    for name, values in exact.items():
        path = f"response/run_up/{name}_energy"
        yield path, record[path].values[chosen], values
    pairs = zip(
        record["response/resonances_skipped/mode"].values.tolist(),
        record["response/resonances_skipped/order"].values.tolist(),
        strict=True,
    )
    centres = [system.frequency[int(mode) - 1] / int(order) for mode, order in pairs]
    if centres:
        yield _reported(record, "response/resonances_skipped/centre", centres)


def _telling(record: Record, system: SystemTruth, speeds: np.ndarray) -> np.ndarray:
    """A few speeds: where doubles, with all orders, are furthest from the result, and others."""
    mass, stiffness, damping, loss = (
        part.astype(float) for part in (system.mass, system.stiffness, system.damping, system.loss)
    )
    load, orders = np.array(system.load).astype(complex), np.array(system.orders)
    off = []
    for speed in speeds.tolist():
        rate = (orders * speed)[:, None, None]
        dynamic = stiffness + 1j * (loss + rate * damping) - rate**2 * mass
        moved = rate[:, 0] * np.linalg.solve(dynamic, speed**2 * load[..., None])[..., 0]
        off.append(np.sum((moved.conj() * (moved @ mass)).real) / 4.0)
    found = record["response/run_up/kinetic_energy"].values
    furthest = np.argsort(-np.abs(np.array(off) - found))[:RUN_UP_SPEEDS]
    spread = np.random.default_rng(len(speeds)).permutation(len(speeds))[:2]
    chosen: np.ndarray = np.unique([*furthest, *spread, int(np.argmax(found)), 0])
    return chosen


def _operations(case: Case, record: Record, system: SystemTruth, motion: Motion) -> Iterator[Truth]:
    options, speed = case.response, mpf(case.machine.speed)
    assert options is not None
    own = None if case.excitation is None else case.excitation.balanced_for
    balances = [balance.balanced_for for balance in options.balances] or [own]
    found: dict[str, list[list[mpf]]] = {}
    for operation in options.operations:
        rows: dict[str, list[mpf]] = {}
        pistons = loads_of(case, operation.working, None, throws=False, motion=motion)
        shaken = system.driven_by(pistons).motion(speed)
        for names in balances:
            turning = loads_of(case, operation.working, names, pistons=False, motion=motion)
            extra = system.driven_by(turning).motion(speed)
            for key, value in _cell(system, speed, shaken, extra, pistons.orders):
                rows.setdefault(key, []).append(value)
        for key, values in rows.items():
            found.setdefault(key, []).append(values)
    weights = [mpf(operation.weight) for operation in options.operations]
    for kind in ("kinetic", "potential"):
        means = list(zip(*found[f"{kind}_energy/mean"], strict=True))
        stem = f"response/operations/{kind}_energy"
        yield _reported(
            record, f"{stem}/difference", [max(column) - min(column) for column in means]
        )
        shares = [mpmath.fdot(weights, column) / mpmath.fsum(weights) for column in means]
        yield _reported(record, f"{stem}/weighted", shares)
    for key, values in found.items():
        yield _reported(record, f"response/operations/{key}", values)


def _cell(
    system: SystemTruth, speed: mpf, shaken: list[Vector], extra: list[Vector], orders: list[int]
) -> Iterator[tuple[str, mpf]]:
    """Energies of one operation with one balance; all but the range of the peak."""
    total = [a + b for a, b in zip(shaken, extra, strict=True)]
    parts = zip(
        _kinds(system, speed, total, orders),
        _kinds(system, speed, shaken[:1], orders[:1]),
        _kinds(system, speed, extra[:1], orders[:1]),
        strict=True,
    )
    for (name, weight, states), (_, _, (one,)), (_, _, (other,)) in parts:
        stem = f"{name}_energy"
        means = [order_mean(weight, state) for state in states]
        yield f"{stem}/mean", mpmath.fsum(means)
        yield f"{stem}/peak", whole_peak(weight, states, orders)
        cross = np.array([mpmath.conj(q) for q in one]) @ (weight @ other) / 2
        still = order_mean(weight, one) + order_mean(weight, other) + mpmath.fsum(means[1:])
        yield f"{stem}/mean_low", still - abs(cross)
        yield f"{stem}/mean_high", still + abs(cross)
        yield f"{stem}/rotating_mean", order_mean(weight, other)
        yield f"{stem}/rotating_peak", order_peak(weight, other)
