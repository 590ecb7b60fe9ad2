"""Comparison variants of a shaft line: without its dampers, with all cylinders firing."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.numerics.bounded import Bounded, stack, where
from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.numerics.synthesis import over_cycle
from vibecalc.torsion.adapters.bounds import bounds
from vibecalc.torsion.adapters.curves import (
    at_largest,
    bounded_orders,
    curve_uncertainty,
    section_heat,
    sweep,
)
from vibecalc.torsion.adapters.largest_alone import what_drives
from vibecalc.torsion.adapters.limits import (
    Range,
    emit_element,
    largest_of_loads,
    largest_uses,
    operating_uses,
    over_range,
    unbarred_use,
    uses_of,
)
from vibecalc.torsion.adapters.readings import emit_half_ranges
from vibecalc.torsion.adapters.setup import (
    Setup,
    build_drive,
    build_model,
    natural_of,
)
from vibecalc.torsion.line import mapped
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: a line in another state next to its own: curves, largest values, at operating speed.
# ----------------------------------------------------------------------------


def _sections(setup: Setup) -> IntArray:
    """Places of the sections that a line has, which may be without its dampers."""
    kinds, count = setup.shaft.section_kinds, len(setup.model.line.first)
    there = [len(kinds) == count or kind != "damper" for kind in kinds]
    return np.flatnonzero(there)


def emit_operating(scene: Scene, place: str, setup: Setup) -> Bounded:
    """Half ranges at the operating speed; gives own torques (k,).

    Infinite where an order meets a mode that nothing damps.
    """
    at = np.array([setup.speed])
    curves = sweep(setup.model, setup.drive, at, None, angles=False)
    off = curve_uncertainty(setup, at, np.zeros(0))
    torque, twist = Bounded(curves.torque[0], off.torque), Bounded(curves.twist[0], off.twist)
    return emit_half_ranges(scene, place, setup.shaft, _sections(setup), torque, twist, {})


def emit_range(
    scene: Scene, stem: str, setup: Setup, speed: FloatArray, limited: bool = False
) -> tuple[Range, Bounded]:
    """Curves over speeds (s,) and the largest values of each section; gives referred torques (k,).

    `limited`: what the line has limits for is examined as closely as its largest values.
    """
    found = over_range(setup, speed, limited, setup.shaft if limited else None)
    torque, twist = (
        Bounded(getattr(found.curves, name), getattr(found.uncertainty, name))
        for name in ("torque", "twist")
    )
    top, place, section = found.top, f"{stem}/largest", _sections(setup)
    over = {"speed": speed}
    emit_half_ranges(scene, f"{stem}/speeds", setup.shaft, section, torque, twist, over)
    torque, twist = at_largest(setup, top, speed[-1], scene.wants(f"{place}/twist_half_range"))
    emit_half_ranges(scene, place, setup.shaft, section, torque, twist, {})
    names = tuple(setup.shaft.section_names[e] for e in section)
    scene.emit(f"{place}/speed", top.speed, top.speed_error, {"section": names})
    return found, torque


# ----------------------------------------------------------------------------
# Adapter: the same shaft line without its dampers, at the same speeds.
# ----------------------------------------------------------------------------

BARE = f"{ROOT}/bare"
IN_BARE = below(f"{ROOT}/bare/")


def _coupled(setup: Setup, whole: Setup | None = None) -> Setup:
    """With couplings that follow what this line, maybe a part of the whole, makes of them."""
    if not setup.shaft.couplings:
        return setup
    from vibecalc.torsion.adapters.coupling_states import coupled

    return coupled(setup, whole)


def bare_setup(setup: Setup) -> Setup:
    """The line without rings and what holds them; hubs belong to their stations and stay."""
    shaft, line = setup.shaft, setup.shaft.line
    stays = np.array([kind != "damper" for kind in shaft.section_kinds])
    count = line.inertia.shape[-1] - len(shaft.dampers)
    # many machines differ in their rings alone
    line = mapped(line, lambda one: one[0] if one.ndim > 1 else one)
    bare = line._replace(
        inertia=line.inertia[:count],
        absolute_damping=line.absolute_damping[:count],
        ground_stiffness=line.ground_stiffness[:count],
        first=line.first[stays],
        second=line.second[stays],
        stiffness=line.stiffness[stays],
        damping=line.damping[stays],
        loss_factor=line.loss_factor[stays],
    )
    torsion, speed = setup.torsion, setup.speed
    model, undamped = build_model(
        torsion, bare, shaft.speed_stiffness[stays], speed, count, shaft.over_speed
    )
    natural = natural_of(torsion, model, undamped, speed)
    bare_line = setup._replace(model=model, undamped=undamped, natural=natural)
    return _coupled(bare_line, setup)


def emit_bare(scene: Scene, setup: Setup, speed: FloatArray, damped: Bounded) -> None:
    """Curves and largest values without dampers; how much less they are with them.

    `damped` (..., e) are the largest referred torques of the whole line.
    """
    bare = bare_setup(setup)
    if not scene.wants(*IN_BARE):
        if scene.wants(f"{ROOT}/reduction"):
            _emit_reduction(scene, bare, _bare_torque(scene, bare, speed), damped)
        return
    frequency = bare.modes.frequency
    modes = {"bare_mode": np.arange(1, len(frequency) + 1)}
    scene.emit(f"{BARE}/natural_frequency", frequency, bare.modes.frequency_error, modes)
    emit_operating(scene, BARE, bare)
    _emit_reduction(scene, bare, emit_range(scene, BARE, bare, speed)[1], damped)


def _bare_torque(scene: Scene, bare: Setup, speed: FloatArray) -> Bounded:
    """Largest torques of the bare line, of runs before this one where they had the same line."""

    def find() -> Bounded:
        return emit_range(scene, BARE, bare, speed)[1]

    inputs = what_drives(bare.model, bare.drive, speed)
    if inputs is None:
        return find()
    known: Bounded | None = scene.again("largest torques of a line", (*inputs, bare.speed), find)
    return find() if known is None else known


def _emit_reduction(scene: Scene, bare: Setup, torque: Bounded, damped: Bounded) -> None:
    stays = _sections(bare)
    less = damped[..., stays]
    finite = np.isfinite(less.value) & np.isfinite(torque.value) & (less.value > 0.0)
    gain = where(finite, torque, 1.0) / where(finite, less, 1.0)
    axes = {"section": tuple(bare.shaft.section_names[e] for e in stays)}
    scene.emit(f"{ROOT}/reduction", where(finite, gain, np.inf), axes=axes)


# ----------------------------------------------------------------------------
# Adapter: a shaft line whose cylinders all fire, next to its misfire.
# ----------------------------------------------------------------------------

HEALTHY = f"{ROOT}/healthy"


def healthy_setup(scene: Scene, setup: Setup) -> Setup:
    """The same line with the torques of an engine that fires in all cylinders."""
    healthy = setup._replace(drive=build_drive(scene.case, setup.shaft, all_fire=True))
    return _coupled(healthy)


def emit_healthy(scene: Scene, setup: Setup) -> None:
    """Half ranges at the operating speed, mean torque, dampers, use of limits."""
    healthy = healthy_setup(scene, setup)
    at = np.array([setup.speed])
    torque = emit_operating(scene, HEALTHY, healthy)
    scene.emit(f"{HEALTHY}/mean_torque", healthy.drive.mean_torque(at).sum()[0])
    if setup.torsion.limits:
        uses = operating_uses(healthy, torque)
        use = largest_uses(uses)
        axes = {"limit": np.arange(1, len(use.value) + 1)}
        scene.emit(f"{HEALTHY}/limit/operating_use", use, axes=axes)
        _emit_element(scene, healthy, "operating_", [int(np.argmax(one.value)) for one in uses],
                      np.full(len(uses), setup.speed), axes)  # fmt: skip
    if setup.shaft.couplings:
        from vibecalc.torsion.adapters.couplings import emit_use

        emit_use(scene, healthy, f"{HEALTHY}/coupling")
    if setup.shaft.dampers:
        _dampers(scene, healthy)


def emit_healthy_range(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Curves and largest values over speeds (s,), largest use of limits."""
    healthy = healthy_setup(scene, setup)
    found, _ = emit_range(scene, HEALTHY, healthy, speed, limited=bool(setup.torsion.limits))
    if setup.shaft.couplings:
        from vibecalc.torsion.adapters.couplings import emit_largest_use

        emit_largest_use(scene, healthy, speed, found.dense.speed, f"{HEALTHY}/coupling")
    if not setup.torsion.limits:
        return
    seen, asked = (found.dense, found.undamped), bounds(healthy)
    uses = [uses_of(healthy, bound, *seen) for bound in asked]
    every = [
        largest_of_loads(healthy, bound, one, *seen) for bound, one in zip(asked, uses, strict=True)
    ]
    worst = [int(np.argmax(one.use.value)) for one in every]
    use, at = (
        stack([getattr(one, name)[k] for one, k in zip(every, worst, strict=True)], axis=0)
        for name in ("use", "speed")
    )
    axes = {"limit": np.arange(1, len(every) + 1)}
    scene.emit(f"{HEALTHY}/limit/largest_use", use, axes=axes)
    scene.emit(f"{HEALTHY}/limit/speed", at, axes=axes)
    _emit_element(scene, healthy, "", worst, at.value, axes)
    unbarred = [
        unbarred_use(setup.speed, bound, one, found.dense, found.undamped)
        for bound, one in zip(asked, uses, strict=True)
    ]
    scene.emit(f"{HEALTHY}/limit/unbarred_use", np.array(unbarred), use.error, axes)


