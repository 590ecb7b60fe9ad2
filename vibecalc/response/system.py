"""A body on its mounts as a linear system with modes: what they are made of, what meets them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, concatenate, quadratic, reshaped, where
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.linear import (
    Dynamics,
    Linear,
    UndrivenModes,
    bounded_parts,
    dynamics_by_order,
    each_order,
    require_digits,
    response,
)
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF
from vibecalc.parts.mounts import Mounts
from vibecalc.response.modal_damping import DampedPoles, any_drives, with_damped_poles
from vibecalc.response.modes import Modes, modes
from vibecalc.response.resonances import Resonances, check_operating_point, left_out
from vibecalc.response.spectral import SpectralSystem, own_modes, spectral_system


def modes_on_mounts(
    matrices: Linear,
    mounts: Mounts | None,
    stretch: np.ndarray,
    constant: Linear | None = None,
) -> tuple[Modes, SpectralSystem | None]:
    """Modes, and where the stiffness of mounts follows the frequency, the matrices at all of them.

    `stretch` (..., mounts, 3, f) takes the coordinates to the deflections of the mounts; `constant`
    are the matrices without the stiffness of these, if springs are there that are no mounts.
    """
    if mounts is None or mounts.spectrum is None:
        return modes(matrices), None
    spectral = spectral_system(constant or matrices.free(), mounts, stretch)
    return own_modes(spectral), spectral


@dataclass(frozen=True, eq=False, kw_only=True)
class MountedBody:
    """Matrices (..., f, f) with all damping in them, and modes that the damping leaves apart.

    The first `translations` coordinates are those of a point of the body, with a diagonal block of
    mass. Where the stiffness of mounts follows the frequency, `spectral` has the matrices at all of
    them, and each mode is one of those at its own natural frequency.
    """

    matrices: Linear
    shapes: Modes
    spectral: SpectralSystem | None = None
    translations: int = 3

    def at(self, frequency: np.ndarray) -> Linear:
        """Matrices (..., m, f, f) at frequencies (..., m) in rad/s; (..., 1, f, f) for all."""
        return each_order(self.matrices) if self.spectral is None else self.spectral.at(frequency)

    def energy_fraction(self) -> Bounded:
        """Share (..., modes, f) of each coordinate in the kinetic energy of each mode.

        About the mass centre, whichever the point of the body: with its velocity u that is
        (M v)_i u_i of a translation and v_i (J v)_i of a rotation, J being the inertia about it.
        Each row sums to 1; with products of inertia an entry can be slightly negative.
        """
        along, about = slice(None, self.translations), slice(self.translations, None)
        mass, shape = bounded_parts(self.matrices)[0], _rows(self.shapes.bounded_shape)
        move, turn = shape[..., along], shape[..., about]
        weight, moments = mass[..., along, along], mass[..., along, about]
        inverse = np.linalg.inv(weight.value)
        levers = inverse @ moments.value
        left = moments - weight @ levers
        off = np.abs(inverse) @ (np.abs(left.value) + left.error)
        centre = move + turn @ reshaped(Bounded(levers, off), np.matrix_transpose)
        inertia = mass[..., about, about] - mass[..., about, along] @ Bounded(levers, off)
        energy = concatenate([shape @ mass[..., along] * centre, turn * (turn @ inertia)])
        return energy / energy.sum()[..., None]

    def damping_ratio(self) -> Bounded:
        """Damping ratio of each mode (..., modes): v C v / (2 w) + v H v / (2 w^2).

        Exact for proportional damping, the usual estimate otherwise; the structural part is half
        the loss factor that the mode sees at its own frequency. Raises NumericalFailure for a mode
        that nothing holds, whose ratio has no meaning.
        """
        if not np.all(self.shapes.held):
            number = int(np.argwhere(~self.shapes.held)[0, -1]) + 1
            raise NumericalFailure(
                f"mode {number} has no damping ratio: nothing holds the body in it (its stiffness "
                f"is zero to rounding); give the mounts stiffness in that direction"
            )
        return self._damping_ratio()

    def _damping_ratio(self) -> Bounded:
        """The same, of a mode that nothing holds 0."""
        shapes = self.shapes
        frequency = Bounded(
            np.where(shapes.held, shapes.natural_frequency, np.inf), shapes.natural_frequency_error
        )
        _, _, damping, structural = bounded_parts(self.at(shapes.natural_frequency))
        row = _rows(shapes.bounded_shape)[..., None, :]
        viscous, loss = (quadratic(row, one)[..., 0] for one in (damping, structural))
        return 0.5 * (viscous + loss / frequency) / frequency

    @cached_property
    def _met(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Frequency, damping ratio and width (..., modes) that resonances have under any load."""
        shapes, held = self.shapes, self.shapes.held
        here, row = self.at(shapes.natural_frequency), np.abs(shapes.shape.mT)[..., None, :]
        off_k = here.stiffness_error + 2.0 * UNIT_ROUNDOFF * np.abs(here.stiffness)
        off_m = here.mass_error + 4.0 * UNIT_ROUNDOFF * np.abs(here.mass)
        loss = np.sum(row @ off_k * row, axis=(-2, -1)) / np.where(held, shapes.eigenvalue, np.inf)
        loss = loss + np.sum(row @ off_m * row, axis=(-2, -1))
        frequency = np.where(held, shapes.natural_frequency, np.inf)
        width = np.where(held, 0.5 * loss / SINGULAR, 0.0)
        return frequency, np.abs(self._damping_ratio().value), width

    def resonances(self, *loads: Bounded) -> Resonances:
        """Where orders with any of these loads (..., orders, f), of any scale, meet the modes.

        A mode that nothing holds has no resonance: it stands at infinity, where no order meets it.
        Where matrices change with the frequency an undamped mode counts as driven, for no mode
        can be left out of an order.
        """
        held = self.shapes.held
        leave_alone(~np.all(held, axis=-1))
        driven = any_drives(loads, self.shapes.bounded_shape)
        idle = ~(driven & held[..., None, :])
        found = Resonances(*self._met, idle)
        if self.spectral is None:
            return found
        return found._replace(idle=found.idle & (found.exposed() == 0.0))

    def with_poles(
        self, resonances: Resonances, *loads: Bounded, poles: DampedPoles | None = None
    ) -> Resonances:
        """With those that strong damping moves; of several stiffnesses by that of a middle mode."""
        if self.spectral is None:
            return with_damped_poles(resonances, self.matrices, self.shapes, loads, poles)
        frequency = self.shapes.natural_frequency
        matrices = self.spectral.at(frequency[len(frequency) // 2])
        middle = MountedBody(matrices=matrices, shapes=modes(matrices))
        found = middle.with_poles(middle.resonances(*loads), *loads)
        count = len(frequency)
        return resonances.beside(found.frequency[count:], found.damping_ratio[count:])

    def checked(
        self, order: np.ndarray, speed: float, warn: Callable[[str], None], *loads: Bounded
    ) -> Resonances:
        """The same at a speed in rad/s: NumericalFailure where an order drives an undamped mode.

        Warns of modes that an order meets and does not drive.
        """
        resonances = self.resonances(*loads)
        check_operating_point(resonances, order, speed, warn)
        return resonances

    def undriven(self, resonances: Resonances) -> UndrivenModes:
        """Undamped modes to leave out of orders that do not drive them."""
        return UndrivenModes(left_out(resonances), self.shapes.shape, self.shapes.eigenvalue)

    def dynamics(self, frequency: np.ndarray, resonances: Resonances | None = None) -> Dynamics:
        """Dynamic stiffness at frequencies (..., orders) in rad/s."""
        undriven = None if resonances is None else self.undriven(resonances)
        return dynamics_by_order(self.at(frequency), frequency, undriven)

    def forced(
        self, load: Bounded, order: np.ndarray, speed: float, resonances: Resonances
    ) -> Bounded:
        """Motion (..., orders, f) under loads of that shape at a speed in rad/s.

        Raises NumericalFailure where fewer than four digits of it would be certain.
        """
        system = self.dynamics(order * np.asarray(speed)[..., None], resonances)
        motion = response(system, load.value, load.error)
        require_digits(self.matrices, system, load, motion, order, speed)
        return motion

    def summed_up(
        self, load: Bounded, order: np.ndarray, speed: float, resonances: Resonances
    ) -> Bounded:
        """The same as a sum of modes.

        Modes that damping couples move together; those without stiffness and repeated ones are
        modes like any other. Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed.,
        chapter 6.
        """
        shape = self.shapes.shape
        modal = replace(
            self,
            matrices=in_modes(self.matrices, shape),
            shapes=self.shapes._replace(shape=np.eye(shape.shape[-1])),
        )
        return modal.forced(load @ shape, order, speed, resonances) @ shape.mT


def in_modes(matrices: Linear, shape: np.ndarray) -> Linear:
    """Matrices V^T A V in the coordinates of shapes V (..., f, modes), of any sign and scale.

    What couples two of these by no more than rounding is left out.
    """
    modal = [shape.mT @ part @ shape for part in bounded_parts(matrices)]
    aside = ~np.eye(shape.shape[-1], dtype=bool)
    modal = [where(aside & (np.abs(part.value) <= part.error), 0.0, part) for part in modal]
    return Linear(*(part.value for part in modal), *(part.error for part in modal))


def _rows(columns: Bounded) -> Bounded:
    """Shapes (..., modes, f), one a row."""
    return reshaped(columns, np.matrix_transpose)
