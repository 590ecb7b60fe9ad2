"""Static load of the mounts, the stiffness in use, and how near they come to their stops."""

from collections.abc import Sequence

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.errors import in_rpm
from vibecalc.excitation.adapter import Orders
from vibecalc.isolation.adapters.common import extremes
from vibecalc.isolation.results import OfMounts
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.numerics.bounded import Bounded, maximum, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.equilibrium import Rest
from vibecalc.parts.mount_curves import Law
from vibecalc.parts.mounts import Mounts

#: of load over deflection
CURVE_POINTS = 121

# ----------------------------------------------------------------------------
# At rest, and over the orders.
# ----------------------------------------------------------------------------


def emit_mounts(scene: Scene, mounts: Mounts, orders: np.ndarray, speed: float) -> None:
    """Emit static load and stiffness of the mounts, at rest and at the frequency of orders."""
    names, rest, off = {"mount": mounts.names}, mounts.rest, mounts.relative_error
    if mounts.axis is None:
        raise ValueError("mounts under load, or over frequency, have an axis")
    if rest is not None and off is not None:
        scene.cite(
            "Newton's method on the energy of mounts and weight",
            "rest of the body on its mounts",
            "docs/theory_mounts.md",
        )
        along = np.einsum("ni,nij,nj->n", mounts.axis, mounts.stiffness, mounts.axis)
        stops = any(law.stop for law in mounts.laws)
        left = _to_stop(mounts.laws, rest.deflection.value, rest.deflection.value)
        error = np.where(np.isfinite(left), rest.deflection.error, 0.0)
        found = OfMounts(
            load=rest.load,
            deflection=rest.deflection,
            static_stiffness=rest.slope + rest.stop,
            stiffness=Bounded(along, off * along),
            clearance_at_rest=Bounded(left, error) if stops else None,
        )
        scene.emit_all(found, names)
        _emit_curves(scene, mounts, rest)
        for place in np.flatnonzero(rest.stop):
            scene.warn(
                f"mount {mounts.names[place]!r} stands on its stop at rest, "
                f"{-left[place]:.4g} m deep: its stiffness includes the stop"
            )
        _beyond_rows(scene, rest)
    if mounts.spectrum is not None:
        at = mounts.at(orders * speed)
        along, loss = (
            np.einsum("ni,mnij,nj->nm", mounts.axis, part, mounts.axis)
            for part in (at.stiffness, at.structural)
        )
        share = 8.0 * EPSILON + (0.0 if off is None else off[:, None])
        found = OfMounts(
            order_stiffness=Bounded(along, share * along),
            order_loss_factor=rounded(loss / along, 32),
        )
        scene.emit_all(found, {**names, "order": orders})
        scene.cite(
            "each order with the stiffness and loss factor of its frequency",
            "mounts over frequency",
            "docs/theory_mounts.md",
        )


def _emit_curves(scene: Scene, mounts: Mounts, rest: Rest) -> None:
    """Load of each mount over a range about its rest, its stops within, not beyond its rows."""
    if not scene.wants(*paths_of(OfMounts, "load_curve")):
        return
    laws = mounts.laws
    ends = [(law.down, -law.up) if law.stop else law.range for law in laws]
    shown = 1.1 * np.array(ends).ravel()
    seen = [0.0, *(1.6 * rest.deflection.value), *shown[np.isfinite(shown)]]
    low = max(min(seen), *(law.range[0] for law in laws))
    high = min(max(seen), *(law.range[1] for law in laws))
    at = np.linspace(low, max(high, low + 1e-9), CURVE_POINTS)
    load = np.array([[law.load(float(u)) for u in at] for law in laws])
    scene.emit_all(
        OfMounts(load_curve=rounded(load, 32)), {"mount": mounts.names, "deflection": at}
    )


def _beyond_rows(scene: Scene, rest: Rest) -> None:
    """Say where a mount carries more or less than its rows over the load have."""
    from vibecalc.parts.mounts import mount_entries

    given = scene.case.machine.mounts
    for one, load in zip(mount_entries(given) if given else (), rest.load.value, strict=True):
        rows = None if one.over_load is None else one.over_load.load
        if rows is not None and not rows[0] <= load <= rows[-1]:
            scene.warn(
                f"mount {one.name!r} carries {load:.6g} N at rest, beyond its rows of over_load "
                f"from {rows[0]:.6g} to {rows[-1]:.6g} N: the stiffness of the nearest row is used"
            )


