"""Adapter: rotor, pistons and shell in the periodic motion that their motor gives them."""

import numpy as np

from vibecalc.case.roll_tables import Roll
from vibecalc.machine.roll import RollParts, build_roll, roll_drive
from vibecalc.machine.roll_motor import fitted_motor
from vibecalc.numerics.level import level_of
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.roll import FORCES, ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.roll_motor import doubted, emit_motor
from vibecalc.pipeline.stages.roll_observed import (
    Looks,
    Seen,
    course_of,
    extremes_of,
    lags_of,
    leak_of,
    numbers_of,
    peaks_of,
    seen_in,
    spectra_of,
)
from vibecalc.pipeline.stages.roll_shaking import emit_shaking
from vibecalc.pipeline.stages.roll_studies import (
    emit_classical,
    emit_interpolations,
    emit_methods,
    emit_sensitivity,
)
from vibecalc.response.roll.course import course_of_turn
from vibecalc.response.roll.machine import RollDrive, RollMachine, as_batch, is_mounted
from vibecalc.response.roll.running import Running, running_state
from vibecalc.response.roll.ways import Asked, find

_ROUNDING = 32.0 * EPSILON
#: zero for the exact motion, so that all of it is error
_ZERO = ("energy/residual", "momentum_residual")
#: safety of a difference of dials where the case has chosen the points
_CHOSEN = 2.0


def run(scene: Scene) -> None:
    """Emit the running state, its spectra and balances, and what the case asks for beside it."""
    response = scene.case.response
    if response is None or response.roll is None:
        raise ValueError("the case has no [response.roll]")
    options, parts = response.roll, build_roll(scene.case)
    machine, drive = as_batch(parts.machine), roll_drive(parts)
    fitted = fitted_motor(parts.motor)
    checked = drive
    if fitted is not None:
        checked = drive._replace(circuit=fitted.other)
        drive = drive._replace(circuit=fitted.circuit)
    _cite(scene)
    running = running_state(
        machine,
        drive,
        rtol=scene.case.accuracy.rtol,
        orders=options.orders,
        started_at=options.started_at,
        points=options.points if options.method == "collocation" else None,
        course=scene.wants(*_below("cycle")),
    )
    if fitted is not None:
        running = doubted(machine, checked, running, options.started_at)
    looks = _looks(options, machine, drive, checked, running)
    _emit_spectra(scene, parts, options.orders, looks)
    _emit_numbers(scene, looks)
    _emit_course(scene, parts, looks)
    _emit_stability(scene, machine, running)
    if fitted is not None and scene.wants(*_below("motor")):
        emit_motor(scene, options, machine, fitted, running, (looks.own, looks.other))
    if options.interpolations and scene.wants(*_below("interpolation")):
        emit_interpolations(scene, parts, options, machine, drive)
    if options.compare and scene.wants(*_below("method")):
        emit_methods(scene, options, machine, drive, running)
    if options.sensitivity and scene.wants(*_below("sensitivity")):
        emit_sensitivity(scene, parts, options, machine, drive, running)
    if options.classical and scene.wants(*_below("classical")):
        emit_classical(scene, parts, looks, options.orders)
    if options.classical and scene.wants(*_below("shaking")):
        best = looks.best or (looks.other,)
        emit_shaking(scene, looks.own, best[0], options.orders)


def _below(part: str) -> tuple[str, ...]:
    from vibecalc.pipeline.stage_plan import below

    return below(f"{ROOT}/{part}/")


