"""Adapter: the change from one operation to another and back, at once and by reversal."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import LinearSystem, forcing_of, linear_system, ratios_of
from vibecalc.response.modes import Modes
from vibecalc.response.results import BesidesChanges, Change, Instant, Passages, Reversal
from vibecalc.response.switching.follow import Transient, follow, lasting_peaks, slow_peaks
from vibecalc.response.switching.instant import instantaneous, worst_instant
from vibecalc.response.switching.motion import passages
from vibecalc.response.switching.readings import columns, steady_peaks
from vibecalc.response.switching.system import (
    Loads,
    ModalSystem,
    SpeedSegment,
    modal_loads,
    steady_motion,
)
from vibecalc.response.tables import Operation, Switching

# ----------------------------------------------------------------------------
# Was the body watched for long enough after a change between operations?
# ----------------------------------------------------------------------------

#: readings of which peaks are given, with the columns that stand on one scale
READINGS = (
    ("displacement", slice(0, 3)),
    ("rotation", slice(3, 6)),
    ("force on the ground", slice(6, 9)),
    ("couple on the ground", slice(9, 12)),
    ("kinetic energy", slice(12, 13)),
    ("potential energy", slice(13, 14)),
)
#: a share of the largest peak of a reading that is not worth a word
_WORTH_A_WORD = 1e-6


def short_watch_warning(
    labels: Sequence[str], words: str, after: float, transients: Sequence[Transient]
) -> str | None:
    """One sentence for the changes of which larger peaks may come after the time watched.

    `after` in s is that time from the last change of load, `words` say how the change is made.
    """
    parts = []
    for label, each in zip(labels, transients, strict=True):
        grows = _may_grow(each) if each.settling.after > after else []
        if grows:
            parts.append(
                f"{label} {words} settles in {each.settling.after:.3g} s; its "
                f"{', '.join(grows)} may be larger later than the peak that is given"
            )
    if not parts:
        return None
    return (
        f"the {after:.6g} s watched after a change end before the body has settled: "
        f"{'; '.join(parts)}. Give [response.switching] a longer after"
    )


def _may_grow(transient: Transient) -> list[str]:
    """`kinetic energy (up to 1.2 times)`: readings whose later bound is above their peak."""
    peaks = lasting_peaks(transient)
    names = []
    for name, part in READINGS:
        value, later = peaks.value[part], transient.later[part]
        scale = float(np.max(value))
        beyond = later > value + peaks.error[part] + _WORTH_A_WORD * scale
        if np.any(beyond):
            times = float(np.max(later[beyond])) / scale if scale > 0.0 else np.inf
            bound = f" (up to {times:.3g} times)" if 1.001 <= times < np.inf else ""
            names.append(name + bound)
    return names


# ----------------------------------------------------------------------------
# Adapter: the change from one operation to another and back, at once and by reversal.
# ----------------------------------------------------------------------------

BUCKETS = 600
#: passages with less than this share of the energy of the strongest are not listed
WORTH_NAMING = 1e-4
#: damping between two modes, as a share of the strongest of a mode, from which a warning is given
WORTH_WARNING = 1e-6
COLUMNS = columns(6)


class _Study(NamedTuple):
    """What both ways of changing need; `names` of the two operations, in the order of loads."""

    system: ModalSystem
    loads: Loads
    options: Switching
    speed: float
    names: tuple[str, str]

    @property
    def changes(self) -> tuple[tuple[int, int], ...]:
        return ((0, 1), (1, 0))

    @property
    def labels(self) -> list[str]:
        return [f"{self.names[a]} to {self.names[b]}" for a, b in self.changes]


def run_switching(scene: Scene) -> None:
    """Emit peaks, histories and settling of the four changes, and the resonances on the way."""
    study = _study(scene)
    scene.cite(
        "modal motion under a load of changing speed, quadrature of the exact propagator",
        "change between operations",
        "docs/theory.md; cf. Goloskokow and Filippow, Instationaere Schwingungen, 1971",
    )
    end = "turns the other way" if study.options.reverses else "turns on in the same sense"
    scene.cite(
        "linear run-down, stand and linear run-up",
        f"the real change: the crank {end} afterwards",
        "cf. Ong (2000), chapter 1",
    )
    if scene.wants(*paths_of(Instant)):
        _emit_instant(scene, study)
    if scene.wants(*paths_of(Reversal), *paths_of(Passages)):
        _emit_reversal(scene, study)
    _emit_steady(scene, study)


def _study(scene: Scene) -> _Study:
    response = scene.case.response
    if response is None or response.switching is None:
        raise ValueError("the case has no [response.switching]")
    options = response.switching
    known = {operation.name: operation for operation in response.operations}
    chosen: list[Operation] = [known[name] for name in options.between]
    of_operations = operation_loads(scene, chosen)
    each = [
        shaking + residual[0]
        for shaking, residual in zip(of_operations.shaking, of_operations.residual, strict=True)
    ]
    forcing = forcing_of(scene)
    per_square = np.stack([load.value for load in each])
    # the errors count the guard orders, which stand for all that is dropped
    per_square[:, forcing.retained :] *= forcing.tail
    matrices, shapes = linear_system(scene)[:2]
    ratio = ratios_of(scene, LinearSystem(matrices, shapes)).value
    _warn_of_coupling(scene, matrices, shapes)
    system = ModalSystem(shapes.shape, shapes.natural_frequency, ratio)
    orders = np.arange(1, per_square.shape[1] + 1)
    loads = Loads(orders, per_square, np.zeros((2, 6)), forcing.retained)
    speed = scene.case.machine.speed
    return _Study(system, loads, options, speed, options.between)


def _warn_of_coupling(scene: Scene, matrices: Linear, shapes: Modes) -> None:
    """Say so where damping leads from one mode to another, which the motion in time leaves out."""
    shape, root = shapes.shape, np.sqrt(shapes.natural_frequency)
    between = shape.T @ matrices.damping @ shape
    between = np.abs(between + (shape.T @ matrices.structural @ shape) / np.outer(root, root))
    diagonal = float(np.max(np.diagonal(between)))
    np.fill_diagonal(between, 0.0)
    share = float(np.max(between)) / diagonal if diagonal > 0.0 else 0.0
    if share > WORTH_WARNING:
        scene.warn(
            f"the damping couples the modes: between two of them it reaches {100.0 * share:.2g} % "
            "of the strongest within one. While the machine changes between operations each mode "
            "keeps its own damping alone"
        )


def _emit_instant(scene: Scene, study: _Study) -> None:
    options = study.options
    transients = [
        instantaneous(
            study.system,
            study.loads,
            before,
            after,
            study.speed,
            angle=options.crank_angle,
            duration=options.after,
            buckets=BUCKETS,
            tolerance=options.settled,
        )
        for before, after in study.changes
    ]
    _emit_transients(scene, study, Instant, transients)
    if not scene.wants(*paths_of(Instant, "worst_kinetic_energy_peak", "worst_angle")):
        return
    worst = [worst_instant(study.system, study.loads, *pair, study.speed) for pair in study.changes]
    peak = _of_column(worst, COLUMNS.kinetic)
    angle = np.array([each.angle[COLUMNS.kinetic] for each in worst])
    # the peak is flat: where it is follows from half the digits of how high it is
    found = Instant(
        worst_angle=Bounded(angle, np.sqrt(peak.error / peak.value + EPSILON)),
        worst_kinetic_energy_peak=peak,
    )
    scene.emit_all(found, {"change": study.labels})


def _emit_reversal(scene: Scene, study: _Study) -> None:
    options, speed = study.options, study.speed
    sense = -1.0 if options.reverses else 1.0
    profiles, transients = [], []
    for before, after in study.changes:
        profile = [SpeedSegment(options.run_down, speed, 0.0, before)]
        if options.stand > 0.0:
            profile.append(SpeedSegment(options.stand, 0.0, 0.0, after))
        profile.append(SpeedSegment(options.run_up, 0.0, sense * speed, after))
        profile.append(SpeedSegment(options.after, sense * speed, sense * speed, after))
        profiles.append(profile)
        transients.append(
            follow(
                study.system,
                study.loads,
                profile,
                angle=options.crank_angle,
                before=before,
                buckets=BUCKETS,
                tolerance=options.settled,
            )
        )
    _emit_transients(scene, study, Reversal, transients)

    def slow() -> Bounded:
        peaks = [slow_peaks(study.system, study.loads, profile) for profile in profiles]
        return _of_column(peaks, COLUMNS.kinetic)

    history = [each.history for each in transients]
    turning = np.array([each.speed[1:] for each in history])
    found = Reversal(
        speed=Bounded(turning, np.asarray(8.0 * EPSILON * speed)), slow_kinetic_energy=slow
    )
    scene.emit_all(found, {"change": study.labels, "reversal_time": history[0].time[1:]})
    _emit_passages(scene, study, profiles)


def _of_column(peaks: Sequence[Any], column: int | slice) -> Bounded:
    """A reading of each change, with its error."""
    value, error = (
        np.array([getattr(one, name)[column] for one in peaks]) for name in ("value", "error")
    )
    return Bounded(value, error)


def _emit_passages(scene: Scene, study: _Study, profiles: list[list[SpeedSegment]]) -> None:
    rows = [
        (number, met)
        for number, profile in enumerate(profiles, start=1)
        for met in passages(study.system, study.loads, profile)
    ]
    strongest = max((met.slow_energy for _, met in rows), default=0.0)
    rows = [row for row in rows if row[1].slow_energy >= WORTH_NAMING * strongest]

    def every(name: str) -> np.ndarray:
        return np.array([getattr(met, name) for _, met in rows])

    found = Passages(
        change=np.array([number for number, _ in rows]),
        mode=every("mode"),
        order=every("order"),
        speed=rounded(every("speed"), 128),
        time=rounded(every("time"), 128),
        haste=rounded(every("haste"), 128),
    )
    scene.emit_all(found, {"passage": np.arange(1, len(rows) + 1)})


def _emit_steady(scene: Scene, study: _Study) -> None:
    modal = modal_loads(study.system, study.loads)
    peaks = [
        steady_peaks(
            study.system,
            steady_motion(study.system, modal, which, study.speed),
            modal.orders,
            study.speed,
        )
        for which in (0, 1)
    ]
    energy = _of_column(peaks, COLUMNS.kinetic)
    scene.emit_all(BesidesChanges(steady_energy=energy), {"operation": study.names})


def _emit_transients(
    scene: Scene, study: _Study, group: type[Change], transients: list[Transient]
) -> None:
    """Peaks, settling, and for pictures highest and lowest samples with the error of a sample."""
    options, kinetic = study.options, COLUMNS.kinetic
    at_once = group is Instant
    words = "at once" if at_once else "through rest"
    short = short_watch_warning(study.labels, words, options.after, transients)
    if short is not None:
        scene.warn(short)
    peaks = [lasting_peaks(each) for each in transients]
    time, speed, off = (
        np.array([getattr(each, name)[kinetic] for each in peaks])
        for name in ("time", "speed", "time_error")
    )
    # at once, the crank keeps its speed
    slope = 0.0 if at_once else study.speed / min(options.run_down, options.run_up)
    error = np.array([each.peaks.error for each in transients])[..., None]
    high, low = (
        np.swapaxes([getattr(each.history, name) for each in transients], -1, -2)
        for name in ("high", "low")
    )
    found = group(
        translation_peak=_of_column(peaks, slice(0, 3)),
        rotation_peak=_of_column(peaks, slice(3, 6)),
        ground_force_peak=_of_column(peaks, slice(6, 9)),
        ground_couple_peak=_of_column(peaks, slice(9, 12)),
        kinetic_energy_peak=_of_column(peaks, kinetic),
        potential_energy_peak=_of_column(peaks, COLUMNS.potential),
        peak_time=Bounded(time, off),
        peak_speed=Bounded(speed, slope * off),
        settle_time=Bounded(
            np.array([each.settling.after for each in transients]),
            np.array([each.settling.error for each in transients]),
        ),
        kinetic_energy_high=Bounded(high[:, kinetic], error[:, kinetic]),
        translation_high=Bounded(high[:, :3], error[:, :3]),
        translation_low=Bounded(low[:, :3], error[:, :3]),
    )
    passed = transients[0].history.time[1:]
    axes = {
        "change": study.labels,
        "direction": DIRECTIONS,
        "instant_time": passed,
        "reversal_time": passed,
    }
    scene.emit_all(found, axes)