def _emit_element(
    scene: Scene,
    setup: Setup,
    start: str,
    worst: list[int],
    speed: FloatArray,
    axes: Mapping[str, Any],
) -> None:
    """Of each limit the load of largest use, by its place among those of the limit, at a speed."""
    asked = bounds(setup)
    each = list(zip(asked, worst, speed, strict=True))
    load = np.array([bound.load[k] for bound, k, _ in each])
    share = np.array([
        1.0 / (bound.modulus[k] * bound.continuous(np.array(at))[k]) for bound, k, at in each
    ])  # fmt: skip
    emit_element(scene, f"{HEALTHY}/limit/{start}", asked, load, share, axes)


def _dampers(scene: Scene, setup: Setup) -> None:
    """Heat of the dampers and the largest travel of their rings, at the operating speed."""
    shaft, at = setup.shaft, np.array([setup.speed])
    rings = [one.element for one in shaft.dampers]
    state = bounded_orders(setup, at)
    masked = bool(state.masked.any())
    axes = {"damper": tuple(one.name for one in shaft.dampers)}
    heat = section_heat(setup, at, state)[0, rings]
    twist = (state.twist[0] * np.abs(shaft.section_ratio))[:, rings]
    travel = over_cycle(setup.drive.cycles, twist.T).peak
    scene.emit(f"{HEALTHY}/damper/heat", where(masked, np.inf, heat), axes=axes)
    scene.emit(f"{HEALTHY}/damper/travel", where(masked, np.inf, travel), axes=axes)