# ----------------------------------------------------------------------------
# In motion: how near a mount comes to its stops.
# ----------------------------------------------------------------------------


def emit_travel(scene: Scene, mounts: Mounts, motion: Bounded, mean: Bounded, of: Orders) -> None:
    """Emit travel and clearance of mounts with stops, and say which meet one, or leave one.

    `motion` (mounts, 3, m) of the body at the mounts, about its rest moved by `mean` (mounts, 3).
    """
    rest, axis = mounts.rest, mounts.axis
    if rest is None or axis is None or not any(law.stop for law in mounts.laws):
        return
    swing = extremes(Bounded(np.zeros(()), np.zeros(())), _pressed(mounts, motion), of)
    travel = maximum(swing.highest, -swing.lowest)
    still = rest.deflection + _pressed(mounts, mean[..., None])[..., 0]
    (deepest, off), (highest, _) = still + swing.highest, still + swing.lowest
    left = _to_stop(mounts.laws, deepest, highest)
    clearance = Bounded(left, np.where(np.isfinite(left), off, 0.0))
    scene.emit_all(OfMounts(travel=travel, clearance=clearance), {"mount": mounts.names})
    for place, law in enumerate(mounts.laws):
        if not law.stop:
            continue
        name, u = mounts.names[place], float(rest.deflection.value[place])
        if not rest.stop[place] and left[place] < 0.0:
            end = "lower" if law.down - deepest[place] < highest[place] + law.up else "upper"
            scene.warn(
                f"mount {name!r} meets its {end} stop at speed: its motion of "
                f"{travel.value[place]:.4g} m goes {-left[place]:.4g} m beyond it; the response is "
                "computed without stops, in reality there are impacts"
            )
        elif rest.stop[place]:
            inner = law.down if u > 0.0 else -law.up
            if deepest[place] > inner > highest[place]:
                scene.warn(
                    f"mount {name!r} stands on its stop at rest and leaves it at speed: the "
                    "response assumes permanent contact"
                )


def _pressed(mounts: Mounts, motion: Bounded) -> Bounded:
    """Compression (mounts, m) of each mount along its axis by displacements (mounts, 3, m)."""
    assert mounts.axis is not None
    return -(motion * mounts.axis[..., None]).sum(-2)


def emit_run_up_travel(scene: Scene, peak: RunUpPeak, means: Sequence[Bounded]) -> None:
    """Emit the largest motion of mounts with stops at any speed, and say which meet one there.

    Of the `means` (mounts, 3), displacements by the mean torque at speeds of the range, that counts
    which leaves a mount the least; without any they are where the weight has put them.
    """
    mounts = scene.parts.mounts
    if mounts is None or mounts.rest is None:
        raise ValueError("mounts with stops have a rest")
    error = np.where(np.isfinite(peak.value), peak.error, 0.0)
    still = mounts.rest.deflection.value
    places = [still + _pressed(mounts, mean[..., None]).value[:, 0] for mean in means] or [still]
    at_rest = np.min([_to_stop(mounts.laws, u, u) for u in places], axis=0)
    none = np.full(len(at_rest), np.inf)
    left = np.subtract(at_rest, peak.value, out=none, where=np.isfinite(at_rest))
    off = np.where(np.isfinite(left), error + mounts.rest.deflection.error, 0.0)
    found = OfMounts(
        run_up_travel=Bounded(peak.value, error),
        run_up_travel_speed=Bounded(peak.speed, peak.speed_error),
        run_up_clearance=Bounded(left, off),
    )
    scene.emit_all(found, {"mount": mounts.names})
    met = np.flatnonzero((left < 0.0) & (at_rest >= 0.0))
    if len(met):
        worst = met[np.argmin(left[met])]
        others = f" and {len(met) - 1} more" if len(met) > 1 else ""
        scene.warn(
            f"in the run-up mount {mounts.names[worst]!r}{others} may meet a stop: at "
            f"{in_rpm(peak.speed[worst])} it moves by {1e3 * peak.value[worst]:.4g} mm, with "
            f"{1e3 * at_rest[worst]:.4g} mm to the nearer stop at rest; the forces are computed "
            "without stops"
        )


def _to_stop(laws: tuple[Law, ...], deepest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Distance (mounts,) to the nearer stop, infinite without one."""
    ends = [(law.down, law.up) if law.stop else (np.inf, np.inf) for law in laws]
    down, up = np.array(ends).T
    return np.asarray(np.minimum(down - deepest, highest + up))
