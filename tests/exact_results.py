"""Every result path of a run, in many digits, from the case alone.

For what depends on a choice of the program (the angles, frequencies and speeds at which a curve is
sampled) the samples are read from the result and taken as exact. Of a run-up curve a few speeds
are computed. Written for tests, slow and obvious.
"""

from collections.abc import Iterator

import mpmath
from exact_body import BodyTruth
from exact_isolation import Truth, body_results, pitch_results
from exact_motion import Motion
from exact_peaks import cycle_peak
from exact_pitch import PitchTruth
from exact_train import Shaking, frame_of, masses_of, motion_of, shaking_of
from mpmath import mpf

from vibecalc.core.results.record import Record
from vibecalc.schema import Case


def exact_results(case: Case, record: Record) -> Iterator[Truth]:
    """All quantities of a record next to their exact values; none is left out."""
    motion = motion_of(case)
    shaking = shaking_of(case, motion)
    yield from _kinematics(case, record, motion)
    yield from _excitation(case, record, shaking)
    if case.excitation is not None and case.excitation.balance is not None:
        yield from _balance(case, record)
    if case.isolation is None:
        return
    driven = driven_orders(shaking)
    if case.isolation.model == "pitch":
        yield from pitch_results(case, record, PitchTruth(case, driven))
    else:
        yield from body_results(case, record, BodyTruth(case, driven))


def driven_orders(shaking: Shaking) -> Shaking:
    """Orders whose force or couple is above 1e-20 of the largest."""
    forces = [max(map(abs, f)) for f in shaking.force]
    couples = [max(map(abs, m)) for m in shaking.couple]
    keep = [
        i
        for i in range(len(shaking.orders))
        if forces[i] > max(forces) * mpf(10) ** -20 or couples[i] > max(couples) * mpf(10) ** -20
    ]
    return Shaking(
        [shaking.orders[i] for i in keep],
        [shaking.force[i] for i in keep],
        [shaking.couple[i] for i in keep],
    )


def _kinematics(case: Case, record: Record, motion: Motion) -> Iterator[Truth]:
    speed = mpf(case.machine.speed)
    path = "kinematics/position_harmonics"
    orders = record[path].axes[0].values.tolist()
    harmonics = [motion.position[n] if n < len(motion.position) else mpf(0) for n in orders]
    yield path, record[path].values, harmonics
    path = "kinematics/acceleration_harmonics"
    rates = [-((n * speed) ** 2) * c for n, c in zip(orders, harmonics, strict=True)]
    yield path, record[path].values, rates
    path = "kinematics/dropped_acceleration"
    yield path, record[path].values, _dropped(case, motion, max(orders))
    if "kinematics/position" not in record:
        return
    curves = [motion.at(mpf(a)) for a in record["kinematics/position"].axes[0].values.tolist()]
    for power, name in enumerate(("position", "velocity", "acceleration")):
        path = f"kinematics/{name}"
        yield path, record[path].values, [speed**power * point[power] for point in curves]


def _dropped(case: Case, motion: Motion, kept: int) -> mpf:
    """Sum of n^2 times what the kept harmonics lack of the exact ones; C_n summed until it ends."""
    speed = mpf(case.machine.speed)
    total = sum(n**2 * abs(c) for n, c in enumerate(motion.position) if n > kept)
    if case.kinematics is not None and case.kinematics.series == "truncated":
        exact = motion_of(case.model_copy(update={"kinematics": None}))
        total = mpf(0)
        for n, c in enumerate(exact.position):
            have = motion.position[n] if n <= kept and n < len(motion.position) else 0
            total += n**2 * abs(c - have)
    return speed**2 * total


def _excitation(case: Case, record: Record, shaking: Shaking) -> Iterator[Truth]:
    square = mpf(case.machine.speed) ** 2
    for name, parts in (("force", shaking.force), ("couple", shaking.couple)):
        found = record[f"excitation/{name}"]
        none = [mpf(0)] * 3
        orders = found.axes[0].values.tolist()
        exact = [(square * parts[n - 1]).tolist() if n <= len(parts) else none for n in orders]
        yield f"excitation/{name}", found.values, exact
        peaks = [cycle_peak([[square * p[i] for p in parts]], shaking.orders)[0] for i in range(3)]
        yield f"excitation/{name}_peak", record[f"excitation/{name}_peak"].values, peaks
    yield from _moving_parts(case, record)
    options = case.excitation.residual if case.excitation is not None else None
    if options is not None:
        wf, wc = mpf(options.force_weight), mpf(options.couple_weight)
        wc = wc / mpf(options.reference_length)
        total = mpmath.fsum(abs(wf * x) ** 2 for f in shaking.force for x in f)
        total += mpmath.fsum(abs(wc * x) ** 2 for m in shaking.couple for x in m)
        path = "excitation/residual"
        yield path, record[path].values, square * mpmath.sqrt(total)


