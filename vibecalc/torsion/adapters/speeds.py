"""A shaft line over a range of crank speeds: sections, dampers, gears."""

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray, distinct, first_of_largest
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.critical import (
    MeetingOrder,
    UndampedResonances,
    emit_separation,
    meeting,
)
from vibecalc.torsion.adapters.largest_alone import HEAT, highest_torques, little_asked
from vibecalc.torsion.adapters.modes import emit_campbell
from vibecalc.torsion.adapters.motion import TORQUE, Motion, readings_of
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.steady import (
    bare_setup,
    emit_bare,
    emit_curves,
    emit_damping_curves,
    emit_healthy,
    emit_largest,
    line_search,
    setup_of,
)
from vibecalc.torsion.critical_speeds import (
    SLOPE_STEP,
    Maxima,
    barred_ranges,
    by_machine,
    peaks,
    slopes,
)
from vibecalc.torsion.results import FOLLOWED, ROOT

# ----------------------------------------------------------------------------
# Adapter: a shaft line over a range of crank speeds, with its dampers and without.
# ----------------------------------------------------------------------------

SPEEDS = f"{ROOT}/speeds"
PEAK = tuple(
    f"{ROOT}/peak/{name}" for name in ("speed", "torque_half_range", "section", "mode", "order")
)
SEPARATION = below(f"{ROOT}/separation/range/")
#: what has to be examined once more where the largest values are
THERE = tuple(f"{ROOT}/largest/{name}" for name in ("mode", "order"))
HAMMERING = tuple(f"{ROOT}/hammering/{name}" for name in ("from", "to", "gear"))
LEAST = "gear_minimum_torque"


def run_torsion_speeds(scene: Scene) -> None:
    """Emit curves, largest values, peaks, limits, the line without dampers or misfire."""
    setup = setup_of(scene)
    assert setup.torsion.speeds is not None
    speed = line_speeds(setup.torsion.speeds)
    emit_campbell(scene, setup, speed)
    if scene.wants(*SEPARATION):
        emit_separation(scene, setup, "range", speed[0], speed[-1])
    if little_asked(scene, setup):
        bare = bare_setup(setup) if setup.shaft.dampers else None
        search = highest_torques(scene, setup, bare, speed)
    else:
        names = [name for name in readings_of(setup) if _wanted(scene, name)]
        others = limits.uses(setup) | couplings.coupling_readings(setup, couplings.READ)
        search = line_search(setup, speed, [*dict.fromkeys((TORQUE, *names))], others)
        _emit_range(scene, setup, search)
    _masked(scene, search.undamped[0])
    if scene.wanted is not None and scene.wanted <= {HEAT}:
        return
    torque = emit_largest(scene, ROOT, search)
    if scene.wants(*THERE):
        top, axes = search.found, {"section": setup.shaft.section_names}
        met = _meeting(setup, speed, top.speed[: len(setup.shaft.section_names)])
        scene.emit(THERE[0], met.mode, 0.0, axes)
        scene.emit(THERE[1], met.order, 0.0, axes)
    if setup.shaft.dampers:
        emit_bare(scene, setup, speed, torque)
    if setup.torsion.misfire:
        emit_healthy(scene, setup, speed)


def _wanted(scene: Scene, name: str) -> bool:
    """Whether anything is asked for that follows from a reading."""
    paths = [f"{SPEEDS}/{name}", f"{ROOT}/largest/{name}", f"{ROOT}/largest/{name}_speed"]
    return scene.wants(*paths, *((f"{SPEEDS}/gear_hammers", *HAMMERING) if name == LEAST else ()))


def _emit_range(scene: Scene, setup: Setup, search: Search) -> None:
    """All that is followed over the speeds."""
    speed, place, axes = search.speed, f"{ROOT}/largest", {"speed": search.speed}
    known = readings_of(setup)
    emit_curves(scene, ROOT, search, list(known))
    if LEAST in search.columns:
        least = search.bounded_curves(LEAST)
        hammers = (least.value < -least.error).astype(np.int64).T
        scene.emit(f"{SPEEDS}/gear_hammers", hammers, 0.0, {"gear": known[LEAST].names, **axes})
    if setup.drive.firing.names:
        scene.emit(f"{SPEEDS}/mean_torque", setup.drive.mean_torque(speed).sum(), axes=axes)
    if setup.model.over_speed is not None:
        emit_damping_curves(scene, setup, speed)
    for name in FOLLOWED:
        if name in search.columns:
            top, named = search.top(name).of(0), {known[name].axis: known[name].names}
            scene.emit(f"{place}/{name}", top.value, axes=named)
            scene.emit(f"{place}/{name}_speed", top.speed, axes=named)
    if setup.shaft.gears and scene.wants(*HAMMERING):
        _emit_hammering(scene, setup, search)
    if scene.wants(*PEAK):
        _peaks(scene, setup, search)
    if setup.torsion.limits:
        limits.emit_limits(scene, setup, search, speed)
    if setup.shaft.couplings:
        couplings.emit_coupling_speeds(scene, setup, search)


