"""Adapter: the change from one operation to another and back, at once and by reversal."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS
from vibecalc.numerics.bounded import Bounded, rounded, stack
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response import results
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import forcing_of, mounted_body
from vibecalc.response.operations import at_phase
from vibecalc.response.results import BesidesChanges, Change, Instant, Reversal
from vibecalc.response.stage import names_of
from vibecalc.response.switching.follow import (
    Passages,
    Transient,
    follow,
    passages,
    slow_energy,
    worst_instant,
)
from vibecalc.response.switching.readings import KINETIC, POTENTIAL, steady_peaks
from vibecalc.response.switching.system import ModalLoads, ModalSystem, SpeedSegment, modal_loads
from vibecalc.response.system import in_modes

BUCKETS = 600
#: passages with less than this share of the energy of the strongest are not listed
WORTH_NAMING = 1e-4
#: damping between two modes, as a share of the strongest of a mode, from which a warning is given
WORTH_WARNING = 1e-6
#: a share of the largest peak of a reading that is not worth a word
_WORTH_A_WORD = 1e-6
#: readings of which peaks are given, with the columns that stand on one scale
READINGS = {
    "displacement": slice(0, 3),
    "rotation": slice(3, 6),
    "force on the ground": slice(6, 9),
    "couple on the ground": slice(9, 12),
    "kinetic energy": slice(12, 13),
    "potential energy": slice(13, 14),
}


def run_switching(scene: Scene) -> None:
    """Emit peaks, histories and settling of the four changes, and the resonances on the way."""
    response, speed = scene.case.response, scene.case.machine.speed
    assert response is not None and response.switching is not None
    options = response.switching
    labels = names_of(scene.case)["change"]
    scene.cite(
        "modal motion under a load of changing speed, quadrature of the exact propagator",
        "change between operations",
        "docs/theory_mounts.md; cf. Goloskokow and Filippow, Instationaere Schwingungen, 1971",
    )
    end = "turns the other way" if options.reverses else "turns on in the same sense"
    scene.cite(
        "linear run-down, standstill and linear run-up",
        f"change of operation: the crank {end} afterwards",
        "cf. Ong (2000), chapter 1",
    )
    system, loads = modes_and_loads(scene)
    _warn_of_coupling(scene)

    def followed(words: str, profiles: list[list[SpeedSegment]]) -> list[Transient]:
        transients = [
            follow(
                system, loads, profile, before=before, angle=options.crank_angle,
                buckets=BUCKETS, tolerance=options.settled,
            )
            for before, profile in enumerate(profiles)
        ]  # fmt: skip
        _warn_of_short_watch(scene, labels, words, options.after, transients)
        return transients

    if scene.wants(*paths_of(Instant)):
        profiles = [[SpeedSegment(options.after, speed, speed, after)] for after in (1, 0)]
        transients = followed("at once", profiles)

        @cache
        def worst() -> tuple[Bounded, Bounded]:
            found = [worst_instant(system, loads, k, 1 - k, speed) for k in (0, 1)]
            energy = stack([each for each, _ in found])
            # the peak is flat: where it is follows from half the digits of how high it is
            off = np.sqrt(energy.error / energy.value + EPSILON)
            return energy, Bounded(np.array([angle for _, angle in found]), off)

        _emit(
            scene, labels, Instant, transients, 0.0,
            worst_kinetic_energy_peak=lambda: worst()[0], worst_angle=lambda: worst()[1],
        )  # fmt: skip
    if scene.wants(*paths_of(Reversal), *paths_of(results.Passages)):
        back = -speed if options.reverses else speed
        profiles = [
            [
                SpeedSegment(options.run_down, speed, 0.0, before),
                *[SpeedSegment(options.stand, 0.0, 0.0, after)] * (options.stand > 0.0),
                SpeedSegment(options.run_up, 0.0, back, after),
                SpeedSegment(options.after, back, back, after),
            ]
            for before, after in ((0, 1), (1, 0))
        ]
        transients = followed("through rest", profiles)
        turning = np.array([each.history.speed[1:] for each in transients])

        def slow() -> Bounded:
            down, up = (
                stack([slow_energy(system, loads, k, top) for k in (0, 1)]) for top in (speed, back)
            )
            return stack([down, up[::-1]]).max()

        _emit(
            scene, labels, Reversal, transients, speed / min(options.run_down, options.run_up),
            speed=Bounded(turning, np.asarray(8.0 * EPSILON * speed)), slow_kinetic_energy=slow,
        )  # fmt: skip
        _emit_passages(scene, [passages(system, loads, profile) for profile in profiles])
    steady = stack([steady_peaks(system, loads, k, speed) for k in (0, 1)], axis=0)
    scene.emit_all(BesidesChanges(steady[:, KINETIC]), {"operation": options.between})


def modes_and_loads(scene: Scene) -> tuple[ModalSystem, ModalLoads]:
    """Modes of the body, and on them the loads of both operations of the change."""
    response = scene.case.response
    assert response is not None and response.switching is not None
    known = {operation.name: operation for operation in response.operations}
    found = operation_loads(scene, [known[name] for name in response.switching.between])
    forcing, body = forcing_of(scene), mounted_body(scene)
    each = at_phase(found)[:, 0]
    orders = np.arange(1, each.shape[1] + 1)
    # the errors count the guard orders, which stand for all that is dropped
    share = np.where(orders > forcing.retained, forcing.tail, 1.0)[:, None]
    ratio = body.damping_ratio().value
    system = ModalSystem(body.shapes.shape, body.shapes.natural_frequency, ratio)
    return system, modal_loads(system, orders, each * share, forcing.retained)


def _warn_of_coupling(scene: Scene) -> None:
    """Say so where damping leads from one mode to another, which the motion in time leaves out."""
    shapes = mounted_body(scene).shapes
    modal, root = in_modes(mounted_body(scene).matrices, shapes.shape), shapes.natural_frequency
    between = np.abs(modal.damping + modal.structural / np.sqrt(np.outer(root, root)))
    diagonal = float(np.max(np.diagonal(between)))
    np.fill_diagonal(between, 0.0)
    share = float(np.max(between)) / diagonal if diagonal > 0.0 else 0.0
    if share > WORTH_WARNING:
        scene.warn(
            f"the damping couples the modes: between two of them it reaches {100.0 * share:.2g} % "
            "of the strongest within one. In a change between operations only the damping of "
            "each mode is used"
        )


def _warn_of_short_watch(
    scene: Scene, labels: Sequence[str], words: str, after: float, transients: Sequence[Transient]
) -> None:
    """One sentence for the changes of which larger peaks may come after the time watched.

    `after` in s is that time from the last change of load, `words` say how the change is made.
    """
    parts = []
    for label, each in zip(labels, transients, strict=True):
        grows = _may_grow(each) if each.settled.value > after else []
        if grows:
            parts.append(
                f"{label} {words} settles in {each.settled.value:.3g} s; its "
                f"{', '.join(grows)} may later exceed the peak"
            )
    if parts:
        scene.warn(
            f"the body has not settled within {after:.6g} s after a change: "
            f"{'; '.join(parts)}. Give [response.switching] a longer after"
        )


def _may_grow(transient: Transient) -> list[str]:
    """`kinetic energy (up to 1.2 times)`: readings whose later bound is above their peak."""
    names = []
    for name, part in READINGS.items():
        (value, error), later = transient.peaks.height[part], transient.later[part]
        scale = float(np.max(value))
        beyond = later > value + error + _WORTH_A_WORD * scale
        if np.any(beyond):
            times = float(np.max(later[beyond])) / scale if scale > 0.0 else np.inf
            names.append(name + f" (up to {times:.3g} times)" * (1.001 <= times < np.inf))
    return names


def _emit(
    scene: Scene,
    labels: Sequence[str],
    group: type[Change],
    transients: Sequence[Transient],
    gain: float,
    **more: Any,
) -> None:
    """Peaks, settling, and for pictures highest and lowest samples with the error of a sample.

    `gain` is the largest acceleration of the crank, `more` are results of this way alone.
    """
    height = stack([each.peaks.height for each in transients], axis=0)
    place = stack([each.peaks.place for each in transients], axis=0)[:, KINETIC]
    speed = np.array([each.speed[KINETIC] for each in transients])
    low, high = (
        Bounded(np.swapaxes([getattr(each.history, end) for each in transients], 1, 2), error)
        for error in [height.error[..., None]]
        for end in ("low", "high")
    )
    found = group(
        **{
            f"{name}_peak": height[:, part]
            for name, part in zip(
                ("translation", "rotation", "ground_force", "ground_couple"),
                READINGS.values(), strict=False,
            )
        },
        kinetic_energy_peak=height[:, KINETIC],
        potential_energy_peak=height[:, POTENTIAL],
        peak_time=place,
        peak_speed=Bounded(speed, gain * place.error),
        settle_time=stack([each.settled for each in transients]),
        kinetic_energy_high=high[:, KINETIC],
        translation_high=high[:, :3],
        translation_low=low[:, :3],
        **more,
    )  # fmt: skip
    passed = transients[0].history.time[1:]
    times = dict.fromkeys(("instant_time", "reversal_time"), passed)
    scene.emit_all(found, {"change": labels, "direction": DIRECTIONS, **times})


def _emit_passages(scene: Scene, found: Sequence[Passages]) -> None:
    """The passages of both changes that are strong enough."""
    every = Passages(*(np.concatenate(part) for part in zip(*found, strict=True)))
    change = np.repeat([1, 2], [len(each.mode) for each in found])
    named = every.energy >= WORTH_NAMING * np.max(every.energy, initial=0.0)
    speed, time, haste = (
        rounded(part[named], 128) for part in (every.speed, every.time, every.haste)
    )
    rows = results.Passages(
        change[named], every.mode[named], every.order[named], speed, time, haste
    )
    scene.emit_all(rows, {"passage": np.arange(1, np.count_nonzero(named) + 1)})
