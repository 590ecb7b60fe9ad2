"""One operation with one balance: its state by order, and the part that a balance weight turns."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import Excitation, as_loads, at_speed
from vibecalc.numerics.rounding import WithError
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import forcing_of, linear_system
from vibecalc.response.energies import mass_of
from vibecalc.response.operations import Superposed, superpose


class Combination(NamedTuple):
    """Velocities of the operation and balance whose weight matters most, and their mass matrix.

    `state` holds `shaking` (1, orders, 6) and `residual` (1, 1, 6) as `Superposed` does, of the
    orders (orders,) kept; the energy is the kinetic one.
    """

    weight: WithError
    state: Superposed
    orders: np.ndarray
    operation: str
    balance: str


def strongest(scene: Scene) -> Combination | None:
    """The combination whose kinetic energy a turn of the weight changes most; None without one."""
    options = scene.case.response
    if options is None or not options.operations:
        return None
    forcing, system = forcing_of(scene), linear_system(scene)
    loads = operation_loads(scene, options.operations, options.balances)
    speed, orders = scene.case.machine.speed, forcing.orders[: forcing.kept]

    def at_operating_speed(load: Excitation) -> WithError:
        return as_loads(at_speed(load, speed))

    shaking = [at_operating_speed(load) for load in loads.shaking]
    residual = [[at_operating_speed(load) for load in row] for row in loads.residual]
    parts = superpose(
        system.matrices,
        orders,
        speed,
        WithError(*(np.stack([x[k][: forcing.kept] for x in shaking]) for k in (0, 1))),
        WithError(*(np.stack([[x[k][0] for x in row] for row in residual]) for k in (0, 1))),
    )
    rate = 1j * orders * speed
    weight = mass_of(system.matrices)
    first = parts.shaking.value[:, None, parts.first]
    swing = np.abs(np.sum(first.conj() * (parts.residual.value @ weight.value), axis=-1))
    if not np.any(swing > 0.0):
        return None
    at = np.unravel_index(int(np.argmax(swing)), swing.shape)
    one = slice(at[0], at[0] + 1)
    state = Superposed(
        WithError(
            parts.shaking.value[one] * rate[:, None],
            parts.shaking.error[one] * np.abs(rate)[:, None],
        ),
        WithError(
            parts.residual.value[one, at[1] : at[1] + 1] * rate[parts.first],
            parts.residual.error[one, at[1] : at[1] + 1] * abs(rate[parts.first]),
        ),
        parts.first,
    )
    return Combination(weight, state, orders, loads.operations[at[0]], loads.balances[at[1]])
