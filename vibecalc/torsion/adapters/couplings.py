"""What the couplings of a shaft line bear, next to what their makers permit."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, bounded, concatenate, reshaped, stack, where
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray, distinct
from vibecalc.torsion.adapters.curves import (
    ROWS,
    OrderSolution,
    bounded_orders,
    mean_torques,
    section_heat,
    solved,
)
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.adapters.signals import some_rows, some_speeds
from vibecalc.torsion.coupling_results import COUPLING, LARGEST
from vibecalc.torsion.couplings import LIMITS, Borne, borne, has_limit, uses
from vibecalc.torsion.critical_speeds import largest

# ----------------------------------------------------------------------------
# What each coupling bears at some speeds, with the errors or, for curves, without.
# ----------------------------------------------------------------------------

Solve = Callable[[Setup, FloatArray], OrderSolution]


def _unbounded(setup: Setup, speed: FloatArray) -> OrderSolution:
    """All orders at speeds (s,) without their errors."""
    state = solved(setup.model, setup.drive, speed)
    angle, twist, torque = (bounded(one) for one in (state.angle, state.twist, state.torque))
    return state._replace(angle=angle, twist=twist, torque=torque)


def _borne(setup: Setup, speed: FloatArray, solve: Solve) -> list[Borne]:
    """Of each coupling at speeds (s,); infinite where nothing damps an order."""
    found = []
    for start in range(0, len(speed), ROWS):
        at = speed[start : start + ROWS]
        state, mean = solve(setup, at), mean_torques(setup, at).section
        power, masked = section_heat(setup, at, state), np.any(state.masked, axis=-1)
        rows = []
        for one in setup.shaft.couplings:
            steady, lost = mean[:, one.element] / one.ratio, power[:, one.element]
            torque = state.torque[..., one.element] / one.ratio
            there = borne(one, setup.drive.cycles, at, state.frequency, torque, steady, lost)
            rows.append(there._replace(**{
                name: where(masked, np.inf, getattr(there, name))
                for name in ("peak", "vibratory", "by_orders", "power")
            }))  # fmt: skip
        found.append(rows)
    return [
        Borne(*(concatenate(parts) for parts in zip(*blocks, strict=True)))
        for blocks in zip(*found, strict=True)
    ]


class Uses(NamedTuple):
    """Couplings and the limits (k,) that some of them have, by their places in `LIMITS`."""

    setup: Setup
    kept: IntArray
    axes: Mapping[str, Any]

    def at(self, speed: FloatArray, solve: Solve) -> Bounded:
        """Shares (c, k, s) of the limits at speeds (s,)."""
        couplings = self.setup.shaft.couplings
        found = _borne(self.setup, speed, solve)
        each = [stack(uses(one, it), axis=0) for one, it in zip(couplings, found, strict=True)]
        return stack(each, axis=0)[:, self.kept]


def uses_of(setup: Setup) -> Uses:
    """Of all couplings of a line."""
    couplings = setup.shaft.couplings
    kept = np.flatnonzero(np.any([has_limit(one.permissible) for one in couplings], axis=0))
    names = tuple(one.name for one in couplings)
    limits = tuple(LIMITS[place] for place in kept)
    return Uses(setup, kept, {"coupling": names, "coupling_limit": limits})


# ----------------------------------------------------------------------------
# Adapter: couplings at the operating speed.
# ----------------------------------------------------------------------------

#: result -> what of `Borne` it is
_VALUES = {
    "mean_torque": "mean",
    "peak_torque": "peak",
    "vibratory_torque": "vibratory",
    "torque_by_orders": "by_orders",
    "main_frequency": "main",
    "power_loss": "power",
    "temperature": "temperature",
}


def emit_couplings(scene: Scene, setup: Setup) -> None:
    """Torques, heat, temperature, stiffness and use of the limits at the operating speed."""
    at, axes = np.array([setup.speed]), uses_of(setup).axes
    found = _borne(setup, at, bounded_orders)
    for name, key in _VALUES.items():
        value = stack([getattr(one, key) for one in found], axis=0)
        scene.emit(f"{COUPLING}/{name}", value[:, 0], axes=axes)
    _warn_of_rows(scene, setup, found)
    _emit_values(scene, setup)
    emit_use(scene, setup, COUPLING)


def _emit_values(scene: Scene, setup: Setup) -> None:
    """Stiffness and loss factor at the orders, stiffness at the natural frequencies, own values."""
    order, axes, states = setup.drive.order, uses_of(setup).axes, setup.model.couplings
    couplings, natural = setup.shaft.couplings, setup.modes.frequency
    off = 16.0 * EPSILON + (0.0 if states is None else states.spread())
    own = np.square([one.ratio for one in couplings])[:, None]

    def put(name: str, value: FloatArray, of: dict[str, Any], count: int) -> None:
        rows = np.broadcast_to(value, (count, value.shape[-1]))
        rows = rows[:, [one.element for one in couplings]].T
        rows = rows if name == "loss_factor" else rows / own
        scene.emit(f"{COUPLING}/{name}", rows, off * rows, {**axes, **of})

    line = setup.model.at(setup.speed, setup.speed * order)
    put("stiffness", line.stiffness, {"half_order": order}, len(order))
    put("loss_factor", line.loss_factor, {"half_order": order}, len(order))
    modes = {"mode": np.arange(1, len(natural) + 1)}
    put("mode_stiffness", setup.model.at(setup.speed, natural).stiffness, modes, len(natural))


def _warn_of_rows(scene: Scene, setup: Setup, found: list[Borne]) -> None:
    """Say where a coupling is beyond the last row of its table at the operating speed."""
    for one, here in zip(setup.shaft.couplings, found, strict=True):
        for rows, value, words in (
            (one.mean_torque, abs(here.mean), "mean torque"),
            (one.amplitude, here.vibratory, "vibratory torque"),
        ):
            if rows is not None and value.value[0] > rows.at[-1]:
                scene.warn(
                    f"coupling '{one.name}': its {words}, {value.value[0]:.5g} N m, is beyond the "
                    f"last row of its table, {rows.at[-1]:.5g} N m, whose values are taken"
                )


def emit_use(scene: Scene, setup: Setup, place: str) -> None:
    """Use of the limits (c, k) at the operating speed."""
    every = uses_of(setup)
    if len(every.kept):
        use = every.at(np.array([setup.speed]), bounded_orders)
        scene.emit(f"{place}/use", use[..., 0], axes=every.axes)


# ----------------------------------------------------------------------------
# Adapter: couplings over a range of crank speeds, the largest use of each limit and where it is.
# ----------------------------------------------------------------------------


def emit_coupling_speeds(scene: Scene, setup: Setup, speed: FloatArray, dense: FloatArray) -> None:
    """Curves over the speeds (s,); the largest ones are looked for among `dense` as well."""
    axes = {**uses_of(setup).axes, "speed": speed}
    at = distinct(np.concatenate([speed, dense]))

    def read(at: FloatArray, solve: Solve) -> Bounded:
        """(values, c, s)"""
        found = _borne(setup, at, solve)
        rows = [stack([getattr(one, key) for one in found], axis=0) for key in _VALUES.values()]
        return stack(rows, axis=0)

    values, most, where = _largest(read, at)
    errors = _error(read(some_speeds(speed), bounded_orders)).max(axis=(1, 2))
    for number, name in enumerate(_VALUES):
        curve = values[number][..., np.searchsorted(at, speed)]
        scene.emit(f"{COUPLING}/speeds/{name}", curve, errors[number], axes)
        if name in LARGEST:
            scene.emit(f"{COUPLING}/largest/{name}", most[number], axes=axes)
            scene.emit(f"{COUPLING}/largest/{name}_speed", where[number], axes=axes)
    emit_largest_use(scene, setup, speed, dense, COUPLING)


def _error(value: Bounded) -> FloatArray:
    """Errors of finite values, 0 of others."""
    return np.asarray(np.where(np.isfinite(value.value), value.error, 0.0))


#: of a use, what it may differ by over the speeds and count as one
LEVEL = 1e-11


def emit_largest_use(
    scene: Scene, setup: Setup, speed: FloatArray, dense: FloatArray, place: str
) -> None:
    """Largest use (c, k) of each limit at any speed of a range, and where it is."""
    every = uses_of(setup)
    if not len(every.kept):
        return
    at = distinct(np.concatenate([speed, dense]))
    values, most, where = largest_use(setup, at)
    if place == COUPLING:
        error = _error(every.at(some_speeds(speed), bounded_orders)).max()
        curve = values[..., np.searchsorted(at, speed)]
        scene.emit(f"{place}/speeds/use", curve, error, {**every.axes, "speed": speed})
    scene.emit(f"{place}/largest_use", most, axes=every.axes)
    scene.emit(f"{place}/largest_use_speed", where, axes=every.axes)


def largest_use(setup: Setup, at: FloatArray) -> tuple[FloatArray, Bounded, Bounded]:
    """Uses (c, k, s) at some speeds, the largest (c, k) at any between them, and where it is."""
    return _largest(uses_of(setup).at, at)


def _largest(
    read: Callable[[FloatArray, Solve], Bounded], at: FloatArray
) -> tuple[FloatArray, Bounded, Bounded]:
    """Values (..., s) at some speeds, the largest (...) at any between them, and where it is."""
    values = read(at, _unbounded).value
    make = some_rows(lambda one: read(one, _unbounded).value.reshape(-1, len(one)))
    curves, shape = values.reshape(-1, len(at)).T, values.shape[:-1]
    none, count = np.zeros(0), curves.shape[1]
    top = largest(make, curves, at, none, np.full(count, np.nan))
    there = _error(read(top.speed, bounded_orders)).reshape(count, count).diagonal()
    off = np.where(np.isfinite(top.value), there + top.value_error, 0.0)
    # what is the same at every speed is met at the lowest
    with np.errstate(invalid="ignore"):  # where nothing damps an order
        level = np.ptp(curves, axis=0) <= LEVEL * curves.max(axis=0)
    speeds, off_by = np.where(level, at[0], top.speed), np.where(level, 0.0, top.speed_error)
    both = (Bounded(top.value, off), Bounded(speeds, off_by))
    most, where = (reshaped(one, lambda part: part.reshape(shape)) for one in both)
    return values, most, where
