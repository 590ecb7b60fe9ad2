"""A body on its mounts as one linear system: in six motions, in those of a plane, or in pitch."""

from dataclasses import dataclass, replace

import numpy as np

from vibecalc.isolation.at_mounts import (
    Resting,
    displacement,
    mount_force,
    mount_readout,
    passing_force,
)
from vibecalc.isolation.rows import CoupleAt, HarmonicsAt, Readout, body_rows
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.linear import (
    Dynamics,
    Linear,
    UndrivenModes,
    dynamics,
    dynamics_by_order,
    law,
    resisting,
)
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF
from vibecalc.parts.body import RigidBody, build_frame
from vibecalc.parts.matrices import displacement_at, on_springs
from vibecalc.parts.mounts import Mounts
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

    `reach` (..., 6, f) takes its coordinates to the motion of the reference point, and loads there
    to loads on the coordinates; `stretch` (..., mounts, d, f) takes them to the deflection of each
    mount in the `directions` (d,) in which it has any: `mounts` have the stiffness of these. On a
    rigid ground the coordinates are the motions `freedoms`, as indices into x y z rx ry rz; a
    second body below has six more. `resting` bears what is constant. Where stiffness follows the
    frequency, `matrices` have that of `Mounts`, `own` the modes at their own frequencies and
    `spectral` the matrices at all.
    """

    mounts: Mounts
    freedoms: np.ndarray
    matrices: Linear
    shapes: Modes
    reach: np.ndarray
    stretch: np.ndarray
    resting: Resting
    directions: tuple[int, ...] = (0, 1, 2)
    spectral: SpectralSystem | None = None
    own: tuple[OwnMode, ...] = ()

    def felt(self, load: Bounded) -> Bounded:
        """Loads (..., f) on the coordinates of loads (..., 6) about the reference point."""
        return load @ self.reach

    def moved(self, motion: Bounded) -> Bounded:
        """Motion (..., m, 6) of the reference point by one (..., m, f) of the coordinates."""
        return motion @ self.reach.mT

    def at_mounts(self, motion: Bounded) -> Bounded:
        """Deflection (..., mounts, d, m) of the mounts by the same."""
        return displacement(self.stretch, motion)

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
        """Force (..., mounts, d, orders) on the ground by a deflection of the mounts, as that."""
        mounts = self.mounts
        if mounts.spectrum is None:
            return mount_force(
                motion, frequency, mounts.stiffness, mounts.damping, mounts.structural
            )
        factor = np.moveaxis(mounts.spectrum(frequency), -1, 0)[..., None, None]
        by_order = factor * mounts.stiffness[:, None]
        rate = np.asarray(frequency)[:, None, None]
        given = (by_order.real, by_order.imag, mounts.damping[:, None])
        return passing_force(motion, resisting(*given, rate))

    def forces(self) -> Readout:
        """The same as rows of a run-up, those of mounts with a spectrum without its factors."""
        mounts = self.mounts
        loss = mounts.structural if mounts.spectrum is None else np.zeros_like(mounts.stiffness)
        return mount_readout(self.stretch, mounts.stiffness, mounts.damping, loss)

    def couple_over(self, lever: np.ndarray | float) -> Readout:
        """Couple through the mounts over a lever (...) in m, of a body that only pitches."""
        matrices, arm = self.matrices, np.asarray(lever)[..., None, None, None]
        still, rising = law(matrices.stiffness, matrices.structural, matrices.damping)
        rounding = (8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
        return Readout(still[..., None, :, :] / arm, rising[..., None, :, :] / arm, rounding)

    def shows(self) -> np.ndarray:
        """Which of the modes loads which mount, (..., modes, mounts)."""
        pressed = self.mounts.stiffness @ self.stretch @ self.shapes.shape[..., None, :, :]
        size = np.sqrt(np.square(pressed).sum(axis=-2)).mT
        return np.asarray(size > 1e-12 * size.max())

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
    """The system of a body on its mounts in some of the motions x y z rx ry rz.

    What is left out is zero, not free: neither masses nor mounts nor forces couple it with what is
    kept.
    """
    reach = np.eye(6)[:, freedoms]
    whole = displacement_at(mounts.position)
    matrices = on_springs(body.mass_matrix, body.mass_error, whole, mounts).reduced(freedoms)
    stretch, still = whole[..., freedoms], matrices
    stiffness = mounts.stiffness if mounts.static is None else mounts.static
    if mounts.static is not None:
        bearing = replace(mounts, stiffness=stiffness)
        still = on_springs(body.mass_matrix, body.mass_error, whole, bearing).reduced(freedoms)
    resting = Resting(still, reach, stretch, stiffness)
    if mounts.spectrum is None:
        shapes = damped_basis(matrices, modes(matrices))
        return OnMounts(mounts, freedoms, matrices, shapes, reach, stretch, resting)
    spectral = spectral_system(matrices, mounts, freedoms)
    own = tuple(own_modes(spectral))
    return OnMounts(
        mounts, freedoms, matrices, joined(own), reach, stretch, resting, spectral=spectral, own=own
    )


def pitching(body: RigidBody, mounts: Mounts, axis: str, stroke: str) -> OnMounts:
    """The system of a body that only turns, about the axis across its crankshaft.

    The axis goes through the mass centre, and a mount at x along the shaft from there moves by -x
    times the angle along the stroke, where its stiffness counts: that in pitch is the sum of k x^2
    (N. Gibson, Dynamics 3 assignment (2008), equations 13 to 19, with "4 L^2 k" for four mounts at
    x = +L and -L). At rest the body heaves as well.
    """
    frame = build_frame(axis, stroke)
    along, up, turned = (
        int(np.argmax(np.abs(one))) for one in (frame.axis, frame.stroke, frame.across)
    )
    across = np.broadcast_to(frame.across, body.centre.shape)
    turn = np.concatenate([-np.cross(across, body.centre), across], axis=-1)
    heave = np.broadcast_to(np.concatenate([frame.stroke, np.zeros(3)]), turn.shape)
    both = np.stack([heave, turn], axis=-1)
    lever = body.centre[..., along, None] - mounts.position[..., along]
    stretch = np.stack([np.ones(lever.shape), lever], axis=-1)[..., None, :]
    only = (..., slice(up, up + 1), slice(up, up + 1))
    few = replace(
        mounts,
        stiffness=mounts.stiffness[only],
        damping=mounts.damping[only],
        structural=mounts.structural[only],
    )
    mass = side_by_side([body.mass, body.inertia[..., turned, turned]])[..., None] * np.eye(2)
    whole = on_springs(mass, None, stretch, few)
    matrices = whole.reduced(np.array([1]))
    return OnMounts(
        few, np.array([3 + turned]), matrices, modes(matrices), both[..., 1:], stretch[..., 1:],
        Resting(whole, both, stretch, few.stiffness), directions=(up,),
    )  # fmt: skip
