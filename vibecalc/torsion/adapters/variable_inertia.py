"""A shaft line whose inertias change over the revolution, next to mean inertias."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, stack, where
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters.motion import TORQUE, Motion, readings_of
from vibecalc.torsion.adapters.setup import Setup, build_setup, placed
from vibecalc.torsion.forced import twist_and_torque
from vibecalc.torsion.line import complex_stiffness
from vibecalc.torsion.study_results import VARIABLE
from vibecalc.torsion.tables import LineSpeeds
from vibecalc.torsion.variable_inertia.motion import (
    SteadyTwist,
    VariableLine,
    feed,
    inertia_at,
    inertia_variation,
    steady_response,
    turning_parts,
    variable_line,
)
from vibecalc.torsion.variable_inertia.stability import (
    Wedges,
    refuse_unstable,
    stability,
    unstable_ranges,
    wedges,
)

# ----------------------------------------------------------------------------
# Adapter: a shaft line whose inertias change over the revolution, next to mean inertias.
# ----------------------------------------------------------------------------

#: harmonics of the inertia below this share of it are left out
_NEGLIGIBLE = 1e-13
#: highest orders that are tried where the case leaves it to the tolerance, over the first one
_TRIES = (1.0, 1.5, 2.25)
_ANGLES = 720
#: twist of all orders beyond the highest, over the largest angle at one of them
_BEYOND = 2.0


def run_torsion_variable_inertia(scene: Scene) -> None:
    """Emit everything for [response.torsion.variable_inertia].

    Raises NumericalFailure where vibration about the motion at the operating speed grows.
    """
    setup = build_setup(scene.case)
    options = setup.torsion.variable_inertia
    assert options is not None
    system, torque = system_of(setup, setup.speed), gas_torque(setup, setup.speed)
    _emit_variation(scene, setup, system)
    highest, full = _operating(setup, system, torque, options.orders, scene)
    scene.emit(f"{VARIABLE}highest_order", highest, 0.0)
    axes = {"section": setup.shaft.section_names}
    constant = with_mean_inertias(setup, np.array([setup.speed]))[0]
    varying = half_ranges(system, setup.speed, full) / np.abs(setup.shaft.section_ratio)
    scene.emit(f"{VARIABLE}constant_half_range", constant, axes=axes)
    scene.emit(f"{VARIABLE}torque_half_range", varying, axes=axes)
    change = relative_change(constant, varying)
    scene.emit(f"{VARIABLE}change", change, axes=axes)
    carried = (torques(system, setup.speed, full) / setup.shaft.section_ratio).T
    scene.emit(f"{VARIABLE}torque", carried, axes=axes | {"order": full.order[1:]})
    worst = int(np.argmax(np.abs(change.value)))
    _emit_secondary(scene, setup, system, torque, highest, worst)
    if not np.any(system.line.loss_factor):
        _emit_stability(scene, setup, system, full)
    if setup.torsion.speeds is not None:
        emit_speeds(scene, setup, setup.torsion.speeds, highest)
    scene.cite(
        "harmonic balance of the whole Lagrangian system with angle-dependent inertias; "
        "multipliers over the cycle",
        "variable inertia",
        "Pasricha and Carnegie (1976), Journal of Sound and Vibration 46; "
        "docs/theory_torsion_studies.md",
    )


def system_of(setup: Setup, speed: float) -> VariableLine:
    """The line at a speed with the variation that its inertia torque says."""
    drive, line = setup.drive, setup.model.at(speed)
    whole = drive.order == np.floor(drive.order)
    given = inertia_variation(_by_order(drive.order[whole], drive.inertia.value[whole]).T)
    size = np.max(np.abs(given) / line.inertia[drive.freedom][:, None], axis=0)
    last = int(np.flatnonzero(size > _NEGLIGIBLE).max(initial=-1)) + 1
    variation = placed(drive.freedom, line.inertia.size).T @ given[:, :last]
    load = np.zeros(line.inertia.size)
    load[setup.shaft.load_freedom] = 1.0
    for part in turning_parts(line):
        if not np.any(part * load):  # a ring in oil alone: nothing drives it on the mean
            load += part * line.inertia
    turns = round(drive.firing.cycle / (2.0 * np.pi))
    return variable_line(line, variation, turns=turns, load=load)


def _by_order(order: FloatArray, torque: ComplexArray) -> ComplexArray:
    """Rows for the orders 1, 2, 3 and so on, zero where one is missing."""
    count = int(order.max(initial=0.0))
    rows = np.zeros((count, torque.shape[1]), dtype=complex)
    rows[order.astype(int) - 1] = torque
    return rows


def gas_torque(setup: Setup, speed: float) -> ComplexArray:
    """Torque (T, n) at orders k / turns from the mean on, without that of the inertias."""
    drive, n = setup.drive, setup.model.line.inertia.size
    turns = round(drive.firing.cycle / (2.0 * np.pi))
    place = np.rint(drive.order * turns).astype(int)
    torque = np.zeros((int(place.max(initial=0)) + 1, n), dtype=complex)
    share, on = drive.weights(np.asarray(speed)), placed(drive.freedom, n)
    torque[place] = np.tensordot(share, drive.gas.value, 1) @ on
    torque[0] = share @ drive.mean.value @ on - setup.shaft.mean_load(speed)
    return torque


def torques(system: VariableLine, speed: float, steady: SteadyTwist) -> Bounded:
    """Referred torques (m, e) of all orders but the mean."""
    angle = Bounded(steady.angle[0, 1:], steady.error[0, 1:].max(axis=-1, keepdims=True))
    return twist_and_torque(system.line, speed * steady.order[1:], angle)[1]


def half_ranges(system: VariableLine, speed: float, steady: SteadyTwist) -> Bounded:
    """Half range (e,) of the referred torque of each element over the cycle.

    Orders above the highest that was kept are missing in it: what those inside drive there counts.
    """
    carried = torques(system, speed, steady).T
    whole = synthesis(steady.order[1:], carried.value)
    stiff = np.abs(complex_stiffness(system.line, speed * steady.order[-1:])[0])
    # one solve has all orders: their errors may have one sign
    error = whole.error + carried.error.sum(axis=-1) + _BEYOND * stiff * steady.beyond[0]
    return Bounded(whole.half_range, error)


def with_mean_inertias(setup: Setup, speed: FloatArray) -> Bounded:
    """Half ranges (s, e) of the torque at speeds (s,) as usually computed; infinite undamped."""
    return readings_of(setup)[TORQUE].of(Motion(setup, speed, bounded=True))


def relative_change(constant: Bounded, varying: Bounded) -> Bounded:
    """Varying over constant less one, 0 where nothing but rounding is carried."""
    there = constant.value > 4.0 * constant.errors
    return where(there, varying / where(there, constant, 1.0) - 1.0, 0.0)


def _operating(
    setup: Setup, system: VariableLine, torque: ComplexArray, asked: int | None, scene: Scene
) -> tuple[float, SteadyTwist]:
    """Highest order, and the motion with the inertias as they turn."""
    first = float(np.ceil(max(setup.drive.order[-1], system.variation.shape[1]))) + 1.0
    tries = [float(asked)] if asked is not None else [np.ceil(f * first) for f in _TRIES]
    for highest in tries:
        try:
            full = steady_response(system, setup.speed, torque, highest, exact=True)
        except NumericalFailure:
            if highest == tries[-1]:
                raise
            continue
        largest = float(np.max(np.abs(full.angle)))
        if float(np.max(full.error)) <= scene.case.accuracy.rtol * largest:
            break
    return float(highest), full


def _emit_variation(scene: Scene, setup: Setup, system: VariableLine) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, _ANGLES, endpoint=False)
    value = inertia_at(system, angle[:, None]).value
    mean = system.line.inertia
    span = 0.5 * (value.max(axis=0) - value.min(axis=0))
    share = np.where(mean > 0.0, span / np.where(mean > 0.0, mean, 1.0), 0.0)
    bend = (np.arange(1, system.variation.shape[1] + 1) ** 2 * np.abs(system.variation)).sum(axis=1)
    # between two of the angles the extreme may lie higher by so much
    uncertainty = 0.125 * (angle[1] - angle[0]) ** 2 * bend / np.where(mean > 0.0, mean, 1.0)
    uncertainty = uncertainty + 8.0 * EPSILON
    axes = {"station": setup.shaft.station_names}
    freedom = setup.shaft.freedom
    scene.emit(f"{VARIABLE}relative_variation", share[freedom], uncertainty[freedom], axes)


def _emit_secondary(
    scene: Scene, setup: Setup, system: VariableLine, torque: ComplexArray, highest: float,
    section: int,
) -> None:  # fmt: skip
    """Which orders feed which in one section, of the linear motion."""
    linear = steady_response(system, setup.speed, torque, highest)
    angle = Bounded(linear.angle[0], linear.error[0])
    own = float(setup.shaft.section_ratio[section])
    twist = with_errors(feed, system, setup.speed, angle)[..., section] * own
    size = np.abs(twist.value)
    total, best = size.sum(axis=1), np.argmax(size, axis=1)
    ends = system.line.first[section], system.line.second[section]
    # what orders above the highest feed is missing: the truncation of the response itself
    error = twist.errors.sum(axis=1) + abs(own) * sum(angle.error[:, end] for end in ends)
    axes = {"order": linear.order[1:]}
    scene.emit(f"{VARIABLE}secondary/twist", twist.value.sum(axis=1)[1:], error[1:], axes)
    scene.emit(f"{VARIABLE}secondary/source", linear.order[best][1:], 0.0, axes)
    fed = np.where(total > 0.0, total, 1.0)
    # of what is lost in round-off the share says nothing
    share, known = size.max(axis=1) / fed, np.where(total > 0.0, error / fed, 0.0)
    scene.emit(f"{VARIABLE}secondary/share", share[1:], np.minimum(known[1:], 1.0), axes)


def _emit_stability(scene: Scene, setup: Setup, system: VariableLine, motion: SteadyTwist) -> None:
    found = stability(
        system, setup.speed, angle=motion.angle[0], angle_error=motion.error[0],
        basis=basis_of(setup, system),
    )  # fmt: skip
    refuse_unstable(found, setup.speed)
    scene.emit(f"{VARIABLE}growth", found.growth, found.growth_error)


def basis_of(setup: Setup, system: VariableLine) -> FloatArray | None:
    """Shapes of the modes where a freedom has no inertia, else None: every freedom counts."""
    return setup.modes.shape if np.any(system.line.inertia <= 0.0) else None


# ----------------------------------------------------------------------------
# Adapter, continued: variable inertia over a range of speeds, and where vibration grows.
# ----------------------------------------------------------------------------

#: even steps of the range; criticals that are added, the lowest orders first; wedges that are
#: reported
_EVEN, _CRITICALS, _WEDGES = 31, 20, 8
#: a wedge whose growth is below this share of what damping takes away is not examined
_FEARED, _MOST_RANGES = 0.3, 4


def emit_speeds(scene: Scene, setup: Setup, asked: LineSpeeds, highest: float) -> None:
    """Half ranges, changes, wedges and unstable ranges over the speeds of the case."""
    _emit_half_ranges(scene, setup, highest, _speeds(setup, asked))
    found = _emit_wedges(scene, setup, asked)
    if not np.any(setup.model.line.loss_factor):
        _emit_unstable(scene, setup, asked, found)


def _speeds(setup: Setup, asked: LineSpeeds) -> FloatArray:
    """Even steps, and the criticals of the lowest orders among them."""
    even = np.linspace(asked.start, asked.stop, min(asked.points, _EVEN))
    met = setup.natural().frequency / setup.drive.order[:, None]
    inside = met[(met >= asked.start) & (met <= asked.stop)]
    return np.unique(np.concatenate([even, inside[:_CRITICALS]]))


def _emit_half_ranges(scene: Scene, setup: Setup, highest: float, speeds: FloatArray) -> None:
    count, ratio = len(setup.shaft.section_names), np.abs(setup.shaft.section_ratio)
    endless = Bounded(np.full(count, np.inf), np.zeros(count))
    halves, changes, left = [], [], 0
    constant = with_mean_inertias(setup, speeds)
    for place, speed in enumerate(speeds.tolist()):
        system, torque = system_of(setup, speed), gas_torque(setup, speed)
        try:
            full = steady_response(system, speed, torque, highest)
        except NumericalFailure:
            full = None
        if full is None or not np.all(np.isfinite(constant.value[place])):
            left += 1
            halves.append(endless)
            changes.append(endless)
            continue
        varying = half_ranges(system, speed, full) / ratio
        halves.append(varying)
        changes.append(relative_change(constant[place], varying))
    if left:
        scene.warn(
            f"variable inertia: no steady motion at {left} of {len(speeds)} speeds (undamped "
            "critical speed or stability limit), reported as unbounded"
        )
    axes = {"section": setup.shaft.section_names, "variable_speed": speeds}
    scene.emit(f"{VARIABLE}speeds/torque_half_range", stack(halves), axes=axes)
    change = stack(changes)
    scene.emit(f"{VARIABLE}speeds/change", change, axes=axes)
    reported = np.where(np.isfinite(change.value), np.abs(change.value), -1.0)
    best, row = np.argmax(reported, axis=1), np.arange(count)
    if np.any(reported[row, best] < 0.0):
        raise NumericalFailure("variable inertia: no speed of the range has a steady motion")
    axes = {"section": setup.shaft.section_names}
    scene.emit(f"{VARIABLE}largest_change", change[row, best], axes=axes)
    scene.emit(f"{VARIABLE}largest_change_speed", speeds[best], 0.0, axes)


def _emit_wedges(scene: Scene, setup: Setup, asked: LineSpeeds) -> Wedges:
    """The widest sum resonances whose centre lies in the range."""
    system, modes = system_of(setup, setup.speed), setup.modes
    all_wedges = wedges(system, modes.frequency, modes.shape, modes.modal_inertia)
    inside = (
        (all_wedges.speed >= asked.start)
        & (all_wedges.speed <= asked.stop)
        & (all_wedges.half_width > 0.0)
    )
    shown = np.flatnonzero(inside)[:_WEDGES]
    first = Wedges(**{name: part[shown] for name, part in all_wedges._asdict().items()})
    axes = {"wedge": np.arange(1, len(shown) + 1)}
    for name, value, error in (
        ("speed", first.speed, first.error), ("half_width", first.half_width, first.error),
        ("order", first.order.astype(float), 0.0), ("first_mode", first.first + 1.0, 0.0),
        ("second_mode", first.second + 1.0, 0.0),
        ("growth", first.growth, first.error * first.order),
        ("damping_ratio", first.damping_ratio, first.damping_ratio * first.error
         / np.maximum(first.half_width, np.finfo(float).tiny)),
    ):  # fmt: skip
        scene.emit(f"{VARIABLE}wedge/{name}", value, error, axes)
    return first


def _emit_unstable(scene: Scene, setup: Setup, asked: LineSpeeds, regions: Wedges) -> None:
    """Ranges, about the widest wedges, in which the line as it is damped has growing vibration."""
    system = system_of(setup, setup.speed)
    if np.any(setup.model.speed_stiffness):
        scene.warn("unstable ranges: pendulums as at the operating speed")
    if setup.model.over_speed is not None:
        scene.warn("unstable ranges: damping as at the operating speed")
    # rates of decay in 1/s from the work of undamped shapes
    line, modes = setup.model.line, setup.modes
    twist = modes.shape[:, line.first] - modes.shape[:, line.second]
    work = twist**2 @ line.damping + modes.shape**2 @ line.absolute_damping
    decay = 0.5 * work / modes.modal_inertia
    held = np.sqrt(decay[regions.first] * decay[regions.second])
    feared = np.flatnonzero(regions.growth > _FEARED * held)[:_MOST_RANGES]
    centre, width = regions.speed[feared], regions.half_width[feared] + regions.error[feared]
    examined = (centre[:, None] + width[:, None] * np.array([-4.0, -1.5, 0.0, 1.5, 4.0])).ravel()
    examined = np.clip(examined, asked.start, asked.stop)
    ranges = unstable_ranges(system, examined, basis=basis_of(setup, system))
    axes = {"unstable": np.arange(1, len(ranges) + 1)}
    low, high, error, growth = ranges.T
    scene.emit(f"{VARIABLE}unstable/from", low, error, axes)
    scene.emit(f"{VARIABLE}unstable/to", high, error, axes)
    scene.emit(f"{VARIABLE}unstable/growth", growth, 1e-9 * np.abs(growth), axes)
