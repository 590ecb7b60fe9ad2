"""Adapter: the slow run-up through the resonances of the mounts."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.body_run_up import body_sections
from vibecalc.isolation.adapters.common import (
    RunUpSection,
    RunUpSetup,
    emit_run_up_peaks,
    isolation_of,
    rows_of_results,
)
from vibecalc.isolation.at_mounts import deflected
from vibecalc.isolation.mount_results import OF_RUN_UP
from vibecalc.isolation.results import LeverForce, Masked, RunUpMaxima, SupportForce
from vibecalc.isolation.run_up import joined, run_up, run_up_peak
from vibecalc.isolation.run_up_maxima import Maxima, Range, all_maxima
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest_of
from vibecalc.numerics.bounded import Bounded

CURVES = (*paths_of(LeverForce, "run_up"), *paths_of(SupportForce, "run_up"))
MAXIMA = paths_of(RunUpMaxima)


def run_run_up(scene: Scene) -> None:
    """Emit the envelope over speed, its maxima with their speeds, and masked intervals."""
    parts = sections(scene)
    scene.cite(
        "peak over the cycle at each speed, refined at order resonances",
        "run-up",
        "docs/theory.md, quasi-steady run-up",
    )
    setup, given = parts[0].setup, [_given(part) for part in parts]
    if setup.travel is not None and scene.wants(*OF_RUN_UP):
        from vibecalc.isolation.adapters.mounts import emit_run_up_travel

        motions = [(part.setup.travel, *each[1:]) for part, each in zip(parts, given, strict=True)]
        peak = highest_of([run_up_peak(*each) for each in motions])
        emit_run_up_travel(scene, peak, _means(scene, parts))
    if not scene.wants(*CURVES, *MAXIMA):
        _emit_peaks(scene, setup, highest_of([run_up_peak(*each) for each in given]))
        return
    for warning in dict.fromkeys(text for p in parts for text in p.setup.idle(p.start, p.stop)):
        scene.warn(warning)
    passed = joined([run_up(*each) for each in given])
    _emit_peaks(scene, setup, passed.peak)
    share = isolation_of(scene).run_up_maxima
    if share is not None:
        _emit_maxima(scene, setup, all_maxima([Range(*each) for each in given], passed, share))
    curve = passed.curve[:, setup.row_of].T
    for group, rows, axes in rows_of_results(scene, setup.lever_rows):
        scene.emit_all(group(run_up=curve[rows]), {"speed": passed.speed, **axes})
    if passed.unresolved:
        scene.warn(
            f"the run-up has {passed.unresolved} intervals of speed that are coarser than asked "
            "for, since the number of speeds is capped; its maxima are not affected"
        )
    masked = passed.masked._replace(order=passed.masked.order * setup.step)
    if len(masked.low):
        centre = Bounded(masked.centre, masked.centre_error)
        found = Masked(masked.low, centre, masked.high, masked.order, masked.mode)
        scene.emit_all(found, {"masked": np.arange(1, len(masked.low) + 1)})
        _warn_masked(scene, len(masked.low), float(masked.centre[0]), float(masked.order[0]))


def sections(scene: Scene) -> tuple[RunUpSection, ...]:
    """The run-up in one part, or in several where the torque of the gas has kinks."""
    span = isolation_of(scene).run_up
    if span is None:
        raise ValueError("the case has no run-up")
    return body_sections(scene, span.start, span.stop)


def _means(scene: Scene, parts: Sequence[RunUpSection]) -> list[Bounded]:
    """Displacements (mounts, 3) by what is constant of the torque, along the range."""
    from vibecalc.response.adapters.loads import couple_about

    couples = [couple for part in parts for couple in part.setup.mean]
    system, axis = scene.handed_on["on_mounts"], scene.parts.crank_train.axis
    loads = [couple_about(axis, couple) for couple in couples if np.any(couple.value)]
    found = [deflected(system.resting, load).displacement for load in loads]
    none = np.zeros((len(system.mounts.names), 3))
    return found or [Bounded(none, none)]


def _given(part: RunUpSection) -> tuple[Any, ...]:
    setup = part.setup
    return (setup.rows, setup.harmonics, setup.resonances, part.start, part.stop, setup.shows)


def _emit_peaks(scene: Scene, setup: RunUpSetup, peak: RunUpPeak) -> None:
    peak = RunUpPeak._make(part[setup.row_of] for part in peak)
    emit_run_up_peaks(scene, peak, setup.lever_rows)


def _emit_maxima(scene: Scene, setup: RunUpSetup, maxima: Maxima) -> None:
    """Those of each support, in the order of the supports."""
    order = [
        (place, number)
        for place, row in enumerate(setup.row_of[setup.lever_rows :].tolist(), start=1)
        for number in np.flatnonzero(maxima.row == row).tolist()
    ]
    if not order:
        scene.warn("no force of a support has a maximum in the run-up: nothing shakes the body")
        return
    mount, which = np.array(order).T
    found = Maxima(*(part[which] for part in maxima))
    error = np.where(np.isfinite(found.value), found.error, 0.0)
    off = found.speed_error / found.speed * found.ratio + 1e-14
    results = RunUpMaxima(
        mount=mount.astype(float),
        force=Bounded(found.value, error),
        speed=Bounded(found.speed, found.speed_error),
        order=found.order * setup.step,
        order_share=Bounded(found.share, np.asarray(1e-12)),
        bending_order=found.bending * setup.step,
        mode=found.mode,
        frequency_ratio=Bounded(found.ratio, off),
        at_end=found.at_end,
    )
    scene.emit_all(results, {"maximum": np.arange(1, len(which) + 1)})


def _warn_masked(scene: Scene, count: int, speed: float, order: float) -> None:
    scene.warn(
        f"the run-up crosses {count} undamped resonance{'s' if count > 1 else ''}, the first at "
        f"{speed:.6g} rad/s with order {order:g}: the forces have no bound there, and "
        "isolation/masked lists the speeds left out; give the mounts damping or a loss factor"
    )
