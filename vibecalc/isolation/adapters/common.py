"""What the two isolation models share: peaks with what was left out, supports, run-up set-up."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Orders, left_out
from vibecalc.excitation.inertia_forces import size_of_terms
from vibecalc.isolation.rows import HarmonicsAt, Readout
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.numerics.bounded import Bounded, maximum
from vibecalc.numerics.synthesis import synthesis
from vibecalc.response.resonances import Resonances

if TYPE_CHECKING:
    from vibecalc.isolation.tables import Isolation

#: what speeds other than that of the machine are handed on for
OF_RUN_UP = tuple(
    path
    for path in CATALOGUE
    if path.startswith(("isolation/", "points/"))
    and any(word in path for word in ("run_up", "masked", "torque_reaction"))
)
LARGEST = "isolation/support_force/steady_peak"
VERTICAL = "isolation/support_displacement/vertical_peak"
#: with what is constant, the weight and the mean torque
EXCURSION = "isolation/support_displacement/excursion"
LOADS = ("isolation/support_force/largest_load", "isolation/support_force/minimum_load")


class KeptRows(NamedTuple):
    """Rows of the orders kept, and those of some orders left out, `factor` times for all of them.

    `beyond` (n,) are the orders left out.
    """

    rows: HarmonicsAt
    left_out: HarmonicsAt
    factor: np.ndarray | float
    beyond: np.ndarray


class OfBody(NamedTuple):
    """How other readings of the body in its run-up are had.

    `rows` makes those of any readout of its coordinates (f,), of motions. `motion` (6, f) takes
    these to the motion of the reference point, and `modes` (6, modes) are its motions in the modes.
    """

    rows: Callable[[Readout], KeptRows]
    motion: np.ndarray
    modes: np.ndarray


class RunUpSetup(NamedTuple):
    """What the run-up needs of a model: its rows, what it drops in their errors, its resonances.

    The orders are the whole numbers `harmonics` times `step`, which is 1/2 where a cycle is two
    turns; the frequencies of `resonances` are divided by it. `row_of` tells which of the rows each
    result reads: of the first `lever_rows` results, which are the couple over the lever, then of
    the mounts. `travel` has the motion of each mount along its axis, where mounts have stops;
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
    of_body: OfBody
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


def emit_static(
    scene: Scene, names: Sequence[str], sag: Bounded, share: Bounded
) -> tuple[Bounded, Bounded]:
    """Emit sag and share of the weight of every mount, and return both."""
    scene.emit("isolation/support_displacement/sag", sag, axes={"mount": names})
    scene.emit("isolation/support_force/static", share, axes={"mount": names})
    return sag, share


def emit_support_motion(
    scene: Scene,
    of: Orders,
    names: Sequence[str],
    directions: Sequence[str],
    displacement: Bounded,
    force: Bounded,
) -> None:
    """Motion and force (..., mounts, directions, orders) of every support at operating speed."""
    used = of.retained
    axes = {"mount": names, "direction": directions, "order": of.order[:used]}
    for group, harmonics in (("displacement", displacement), ("force", force)):
        kept, terms = harmonics[..., :used], size_of_terms(harmonics.error[..., :used])
        path = f"isolation/support_{group}/steady_harmonics"
        scene.emit(path, kept, axes=axes, terms=terms)


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


def emit_with_constant(
    scene: Scene, names: Sequence[str], down: Bounded, load: Bounded, at_rest: Bounded,
    weight: Bounded, of: Orders,
) -> None:  # fmt: skip
    """Largest deflection of every support and the extremes of its load over the cycle.

    `down` and `load` (..., mounts, orders) are positive downwards; `at_rest` and `weight`
    (..., mounts) are deflection and load by what is constant.
    """
    mounts = {"mount": names}
    if scene.wants(EXCURSION):
        both = extremes(at_rest, down, of)
        scene.emit(EXCURSION, maximum(abs(both.highest), abs(both.lowest)), axes=mounts)
    if scene.wants(*LOADS):
        for path, one in zip(LOADS, extremes(weight, load, of), strict=True):
            scene.emit(path, one, axes=mounts)


def emit_run_up_peaks(scene: Scene, peak: RunUpPeak, lever_rows: int) -> None:
    """Highest peaks (..., results) and their speeds: of the couple over the lever, of the mounts.

    A peak without bound has no error.
    """
    error = np.where(np.isfinite(peak.value), peak.error, 0.0)
    for path, rows, mount in rows_of_results(scene, lever_rows):
        place = (..., rows if mount else 0)
        scene.emit(f"{path}/run_up_peak", peak.value[place], error[place], mount)
        scene.emit(f"{path}/run_up_peak_speed", peak.speed[place], peak.speed_error[place], mount)


def rows_of_results(
    scene: Scene, lever_rows: int
) -> Iterator[tuple[str, slice, dict[str, tuple[str, ...]]]]:
    """Where the results of a run-up go, those that each of them takes, and its axis."""
    if lever_rows:
        yield "isolation/lever_force", slice(0, 1), {}
    names = scene.parts.mounts.names if scene.parts.mounts else ()
    yield "isolation/support_force", slice(lever_rows, None), {"mount": names}
