"""What the two isolation models share: peaks with what was left out, supports, run-up set-up."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.described import Group
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Orders, left_out
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.results import LeverForce, SupportForce
from vibecalc.isolation.rows import HarmonicsAt, Readout
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.synthesis import synthesis
from vibecalc.response.resonances import Resonances

if TYPE_CHECKING:
    from vibecalc.isolation.tables import Isolation


class KeptRows(NamedTuple):
    """Rows of the orders kept, and those of some orders left out, `factor` times for all of them.

    `beyond` (n,) are the orders left out.
    """

    rows: HarmonicsAt
    left_out: HarmonicsAt
    factor: np.ndarray | float
    beyond: np.ndarray


class RunUpSetup(NamedTuple):
    """What the run-up needs of a model: its rows, what it drops in their errors, its resonances.

    The orders are the whole numbers `harmonics` times `step`, which is 1/2 where a cycle is two
    turns; the frequencies of `resonances` are divided by it. `row_of` tells which of the rows each
    result reads: of the first `lever_rows` results, which are the couple over the lever, then of
    the mounts. `rows_of` makes rows of any readout of the coordinates of the `system`, of motions.
    `travel` has the motion of each mount along its axis, where mounts have stops;
    `mean` the constant couples about the crankshaft at both ends of the range.
    """

    rows: HarmonicsAt
    harmonics: np.ndarray
    step: float
    resonances: Resonances
    shows: np.ndarray
    row_of: np.ndarray
    lever_rows: int
    idle: Callable[[float, float], tuple[str, ...]]
    system: OnMounts
    rows_of: Callable[[Readout], KeptRows]
    travel: HarmonicsAt | None = None
    mean: tuple[Bounded, ...] = ()


class RunUpSection(NamedTuple):
    """A part of a run-up, between two speeds in rad/s."""

    setup: RunUpSetup
    start: float
    stop: float


def isolation_of(scene: Scene) -> "Isolation":
    """The `[isolation]` table, which the plan has seen."""
    if scene.case.isolation is None:
        raise ValueError("the case has no [isolation]")
    return scene.case.isolation


class Extremes(NamedTuple):
    """Highest and lowest value (...) over the cycle of something constant and what alternates."""

    highest: Bounded
    lowest: Bounded


def extremes(constant: Bounded, harmonics: Bounded, of: Orders) -> Extremes:
    """Of a constant (...) and harmonics (..., orders), what is left out in their errors."""
    used = of.retained
    total = synthesis(of.order[:used], harmonics.value[..., :used])
    error = total.error + np.add(*left_out(harmonics, of))
    return Extremes(
        constant + Bounded(total.highest, error), constant + Bounded(total.lowest, error)
    )


def emit_run_up_peaks(scene: Scene, peak: RunUpPeak, lever_rows: int) -> None:
    """Highest peaks (..., results) and their speeds: of the couple over the lever, of the mounts.

    A peak without bound has no error.
    """
    error = np.where(np.isfinite(peak.value), peak.error, 0.0)
    value, speed = Bounded(peak.value, error), Bounded(peak.speed, peak.speed_error)
    for group, rows, axes in rows_of_results(scene, lever_rows):
        found = group(run_up_peak=value[..., rows], run_up_peak_speed=speed[..., rows])
        scene.emit_all(found, axes)


def rows_of_results(
    scene: Scene, lever_rows: int
) -> Iterator[tuple[Callable[..., Group], slice | int, dict[str, tuple[str, ...]]]]:
    """Groups that the results of a run-up go into, those that each of them takes, and its axis."""
    if lever_rows:
        yield LeverForce, 0, {}
    names = scene.parts.mounts.names if scene.parts.mounts else ()
    yield SupportForce, slice(lever_rows, None), {"mount": names}