def _moving_parts(case: Case, record: Record) -> Iterator[Truth]:
    """Masses of cylinders, force and couple of counterweights, what a rod's points leave."""
    train, speed = case.machine.crank_train, mpf(case.machine.speed)
    rod = train.rod
    moved, turned = masses_of(case)
    yield "excitation/mass/reciprocating", record["excitation/mass/reciprocating"].values, moved
    yield "excitation/mass/rotating", record["excitation/mass/rotating"].values, turned
    if train.counterweights:
        forces = [mpf(weight.unbalance) * speed**2 for weight in train.counterweights]
        along = mpf(train.origin["xyz".index(train.axis)])
        levers = [abs(along + mpf(weight.position)) for weight in train.counterweights]
        path = "excitation/counterweight/"
        yield path + "force", record[path + "force"].values, forces
        couples = [force * lever for force, lever in zip(forces, levers, strict=True)]
        yield path + "couple", record[path + "couple"].values, couples
    if rod is not None and rod.crank_pin_to_mass_centre is not None:
        first, length = mpf(rod.crank_pin_to_mass_centre), mpf(train.rod_length)
        points = mpf(rod.mass) * first * (length - first)
        yield "excitation/rod/split_inertia", record["excitation/rod/split_inertia"].values, points
        if rod.inertia is None:
            ratio = mpf(train.crank_radius) / length
            reach = ratio + abs(mpf(train.wrist_pin_offset)) / length
            largest = ratio / mpmath.sqrt(1 - reach**2)
            path = "excitation/rod/couple_bound"
            yield path, record[path].values, points * largest * speed**2


def _balance(case: Case, record: Record) -> Iterator[Truth]:
    cylinders = case.machine.crank_train.cylinders
    orders = record["excitation/balance/sine"].axes[0].values.tolist()
    for place in ("", "position_"):
        for name, function in (("sine", mpmath.sin), ("cosine", mpmath.cos)):
            exact = [
                [
                    (mpf(c.position) if place else 1)
                    * function(n * (mpf(c.crank_phase) - mpf(c.bank_angle)))
                    for c in cylinders
                ]
                for n in orders
            ]
            path = f"excitation/balance/{place}{name}"
            yield path, record[path].values, exact
            path = f"excitation/balance/total_{place}{name}"
            if path in record:
                yield path, record[path].values, [mpmath.fsum(row) for row in exact]
    yield from _banks(case, record, orders)


def _banks(case: Case, record: Record, orders: list[int]) -> Iterator[Truth]:
    if "excitation/balance/banks/sum" not in record:
        return
    frame, cylinders = frame_of(case), case.machine.crank_train.cylinders
    for place in ("", "position_"):
        sums, ahead, back = [], [], []
        for n in orders:
            weight = [mpf(c.position) if place else mpf(1) for c in cylinders]
            bank = [mpf(c.bank_angle) for c in cylinders]
            turn = [n * (mpf(c.crank_phase) - b) for c, b in zip(cylinders, bank, strict=True)]
            rows = list(zip(weight, turn, bank, strict=True))
            lines = [mpmath.cos(b) * frame.stroke - mpmath.sin(b) * frame.across for b in bank]
            each = [w * mpmath.expj(t) * u for (w, t, _), u in zip(rows, lines, strict=True)]
            sums.append([mpmath.fsum(one[k] for one in each) for k in range(3)])
            ahead.append(abs(mpmath.fsum(w * mpmath.expj(t + b) for w, t, b in rows)) / 2)
            back.append(abs(mpmath.fsum(w * mpmath.expj(t - b) for w, t, b in rows)) / 2)
        root = f"excitation/balance/banks/{place}"
        for name, truth in (("sum", sums), ("rotating", ahead), ("counter_rotating", back)):
            yield root + name, record[root + name].values, truth
