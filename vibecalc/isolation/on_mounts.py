"""A body on its mounts as one linear system, its stiffness constant or by frequency."""

from dataclasses import dataclass

import numpy as np

from vibecalc.isolation.rigid_body import mount_force, passing_force, restricted
from vibecalc.isolation.rows import CoupleAt, HarmonicsAt, Readout, body_rows
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import displacement_at, mounted
from vibecalc.parts.mounts import Mounts
from vibecalc.response.forced import Dynamics, UndrivenModes, dynamics, dynamics_by_order
from vibecalc.response.modal_damping import (
    body_resonances,
    damped_basis,
    damping_ratio,
    energy_fraction,
    with_damped_poles,
)
from vibecalc.response.modes import Modes, modes
from vibecalc.response.resonances import Resonances, left_out
from vibecalc.response.spectral import (
    OwnMode,
    SpectralSystem,
    joined,
    own_damping_ratio,
    own_energy_fraction,
    own_modes,
    own_resonances,
    spectral_system,
)


@dataclass(frozen=True, eq=False)
class OnMounts:
    """Matrices (f, f) of a body on mounts, and modes that the damping leaves apart.

    `reach` (6, f) takes its coordinates to the motion of the reference point, and loads there to
    loads on the coordinates; `stretch` (..., mounts, 3, f) takes them to the deflection of each
    mount. On a rigid ground the coordinates are the motions `freedoms`, and `whole` has all six; a
    second body below has six more. Where stiffness follows the frequency, `matrices` have that of
    `Mounts`, `own` the modes at their own frequencies and `spectral` the matrices at all.
    """

    mounts: Mounts
    freedoms: np.ndarray
    whole: Matrices
    matrices: Matrices
    shapes: Modes
    reach: np.ndarray
    stretch: np.ndarray
    spectral: SpectralSystem | None = None
    own: tuple[OwnMode, ...] = ()

    def felt(self, load: Bounded) -> Bounded:
        """Loads (..., f) on the coordinates of loads (..., 6) about the reference point."""
        return Bounded(load.value @ self.reach, load.error @ self.reach)

    def damping_ratio(self) -> Bounded:
        """Of each mode."""
        return (
            own_damping_ratio(self.own) if self.own else damping_ratio(self.matrices, self.shapes)
        )

    def energy_fraction(self) -> Bounded:
        """Share (modes, f) of each coordinate in each mode's kinetic energy, about the centre."""
        translations = int(np.sum(self.freedoms < 3))
        if self.own:
            return own_energy_fraction(self.own, translations)
        return energy_fraction(self.matrices, self.shapes, translations)

    def resonances(self, load: Bounded) -> Resonances:
        """Where orders with loads (..., orders, f) meet the modes."""
        if self.own:
            return own_resonances(self.own, load)
        return body_resonances(self.matrices, self.shapes, load)

    def with_poles(self, resonances: Resonances, load: Bounded) -> Resonances:
        """With those that strong damping moves; of several stiffnesses by that of a middle mode."""
        if not self.own:
            return with_damped_poles(resonances, self.matrices, self.shapes, load)
        middle = self.own[len(self.own) // 2]
        found = with_damped_poles(
            body_resonances(middle.matrices, middle.shapes, load),
            middle.matrices,
            middle.shapes,
            load,
        )
        return resonances._replace(
            moved_frequency=found.moved_frequency, moved_ratio=found.moved_ratio
        )

    def undriven(self, resonances: Resonances) -> UndrivenModes | None:
        """Undamped modes to leave out of orders that do not drive them."""
        if self.own:
            return None
        return UndrivenModes(left_out(resonances), self.shapes.shape, self.shapes.eigenvalue)

    def dynamics(self, frequency: np.ndarray, resonances: Resonances) -> Dynamics:
        """Dynamic stiffness at frequencies (..., orders) in rad/s."""
        if self.spectral is not None:
            return dynamics_by_order(self.spectral.at(frequency), frequency)
        return dynamics(self.matrices, frequency, self.undriven(resonances))

    def force(self, motion: Bounded, frequency: np.ndarray) -> Bounded:
        """Force (..., mounts, 3, orders) on the ground by a motion of the mounts, as that."""
        mounts = self.mounts
        if mounts.spectrum is None:
            return mount_force(
                motion, frequency, mounts.stiffness, mounts.damping, mounts.structural
            )
        factor = np.moveaxis(mounts.spectrum(frequency), -1, 0)[..., None, None]
        viscous = 1j * np.asarray(frequency)[:, None, None] * mounts.damping[:, None]
        return passing_force(motion, factor * mounts.stiffness[:, None] + viscous)

    def travel(self) -> Readout | None:
        """Motion of each mount along its axis, where mounts have stops."""
        axis = self.mounts.axis
        if axis is None or not any(law.stop for law in self.mounts.laws):
            return None
        along = axis[:, None, :] @ self.stretch
        return Readout(along, np.zeros_like(along), 8.0 * UNIT_ROUNDOFF)

    def rows(
        self,
        readout: Readout,
        orders: np.ndarray,
        force: Bounded,
        resonances: Resonances,
        couple_at: CoupleAt | None = None,
        about: np.ndarray | None = None,
        passed_on: bool = True,
    ) -> HarmonicsAt:
        """Rows of the readout over crank speed, under forces (orders, f) per squared speed.

        They are forces that the mounts pass on, or else motions.
        """
        if self.spectral is not None:
            from vibecalc.isolation.spectral_rows import spectral_rows

            return spectral_rows(self.spectral, readout, orders, force, couple_at, about, passed_on)
        undriven = self.undriven(resonances)
        return body_rows(self.matrices, readout, orders, force, undriven, couple_at, about)


def on_mounts(body: RigidBody, mounts: Mounts, freedoms: np.ndarray) -> OnMounts:
    """The system of a body on its mounts in some of the motions x y z rx ry rz."""
    whole = mounted(body, mounts)
    matrices = restricted(whole, freedoms)
    reach = np.eye(6)[:, freedoms]
    stretch = displacement_at(mounts.position)[..., freedoms]
    if mounts.spectrum is None:
        shapes = damped_basis(matrices, modes(matrices))
        return OnMounts(mounts, freedoms, whole, matrices, shapes, reach, stretch)
    spectral = spectral_system(matrices, mounts, freedoms)
    own = tuple(own_modes(spectral))
    return OnMounts(mounts, freedoms, whole, matrices, joined(own), reach, stretch, spectral, own)
