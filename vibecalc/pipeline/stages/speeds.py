"""Adapter: energies of the body over a range of crank speeds."""

import numpy as np

from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import as_loads
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.linear_system import (
    LinearSystem,
    forcing_of,
    linear_system,
    resonances_of,
)
from vibecalc.response.direct import Undriven, dynamics, response
from vibecalc.response.energies import (
    dropped_mean,
    energy_by_order,
    mass_of,
    stiffness_of,
    velocity,
)
from vibecalc.response.energy_speeds import energy_speeds
from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import Masked, idle_warnings, left_out, masked_speeds, outside

#: a curve gets points around the resonances of an order that moves a mode by this share at least
#: of what the strongest order does
WORTH_POINTS = 1e-10


def run(scene: Scene) -> None:
    """Emit mean energies at each speed, and the intervals left out around resonances."""
    options = scene.case.response
    if options is None or options.run_up is None:
        raise ValueError("the case has no run-up in [response]")
    forcing, system = forcing_of(scene), linear_system(scene)
    first, last = options.run_up.start, options.run_up.stop
    kept, orders = forcing.kept, forcing.orders[: forcing.kept]
    load = as_loads(forcing.per_speed_squared)
    resonances = resonances_of(system, WithError(load.value[:kept], load.error[:kept]))
    masked = masked_speeds(resonances, orders, first, last)
    for warning in idle_warnings(resonances, orders, first, last):
        scene.warn(warning)
    shown = _worth_points(system, resonances, load.value[:kept], orders)
    speed = _with_ends(energy_speeds(shown, orders, masked, first, last), masked, first, last)
    axes = {"speed": speed, "masked": np.arange(1, len(masked.centre) + 1)}
    for name, energy in _energies(system, resonances, forcing, load, speed).items():
        scene.emit(f"response/run_up/{name}_energy", energy.value, energy.error, axes)
    for name in ("low", "centre", "high"):
        scene.emit(f"response/masked/{name}", getattr(masked, name), masked.centre_error, axes)
    scene.emit("response/masked/order", masked.order, 0.0, axes)
    scene.emit("response/masked/mode", masked.mode, 0.0, axes)


def _worth_points(
    system: LinearSystem, resonances: Resonances, load: np.ndarray, orders: np.ndarray
) -> Resonances:
    """The resonances without those of orders too weak to be seen."""
    moved = np.abs(load @ system.shapes.shape) / np.square(orders)[:, None]
    return resonances._replace(idle=resonances.idle | (moved < WORTH_POINTS * np.max(moved)))


def _with_ends(speed: np.ndarray, masked: Masked, first: float, last: float) -> np.ndarray:
    """The speeds, and all ends of the masked intervals, however narrow these are."""
    ends = np.concatenate([masked.low, masked.high])
    ends = ends[(ends >= first) & (ends <= last) & outside(masked, ends)]
    every = np.sort(np.concatenate([speed, ends]))
    distinct: np.ndarray = every[np.concatenate([[True], np.diff(every) > 0.0])]
    return distinct


def _energies(
    system: LinearSystem,
    resonances: Resonances,
    forcing: Forcing,
    load: WithError,
    speed: np.ndarray,
) -> dict[str, WithError]:
    """Mean energies (speeds,), errors counting the dropped orders by the few that stand for them.

    At rest nothing moves, held or not.
    """
    matrices, kept = system.matrices, forcing.kept
    chosen = np.concatenate([np.arange(kept), forcing.few])
    count = len(forcing.few)
    idle = np.pad(left_out(resonances), ((0, count), (0, 0)))
    undriven = Undriven(idle, system.shapes.shape, system.shapes.eigenvalue)
    turning = speed > 0.0
    frequency = speed[turning][:, None] * forcing.orders[chosen]
    square = np.square(speed[turning])[:, None, None]
    stiffness = dynamics(matrices, frequency, undriven)
    motion = response(stiffness, square * load.value[chosen], square * load.error[chosen])
    found = {}
    for name, weight, state in (
        ("kinetic", mass_of(matrices), velocity(motion, frequency)),
        ("potential", stiffness_of(matrices), motion),
    ):
        each = energy_by_order(weight, WithError(*(part[:, :kept] for part in state)))
        value, error = np.zeros(speed.shape), np.zeros(speed.shape)
        value[turning] = each.mean.sum(-1)
        guards = WithError(*(part[:, kept:] for part in state))
        error[turning] = (
            each.mean_error.sum(-1)
            + kept * UNIT_ROUNDOFF * value[turning]
            + dropped_mean(weight, guards, forcing.few_tail)
        )
        found[name] = WithError(value, error)
    return found
