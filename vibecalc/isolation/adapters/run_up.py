"""Adapter: the slow run-up through the resonances of the mounts."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.results.described import Group, paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.errors import in_rpm
from vibecalc.excitation.adapter import Forcing, few_orders
from vibecalc.isolation.adapters.body_run_up import RunUpRows, run_up_rows, sections
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.at_mounts import deflected
from vibecalc.isolation.results import OF_RUN_UP, LeverForce, Masked, RunUpMaxima, SupportForce
from vibecalc.isolation.run_up import joined, run_up, run_up_peak
from vibecalc.isolation.run_up_maxima import Maxima, all_maxima
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest_of
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.adapters.loads import couple_about
from vibecalc.response.resonances import idle_warnings

if TYPE_CHECKING:
    from vibecalc.core.run.columns import PointsScene

CURVES = (*paths_of(LeverForce, "run_up"), *paths_of(SupportForce, "run_up"))
MAXIMA = paths_of(RunUpMaxima)


def run_run_up(scene: Scene) -> None:
    """Emit the envelope over speed, its maxima with their speeds, and masked intervals."""
    parts = sections(scene)
    system, step = parts[0].system, parts[0].step
    scene.cite(
        "peak over the cycle at each speed, refined at order resonances",
        "run-up",
        "docs/theory_mounts.md, quasi-steady run-up",
    )
    read, travel = run_up_rows(scene, system), system.travel()
    given = [part.given(read.rows, read.shows, True) for part in parts]
    if travel is not None and scene.wants(*OF_RUN_UP):
        from vibecalc.isolation.adapters.mounts import emit_run_up_travel

        motions = [run_up_peak(part.given(travel, system.shows())) for part in parts]
        couples = [couple for part in parts for couple in part.mean if np.any(couple.value)]
        loads = [couple_about(scene.parts.crank_train.axis, couple) for couple in couples]
        means = [deflected(system.resting, load).displacement for load in loads]
        emit_run_up_travel(scene, highest_of(motions), means)
    if not scene.wants(*CURVES, *MAXIMA):
        _emit_peaks(scene, read, highest_of([run_up_peak(each) for each in given]))
        return
    idle = (idle_warnings(p.resonances, p.order, p.start, p.stop) for p in parts)
    for warning in dict.fromkeys(text for texts in idle for text in texts):
        scene.warn(warning)
    passed = joined([run_up(each) for each in given])
    _emit_peaks(scene, read, passed.peak)
    share = isolation_of(scene).run_up_maxima
    if share is not None:
        _emit_maxima(scene, read, all_maxima(given, passed, share), step)
    curve = passed.curve[:, read.row_of].T
    for group, rows, axes in _results(scene, read):
        scene.emit_all(group(run_up=curve[rows]), {"speed": passed.speed, **axes})
    if passed.unresolved:
        scene.warn(
            f"the run-up has {passed.unresolved} speed intervals coarser than requested, "
            "as the number of speeds is limited; its maxima are not affected"
        )
    masked = passed.masked._replace(order=passed.masked.order * step)
    count = len(masked.low)
    if count:
        centre = Bounded(masked.centre, masked.centre_error)
        found = Masked(masked.low, centre, masked.high, masked.order, masked.mode)
        scene.emit_all(found, {"resonance_skipped": np.arange(1, count + 1)})
        scene.warn(
            f"the run-up crosses {count} undamped resonance{'s' if count > 1 else ''}, the first "
            f"at {in_rpm(masked.centre[0])} with order {masked.order[0]:g}: the forces are "
            "unbounded there; isolation/resonances_skipped lists the speeds left out; give the "
            "mounts damping or a loss factor"
        )


def run_up_of_points(scene: "PointsScene") -> None:
    """Emit the highest peak of each point of a sweep and its speed; points with a mode that nothing
    damps are run alone."""
    from vibecalc.isolation.run_up_poles import peaks_of_bodies

    span = isolation_of(scene).run_up
    if span is None:
        raise ValueError("the case has no run-up")
    forcing: Forcing = scene.handed_on["forcing"]
    system = scene.handed_on["on_mounts"]
    read, load = run_up_rows(scene, system), system.felt(forcing.per_speed_squared)
    few, tail = few_orders(forcing)
    peak, scene.alone = peaks_of_bodies(
        system, read.rows, load, tail, forcing.order, forcing.retained, few, span.start, span.stop,
        scene.alone,
    )  # fmt: skip
    _emit_peaks(scene, read, peak)


def _emit_peaks(scene: Scene, read: RunUpRows, peak: RunUpPeak) -> None:
    """Highest peaks (..., rows) and their speeds; one without bound has no error."""
    peak = RunUpPeak(*(part[..., read.row_of] for part in peak))
    error = np.where(np.isfinite(peak.value), peak.error, 0.0)
    value, speed = Bounded(peak.value, error), Bounded(peak.speed, peak.speed_error)
    for group, rows, axes in _results(scene, read):
        found = group(run_up_peak=value[..., rows], run_up_peak_speed=speed[..., rows])
        scene.emit_all(found, axes)


def _results(
    scene: Scene, read: RunUpRows
) -> Iterator[tuple[Callable[..., Group], slice | int, dict[str, tuple[str, ...]]]]:
    """Groups that the results of a run-up go into, those that each of them takes, and its axis."""
    if read.lever_rows:
        yield LeverForce, 0, {}
    names = scene.parts.mounts.names if scene.parts.mounts else ()
    yield SupportForce, slice(read.lever_rows, None), {"mount": names}


def _emit_maxima(scene: Scene, read: RunUpRows, maxima: Maxima, step: float) -> None:
    """Those of each support, in the order of the supports."""
    mount, which = np.nonzero(read.row_of[read.lever_rows :, None] == maxima.row)
    if not len(which):
        scene.warn("no mount force has a maximum in the run-up: the body is not excited")
        return
    found = Maxima(*(part[which] for part in maxima))
    error = np.where(np.isfinite(found.value), found.error, 0.0)
    off = found.speed_error / found.speed * found.ratio + 1e-14
    results = RunUpMaxima(
        mount=mount + 1.0,
        force=Bounded(found.value, error),
        speed=Bounded(found.speed, found.speed_error),
        order=found.order * step,
        order_share=Bounded(found.share, np.asarray(1e-12)),
        bending_order=found.bending * step,
        mode=found.mode,
        frequency_ratio=Bounded(found.ratio, off),
        at_end=found.at_end,
    )
    scene.emit_all(results, {"maximum": np.arange(1, len(which) + 1)})
