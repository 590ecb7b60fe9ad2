"""What the two isolation models share: peaks with what was left out, supports, run-up set-up."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.isolation.resonance import Resonances
from vibecalc.isolation.rounding import WithError
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing

if TYPE_CHECKING:
    from vibecalc.case.tables import Isolation

EPS = float(np.finfo(float).eps)
VERTICAL = ("vertical_peak", "excursion")


class RunUpSetup(NamedTuple):
    """What the run-up needs of a model: its rows, what it drops in their errors, its resonances.

    The first `lever_rows` rows are the couple over the lever, the others the mounts.
    """

    rows: HarmonicsAt
    resonances: Resonances
    shows: np.ndarray
    lever_rows: int
    idle: Callable[[float, float], tuple[str, ...]]


def isolation_of(scene: Scene) -> "Isolation":
    """The `[isolation]` table, which the plan has seen."""
    if scene.case.isolation is None:
        raise ValueError("the case has no [isolation]")
    return scene.case.isolation


def peak_with_tail(harmonics: WithError, forcing: Forcing) -> tuple[np.ndarray, np.ndarray]:
    """Peak over the cycle (...) of kept orders, and its error with the dropped ones in it."""
    kept = forcing.kept
    peak = cycle_peak(harmonics.value[..., :kept], forcing.orders[:kept])
    return peak.value, peak.error + _left_out(harmonics, forcing)


def emit_peak(scene: Scene, path: str, harmonics: WithError, forcing: Forcing) -> None:
    """Emit a peak over the cycle, unless nobody wants it."""
    if scene.wants(path):
        scene.emit(path, *peak_with_tail(harmonics, forcing))


def _left_out(harmonics: WithError, forcing: Forcing) -> np.ndarray:
    kept = forcing.kept
    rounding = harmonics.error[..., :kept].sum(-1)
    total: np.ndarray = rounding + forcing.tail * np.abs(harmonics.value[..., kept:]).sum(-1)
    return total


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
    displacement: WithError,
    force: WithError,
    up: np.ndarray,
    sag: WithError,
) -> None:
    """Motion and force of every support at operating speed.

    `displacement` and `force` are (mounts, directions, orders), `up` (directions,) picks the
    vertical component, `sag` (mounts,) is added to its peak.
    """
    kept = forcing.kept
    axes = {"mount": names, "direction": directions, "order": forcing.orders[:kept]}
    for group, harmonics in (("displacement", displacement), ("force", force)):
        scene.emit(
            f"isolation/support_{group}/steady_harmonics",
            harmonics.value[..., :kept],
            harmonics.error[..., :kept],
            axes,
        )
    if scene.wants("isolation/support_force/steady_peak"):
        _emit_largest_force(scene, forcing, names, force)
    if not scene.wants(*(f"isolation/support_displacement/{name}" for name in VERTICAL)):
        return
    vertical = WithError(
        np.einsum("mdn,d->mn", displacement.value, up),
        np.einsum("mdn,d->mn", displacement.error, np.abs(up)),
    )
    height, error = peak_with_tail(vertical, forcing)
    total = np.abs(sag.value) + height
    mounts = {"mount": names}
    scene.emit("isolation/support_displacement/vertical_peak", height, error, mounts)
    scene.emit(
        "isolation/support_displacement/excursion", total, sag.error + error + EPS * total, mounts
    )


def _emit_largest_force(
    scene: Scene, forcing: Forcing, names: Sequence[str], force: WithError
) -> None:
    """Largest length of the force vector of each support over the cycle."""
    if force.value.shape[1] == 1:
        one_way = WithError(force.value[:, 0], force.error[:, 0])
        largest, spread = peak_with_tail(one_way, forcing)
    else:
        kept = forcing.kept
        peak = vector_cycle_peak(force.value[..., :kept], forcing.orders[:kept])
        largest = peak.value
        spread = peak.error + np.sqrt(np.square(_left_out(force, forcing)).sum(-1))
    scene.emit("isolation/support_force/steady_peak", largest, spread, {"mount": names})