def _looks(
    options: Roll, machine: RollMachine, drive: RollDrive, checked: RollDrive, running: Running
) -> Looks:
    """The motion by the method of the case, from its dial and a finer (or coarser) one.

    `checked` is the drive of the check: that of the motion, but for what a fit leaves open.
    """
    one, other = (
        seen_in(machine, own, state)
        for own, state in ((drive, running.state), (checked, running.check))
    )
    if options.method == "collocation":
        # with points of the case nobody has looked whether these are enough
        near = running.coarse
        if near is None:
            return Looks(one, other, safety=_CHOSEN if options.points else 1.0)
        coarse = seen_in(machine, drive, near)
        dials = (running.state.points, running.check.points, near.points)
        return Looks(one, other, coarse=coarse, steps=(dials[0] - dials[1]) / (dials[1] - dials[2]))
    fading = float(np.max(np.abs(running.multiplier)))
    asked = Asked(options.points, options.step, options.started_at, running.state.momentum, fading)
    found = find(options.method, machine, drive, asked)
    each = [Seen(machine, drive, turn, course_of_turn(turn)) for turn in (found.turn, found.finer)]
    return Looks(each[0], each[1], found.order, best=(one, other))


def _emit_spectra(scene: Scene, parts: RollParts, orders: int, looks: Looks) -> None:
    numbers = np.arange(1, orders + 1)
    spectra, leak = looks.read(lambda seen: spectra_of(seen, orders)), leak_of(looks.own)
    for name, (values, rounding) in spectra[0].items():
        error = looks.error(*(each[name][0] for each in spectra)) + rounding
        error = error + leak * np.max(np.abs(values), initial=0.0)
        axes = {"order": numbers, "cylinder": np.array(parts.names, dtype=object)}
        scene.emit(f"{ROOT}/{name}", values, error, axes)
        levels, doubt = level_of(values, error, reference=1.0)
        scene.emit(f"{ROOT}/level/{name}", levels, doubt, axes)
        scene.emit(f"{ROOT}/phase_lag/{name}", *lags_of(values, error), axes)


def _emit_numbers(scene: Scene, looks: Looks) -> None:
    each, leak = looks.read(numbers_of), leak_of(looks.own)
    extremes: frozenset[str] = frozenset()
    if scene.wants(f"{ROOT}/speed_variation", f"{ROOT}/largest_slip"):
        for found, more in zip(each, looks.read(extremes_of), strict=True):
            found.update(more)
            extremes = frozenset(more)
    for name, number in each[0].items():
        values = [found[name].value for found in each]
        # a margin without end has no error
        finite = np.all(np.isfinite(values))
        apart = float(looks.error(*values, single=name in extremes)) if finite else 0.0
        error = apart + number.error + (_ROUNDING + leak) * number.size
        if name in _ZERO:
            error = max(error, abs(number.value))
        scene.emit(f"{ROOT}/{name}", number.value, error, terms=number.size)


def _emit_course(scene: Scene, parts: RollParts, looks: Looks) -> None:
    if scene.wants(*_below("cycle")):
        courses = looks.read(course_of)
        angles, own = courses[0]
        axes = {"cylinder": np.array(parts.names, dtype=object), "crank_angle": angles}
        for name, values in own.items():
            rounding = _ROUNDING * float(np.max(np.abs(values), initial=0.0))
            error = looks.error(*(each[name] for _, each in courses)) + rounding
            scene.emit(f"{ROOT}/cycle/{name}", values, error, axes)
    if scene.wants(*(f"{ROOT}/{name}_peak" for name in FORCES)):
        peaks = looks.read(peaks_of)
        for name, (values, left) in peaks[0].items():
            apart = looks.error(*(each[name][0] for each in peaks), single=True)
            error = apart + left + _ROUNDING * values
            scene.emit(f"{ROOT}/{name}_peak", values, error, {"cylinder": parts.names})


def _emit_stability(scene: Scene, machine: RollMachine, running: Running) -> None:
    value, error = running.multiplier[0], running.multiplier_error[0]
    axes = {"multiplier": np.arange(1, len(value) + 1)}
    scene.emit(f"{ROOT}/multiplier", value, error, axes)
    scene.emit(f"{ROOT}/largest_multiplier", float(np.max(np.abs(value))), float(np.max(error)))
    scene.emit(f"{ROOT}/trivial_multipliers", 1 if is_mounted(machine) else 3)


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