def _masked(scene: Scene, undamped: UndampedResonances) -> None:
    axes = {"resonance_skipped": np.arange(1, len(undamped.speed) + 1)}
    scene.emit(f"{ROOT}/resonances_skipped/from", undamped.low, undamped.error, axes)
    scene.emit(f"{ROOT}/resonances_skipped/to", undamped.high, undamped.error, axes)
    scene.emit(f"{ROOT}/resonances_skipped/mode", undamped.mode, 0.0, axes)
    scene.emit(f"{ROOT}/resonances_skipped/order", undamped.order, 0.0, axes)
    if count := len(undamped.speed):
        plural = "s" * (count > 1)
        scene.warn(
            f"undamped resonance{plural} at {count} speed{plural} of the range (masked): curves "
            "unbounded there"
        )


def _peaks(scene: Scene, setup: Setup, search: Search) -> None:
    """Maxima of the section of the largest torque, and of that of the largest stress."""
    columns, modulus = search.columns[TORQUE], setup.shaft.section_modulus
    torque = search.top(TORQUE).value.value[0]
    torque = np.where(np.isfinite(torque), torque, 0.0)
    stress = np.divide(torque, modulus, out=np.zeros_like(torque), where=modulus > 0.0)
    loads = [torque, stress] if np.any(stress > 0.0) else [torque]
    chosen = [first_of_largest(one) for one in loads]
    curve, grid = search.samples[search.clear][:, columns], search.grid[search.clear]
    parts = [
        peaks(search.value, curve, grid, section, search.undamped_at)
        for section in dict.fromkeys(chosen)
    ]
    high = Maxima(*(np.concatenate(part) for part in zip(*parts, strict=True)))
    met = _meeting(setup, search.speed, high.speed, high.section)
    axes = {"peak": np.arange(1, len(high.speed) + 1)}
    at, back = np.unique(by_machine(0, high.speed), return_inverse=True)
    rounding = search.errors(at, [TORQUE])[TORQUE][back, high.section]
    scene.emit(PEAK[0], high.speed, high.speed_error, axes)
    scene.emit(PEAK[1], high.value, rounding + high.value_error, axes)
    scene.emit(PEAK[2], high.section + 1, 0.0, axes)
    scene.emit(PEAK[3], met.mode, 0.0, axes)
    scene.emit(PEAK[4], met.order, 0.0, axes)


def _meeting(
    setup: Setup, speed: FloatArray, at: FloatArray, section: IntArray | None = None
) -> MeetingOrder:
    """What resonates in sections at the speeds of their maxima, of a range; nothing at its ends."""
    section = np.arange(len(at)) if section is None else section
    return meeting(setup, at, section, (at <= speed[0]) | (at >= speed[-1]))


# ----------------------------------------------------------------------------
# Adapter: ranges of speeds in which the teeth of a gear hammer.
# ----------------------------------------------------------------------------


def _emit_hammering(scene: Scene, setup: Setup, search: Search) -> None:
    """Where the torque of a gear changes its sign within the cycle, between all known speeds."""
    least, off = readings_of(setup)[LEAST], search.uncertainty(LEAST)
    near = search.found.speed[np.isfinite(search.found.value)]
    every = distinct(np.concatenate([search.grid, near, search.undamped_at]))
    rows = []
    for gear, error in enumerate(off.tolist()):

        def reversed_by(at: FloatArray, gear: int = gear, error: float = error) -> FloatArray:
            return np.asarray(-error - least.of(Motion(setup, at)).value[:, gear])

        barred = barred_ranges(reversed_by, every)
        for at in np.stack([barred.start, barred.end], axis=1):
            slope = slopes(reversed_by, at, every[0], every[-1])
            # an end of the speeds that were asked for, or of the sense of the mean, is exact
            near_it = np.abs(reversed_by(at)) < slope * SLOPE_STEP * at
            crosses = np.isfinite(slope) & (slope > 0.0) & near_it
            moved = np.where(crosses, 4.0 * error / np.where(crosses, slope, 1.0), 0.0)
            rows.append((*at, float(np.max(moved + 8.0 * EPSILON * at)), gear + 1))
    low, high, uncertainty, number = np.array(rows).reshape(-1, 4).T
    axes = {"hammering": np.arange(1, len(rows) + 1)}
    scene.emit(HAMMERING[0], low, uncertainty, axes)
    scene.emit(HAMMERING[1], high, uncertainty, axes)
    scene.emit(HAMMERING[2], number.astype(np.int64), 0.0, axes)
