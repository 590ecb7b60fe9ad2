"""What the two isolation models share: peaks with what was left out, supports, run-up set-up."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import size_of_terms
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.resonances import Resonances

if TYPE_CHECKING:
    from vibecalc.isolation.tables import Isolation

LARGEST = "isolation/support_force/steady_peak"
HEIGHTS = (
    "isolation/support_displacement/vertical_peak",
    "isolation/support_displacement/excursion",
)


class RunUpSetup(NamedTuple):
    """What the run-up needs of a model: its rows, what it drops in their errors, its resonances.

    The orders are the whole numbers `harmonics` times `step`, which is 1/2 where a cycle is two
    turns; the frequencies of `resonances` are divided by it. `row_of` tells which of the rows each
    result reads: of the first `lever_rows` results, which are the couple over the lever, then of
    the mounts.
    """

    rows: HarmonicsAt
    harmonics: np.ndarray
    step: float
    resonances: Resonances
    shows: np.ndarray
    row_of: np.ndarray
    lever_rows: int
    idle: Callable[[float, float], tuple[str, ...]]


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


class CyclePeak(NamedTuple):
    """Peak over the cycle (...) of kept orders, its error with the dropped ones in it, its terms.

    Without the dropped orders the error is rounding, which tells the size of the terms.
    """

    value: np.ndarray
    error: np.ndarray
    terms: float


def peak_with_tail(harmonics: Bounded, forcing: Forcing) -> CyclePeak:
    """Peaks of harmonics (..., orders)."""
    used = forcing.retained
    peak = cycle_peak(harmonics.value[..., :used], forcing.orders[:used])
    rounding, dropped = _left_out(harmonics, forcing)
    rounding = peak.error + rounding
    return CyclePeak(peak.value, rounding + dropped, size_of_terms(rounding))


def emit_peak(scene: Scene, path: str, harmonics: Bounded, forcing: Forcing) -> None:
    """Emit a peak over the cycle, unless nobody wants it."""
    if scene.wants(path):
        peak = peak_with_tail(harmonics, forcing)
        scene.emit(path, peak.value, peak.error, terms=peak.terms)


def _left_out(harmonics: Bounded, forcing: Forcing) -> tuple[np.ndarray, np.ndarray]:
    """Rounding of the kept orders and size of the dropped ones, summed."""
    used = forcing.retained
    dropped: np.ndarray = forcing.tail * np.abs(harmonics.value[..., used:]).sum(-1)
    return harmonics.error[..., :used].sum(-1), dropped


def emit_static(
    scene: Scene,
    names: Sequence[str],
    sag: np.ndarray,
    sag_error: np.ndarray,
    share: np.ndarray,
    share_error: np.ndarray,
) -> None:
    """Sag and share of the weight of every mount."""
    axes = {"mount": names}
    scene.emit("isolation/support_displacement/sag", sag, sag_error, axes)
    scene.emit("isolation/support_force/static", share, share_error, axes)


def emit_support_motion(
    scene: Scene,
    forcing: Forcing,
    names: Sequence[str],
    directions: Sequence[str],
    displacement: Bounded,
    force: Bounded,
    up: np.ndarray,
    sag: Bounded,
) -> None:
    """Motion and force of every support at operating speed.

    `displacement` and `force` are (mounts, directions, orders), `up` (directions,) picks the
    vertical component, `sag` (mounts,) is added to its peak.
    """
    used = forcing.retained
    axes = {"mount": names, "direction": directions, "order": forcing.orders[:used]}
    for group, harmonics in (("displacement", displacement), ("force", force)):
        scene.emit(
            f"isolation/support_{group}/steady_harmonics",
            harmonics.value[..., :used],
            harmonics.error[..., :used],
            axes,
            terms=size_of_terms(harmonics.error[..., :used]),
        )
    rows = {}
    if scene.wants(*HEIGHTS):
        rows["height"] = Bounded(
            np.einsum("mdn,d->mn", displacement.value, up),
            np.einsum("mdn,d->mn", displacement.error, np.abs(up)),
        )
    if scene.wants(LARGEST) and len(directions) == 1:
        rows["force"] = Bounded(force.value[:, 0], force.error[:, 0])
    peaks = _peaks_together(rows, forcing)
    if scene.wants(LARGEST):
        largest = peaks["force"] if "force" in peaks else _vector_peak(force, forcing)
        scene.emit(LARGEST, largest.value, largest.error, {"mount": names}, terms=largest.terms)
    if scene.wants(*HEIGHTS):
        height, error, terms = peaks["height"]
        total = np.abs(sag.value) + height
        mounts = {"mount": names}
        scene.emit(HEIGHTS[0], height, error, mounts, terms=terms)
        scene.emit(HEIGHTS[1], total, sag.error + error + EPSILON * total, mounts)


def _peaks_together(rows: dict[str, Bounded], forcing: Forcing) -> dict[str, CyclePeak]:
    """Peaks (mounts,) of rows (mounts, orders): in one call, which costs as one does."""
    if not rows:
        return {}
    stacked = stack(list(rows.values()), axis=0)
    peaks = peak_with_tail(stacked, forcing)
    return {
        name: CyclePeak(peaks.value[i], peaks.error[i], peaks.terms) for i, name in enumerate(rows)
    }


def _vector_peak(force: Bounded, forcing: Forcing) -> CyclePeak:
    """Largest length (mounts,) of force vectors (mounts, directions, orders)."""
    used = forcing.retained
    peak = vector_cycle_peak(force.value[..., :used], forcing.orders[:used])
    rounding, dropped = _left_out(force, forcing)
    whole = peak.error + np.linalg.norm(rounding + dropped, axis=-1)
    return CyclePeak(
        peak.value, whole, size_of_terms(peak.error + np.linalg.norm(rounding, axis=-1))
    )
