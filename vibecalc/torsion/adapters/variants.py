"""A shaft line over speeds, and its comparison variants: without dampers, with all firing."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.numerics.bounded import Bounded, where
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.bounds import limit_corners
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.largest_alone import what_drives
from vibecalc.torsion.adapters.motion import (
    HALF,
    STRESS,
    TORQUE,
    TWIST,
    Motion,
    emit_readings,
    readings_of,
    stress_of,
)
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup, build_drive, build_model, natural_of
from vibecalc.torsion.line import mapped, without_freedom
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: a line over a range of speeds: curves and largest values.
# ----------------------------------------------------------------------------


def line_search(
    setup: Setup, speed: FloatArray, names: Sequence[str], others: dict[str, Any]
) -> Search:
    """Over speeds (s,): some of `readings_of` the line, and `others`, which are searched with it.

    Twists and stresses are those where the torque is largest, mean torques are not searched.
    """
    known = readings_of(setup)
    own = {name: known[name] for name in names if name in known}
    searched = [name for name in own if name not in (TWIST, STRESS, "gear_mean_torque")]
    corners = limit_corners(setup) if others else np.zeros(0)
    return Search([setup], speed, [own | others], [*searched, *others], corners)


def emit_curves(scene: Scene, stem: str, search: Search, names: Sequence[str]) -> None:
    """Some readings over the speeds."""
    found = {one: search.bounded_curves(one) for one in names if one in search.columns}
    emit_readings(scene, f"{stem}/speeds", search.lines[0], found, {"speed": search.speed})


def emit_largest(scene: Scene, stem: str, search: Search) -> Bounded:
    """Largest torques of sections with twists and stresses there; gives the torques (..., e)."""
    setup, place, top = search.lines[0], f"{stem}/largest", search.top(TORQUE)
    only: Any = slice(None) if setup.model.machines else 0
    found = {TORQUE: top.value[only]}
    if scene.wants(f"{place}/{TWIST}"):
        found[TWIST] = search.beside(TWIST, top)[only]
    if STRESS in readings_of(setup):
        found[STRESS] = stress_of(setup, found[TORQUE])
    emit_readings(scene, place, setup, found, {})
    scene.emit(f"{place}/speed", top.speed[only], axes={"section": setup.shaft.section_names})
    return found[TORQUE]


# ----------------------------------------------------------------------------
# Adapter: the same shaft line without its dampers, at the same speeds.
# ----------------------------------------------------------------------------

BARE = f"{ROOT}/without_dampers"
IN_BARE = below(f"{ROOT}/without_dampers/")


def bare_setup(setup: Setup) -> Setup:
    """The line without rings and what holds them; hubs belong to their stations and stay."""
    shaft = setup.shaft
    stays = np.flatnonzero([kind != "damper" for kind in shaft.section_kinds])
    # many machines differ in their rings alone
    bare = mapped(shaft.line, lambda one: one[0] if one.ndim > 1 else one)
    for damper in reversed(shaft.dampers):
        bare = without_freedom(bare, damper.ring, damper.element)[0]
    less = replace(
        shaft,
        line=bare,
        speed_stiffness=shaft.speed_stiffness[stays],
        section_ends=shaft.section_ends[stays],
        section_names=tuple(shaft.section_names[e] for e in stays),
        section_kinds=tuple(shaft.section_kinds[e] for e in stays),
        section_ratio=shaft.section_ratio[stays],
        section_modulus=shaft.section_modulus[stays],
        dampers=(),
    )
    torsion, speed = setup.torsion, setup.speed
    model, undamped = build_model(
        torsion, bare, less.speed_stiffness, speed, len(bare.inertia), shaft.over_speed
    )
    natural = natural_of(torsion, model, undamped, speed)
    line_of = setup._replace(shaft=less, model=model, undamped=undamped, natural=natural)
    return coupled(line_of)


def emit_bare(scene: Scene, setup: Setup, speed: FloatArray, damped: Bounded) -> None:
    """Curves and largest values without dampers; how much less they are with them.

    `damped` (..., e) are the largest torques of the whole line.
    """
    bare = bare_setup(setup)

    def torques() -> Bounded:
        search = line_search(bare, speed, HALF, {})
        emit_curves(scene, BARE, search, HALF)
        return emit_largest(scene, BARE, search)

    if not scene.wants(*IN_BARE):
        if scene.wants(f"{ROOT}/reduction"):
            # of runs before this one where they had the same line
            inputs = what_drives(bare.model, bare.drive, speed)
            known = None
            if inputs is not None:
                known = scene.again("largest torques of a line", (*inputs, bare.speed), torques)
            _emit_reduction(scene, bare, torques() if known is None else known, damped)
        return
    frequency = bare.modes.frequency
    modes = {"mode_without_dampers": np.arange(1, len(frequency) + 1)}
    scene.emit(f"{BARE}/natural_frequency", frequency, bare.modes.frequency_error, modes)
    emit_operating(scene, BARE, Motion(bare, np.array([bare.speed]), bounded=True))
    _emit_reduction(scene, bare, torques(), damped)


def emit_operating(scene: Scene, place: str, motion: Motion) -> None:
    """Half ranges at the operating speed; infinite where an order meets an undamped mode."""
    known = readings_of(motion.setup)
    found = {name: known[name].of(motion)[0] for name in HALF if name in known}
    emit_readings(scene, place, motion.setup, found, {})


def _emit_reduction(scene: Scene, bare: Setup, torque: Bounded, damped: Bounded) -> None:
    less = damped[..., : len(bare.shaft.section_names)]
    finite = np.isfinite(less.value) & np.isfinite(torque.value)
    finite &= less.value > 4.0 * less.errors  # a ratio to rounding tells nothing
    gain = where(finite, torque, 1.0) / where(finite, less, 1.0)
    axes = {"section": bare.shaft.section_names}
    scene.emit(f"{ROOT}/reduction", where(finite, gain, np.inf), axes=axes)


# ----------------------------------------------------------------------------
# Adapter: a shaft line whose cylinders all fire, next to its misfire.
# ----------------------------------------------------------------------------

HEALTHY = f"{ROOT}/healthy"


def healthy_setup(scene: Scene, setup: Setup) -> Setup:
    """The same line with the torques of an engine that fires in all cylinders."""
    return coupled(setup._replace(drive=build_drive(scene.case, setup.shaft, all_fire=True)))


def emit_healthy(scene: Scene, setup: Setup, speed: FloatArray | None = None) -> None:
    """Half ranges, mean torque, dampers, use of limits at the operating speed.

    With speeds (s,) curves, largest values and uses over them instead.
    """
    healthy = healthy_setup(scene, setup)
    motion, limit = Motion(healthy, np.array([setup.speed]), bounded=True), f"{HEALTHY}/limit"
    axes = {"limit": np.arange(1, len(setup.torsion.limits) + 1)}
    if speed is not None:
        others = limits.uses(healthy, unbarred=True) | couplings.coupling_readings(healthy)
        search = line_search(healthy, speed, HALF, others)
        emit_curves(scene, HEALTHY, search, HALF)
        emit_largest(scene, HEALTHY, search)
        if setup.torsion.limits:
            limits.emit_uses(scene, limit, [motion], search, axes, here=False)
        if "coupling use" in search.columns:
            couplings.emit_largest_uses(scene, f"{HEALTHY}/coupling", search, {})
        return
    emit_operating(scene, HEALTHY, motion)
    scene.emit(f"{HEALTHY}/mean_torque", healthy.drive.mean_torque(motion.speed).sum()[0])
    if setup.torsion.limits:
        limits.emit_uses(scene, limit, [motion], None, axes)
    if setup.shaft.couplings:
        couplings.emit_uses(scene, f"{HEALTHY}/coupling", [motion], {})
    known = readings_of(healthy)
    rings: list[str] = [name for name in ("heat", "travel") if name in known]
    found = {name: known[name].of(motion)[0] for name in rings}
    emit_readings(scene, f"{HEALTHY}/damper", healthy, found, {})
