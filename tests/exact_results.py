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
from exact_train import Shaking, motion_of, shaking_of
from mpmath import mpf

from vibecalc.case.schema import Case
from vibecalc.results.record import Record


def exact_results(case: Case, record: Record) -> Iterator[Truth]:
    """All quantities of a record beside their exact values; none is left out."""
    motion = motion_of(case)
    shaking = shaking_of(case, motion)
    yield from _kinematics(case, record, motion)
    yield from _excitation(case, record, shaking)
    if case.excitation is not None and case.excitation.balance is not None:
        yield from _balance(case, record)
    if case.isolation is None:
        return
    driven = _driven(shaking)
    if case.isolation.model == "pitch":
        yield from pitch_results(case, record, PitchTruth(case, driven))
    else:
        yield from body_results(case, record, BodyTruth(case, driven))


def _driven(shaking: Shaking) -> Shaking:
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
    options = case.excitation.residual if case.excitation is not None else None
    if options is not None:
        wf, wc = mpf(options.force_weight), mpf(options.couple_weight)
        wc = wc / mpf(options.reference_length)
        total = mpmath.fsum(abs(wf * x) ** 2 for f in shaking.force for x in f)
        total += mpmath.fsum(abs(wc * x) ** 2 for m in shaking.couple for x in m)
        path = "excitation/residual"
        yield path, record[path].values, square * mpmath.sqrt(total)


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
            yield path, record[path].values, [mpmath.fsum(row) for row in exact]
