"""A body on its mounts as one linear system: in six motions, in those of a plane, or in pitch."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibecalc.isolation.at_mounts import Resting, displacement, mount_readout, mount_stiffness
from vibecalc.isolation.rows import Readout, distinct
from vibecalc.numerics.bounded import Bounded, bounded, reshaped, rounded
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.linear import Dynamics, Linear, bounded_parts, response
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF
from vibecalc.parts.body import RigidBody, build_frame
from vibecalc.parts.matrices import displacement_at, mounted, on_springs
from vibecalc.parts.mounts import Mounts
from vibecalc.response.system import MountedBody, modes_on_mounts


@dataclass(frozen=True, eq=False, kw_only=True)
class OnMounts(MountedBody):
    """A body with the mounts that it stands on, in some coordinates (f,).

    `reach` (..., 6, f) takes its coordinates to the motion of the reference point, and loads there
    to loads on the coordinates; `stretch` (..., mounts, d, f) takes them to the deflection of each
    mount in the `directions` (d,) in which it has any: `mounts` have the stiffness of these. On a
    rigid ground the coordinates are the motions `freedoms`, as indices into x y z rx ry rz; a
    second body below has six more. `carried` (f, b) is their motion with the base, where nothing is
    deformed. `resting` bears what is constant. Where stiffness follows the frequency, `matrices`
    have that of `Mounts`.

    With the motion X of all coordinates and U of the base the springs see X - R U, R being
    `carried`, and feel nothing else:

        D X = F + K* R U,   D = K* - w^2 M

    The base feels R^T K* (X - R U); what acts between bodies cancels in that sum. Without U it is
    R^T K* inv(D) F, and without F the bodies move by inv(D) K* R U: as all matrices are symmetric,
    one is the transpose of the other.
    """

    mounts: Mounts
    freedoms: np.ndarray
    reach: np.ndarray
    stretch: np.ndarray
    resting: Resting
    carried: np.ndarray
    directions: tuple[int, ...] = (0, 1, 2)

    def felt(self, load: Bounded) -> Bounded:
        """Loads (..., f) on the coordinates of loads (..., 6) about the reference point."""
        return load @ self.reach

    def moved(self, motion: Bounded) -> Bounded:
        """Motion (..., m, 6) of the reference point by one (..., m, f) of the coordinates."""
        return motion @ self.reach.mT

    def at_mounts(self, motion: Bounded) -> Bounded:
        """Deflection (..., mounts, d, m) of the mounts by the same."""
        return displacement(self.stretch, motion)

    def force(self, deflection: Bounded, frequency: np.ndarray) -> Bounded:
        """Force (..., mounts, d, orders) of each mount below it by a deflection, as that."""
        column = reshaped(deflection, np.matrix_transpose)[..., None]
        passed = mount_stiffness(self.mounts, frequency) @ column
        return reshaped(passed[..., 0], np.matrix_transpose)

    def passing(self, frequency: np.ndarray) -> Bounded:
        """R^T K* (..., orders, b, f): load on the base for a motion, N and N m."""
        given = self.at(frequency).passing(frequency)
        return bounded(self.carried.T) @ given

    def ground_load(self, motion: Bounded, frequency: np.ndarray) -> Bounded:
        """Forces and couples (orders, b) on the base by motions (orders, f), about one point."""
        return (self.passing(frequency) @ motion[..., None])[..., 0]

    def transmissibility(self, frequency: np.ndarray) -> Bounded:
        """Loads on the base over loads on the body, (frequencies, b, b) complex: [i, j] is i by j.

        Of a load of one size at all frequencies (rad/s), at the reference point. Transposed it is
        the motion of that body over the motion of the base.
        """
        system_at = self.dynamics(frequency)
        count, kept = self.carried.shape
        unit = np.eye(kept, count, dtype=complex)
        each = Dynamics(*(part[..., None, :, :] for part in system_at))
        motion = response(each, unit, np.zeros((kept, count)))
        return self.passing(frequency) @ reshaped(motion, np.matrix_transpose)

    def moved_by_base(self, base: Bounded, frequency: np.ndarray) -> tuple[Bounded, Bounded]:
        """Motion against the base and motion (frequencies, f), the base moving by (frequencies, b).

        D (X - R U) = w^2 M R U has no difference of large terms where the base moves slowly.
        """
        carried, mass = base @ self.carried.T, bounded_parts(self.matrices)[0]
        load = (carried @ mass) * np.square(frequency)[:, None]
        found = response(self.dynamics(frequency), *load)
        return found, found + carried

    def forces(self) -> Readout:
        """The same as rows of a run-up, those of mounts with a spectrum without its factors."""
        mounts = self.mounts
        loss = mounts.structural if mounts.spectrum is None else np.zeros_like(mounts.stiffness)
        return mount_readout(self.stretch, mounts.stiffness, mounts.damping, loss)

    def couple_over(self, lever: np.ndarray | float) -> Readout:
        """Couple through the mounts over a lever (...) in m, of a body that only pitches."""
        one = self.matrices
        springs = (part[..., None, :, :] for part in (one.stiffness, one.damping, one.structural))
        return mount_readout(1.0 / np.asarray(lever)[..., None, None, None], *springs)

    def shows(self) -> np.ndarray:
        """Which of the modes loads which mount, (..., modes, mounts)."""
        pressed = self.mounts.stiffness @ self.stretch @ self.shapes.shape[..., None, :, :]
        size = np.sqrt(np.square(pressed).sum(axis=-2)).mT
        return np.asarray(size > 1e-12 * size.max(axis=(-2, -1), keepdims=True))

    def alike(self) -> tuple[np.ndarray, np.ndarray]:
        """Mounts that repeat none before them, up to sign, and which of these each mount is.

        Those whose stiffness follows the frequency, or that have stops, are each one of its own:
        their factors, and their motion, are not in what they pass on.
        """
        if self.mounts.spectrum is None and self.travel() is None:
            return distinct(self.forces())
        every = np.arange(self.stretch.shape[-3])
        return every, every

    def travel(self) -> Readout | None:
        """Motion of each mount along its axis, where mounts have stops."""
        axis = self.mounts.axis
        if axis is None or not any(law.stop for law in self.mounts.laws):
            return None
        along = axis[:, None, :] @ self.stretch
        return Readout(along, np.zeros_like(along), 8.0 * UNIT_ROUNDOFF)


def on_mounts(body: RigidBody, mounts: Mounts, freedoms: np.ndarray) -> OnMounts:
    """The system of a body on its mounts in some of the motions x y z rx ry rz.

    What is left out is zero, not free: neither masses nor mounts nor forces couple it with what is
    kept.
    """
    matrices = mounted(body, mounts).reduced(freedoms)
    resting = resting_on(body, mounts, freedoms, matrices)
    reach, stretch, base = resting.reach, resting.stretch, np.eye(len(freedoms))
    return assembled(mounts, freedoms, matrices, reach, stretch, resting, base)


def resting_on(
    body: RigidBody, mounts: Mounts, freedoms: np.ndarray, matrices: Linear | None = None
) -> Resting:
    """How its mounts bear what is constant; `matrices` are those of vibration, where known."""
    stiffness = mounts.stiffness if mounts.static is None else mounts.static
    if matrices is None or mounts.static is not None:
        matrices = mounted(body, replace(mounts, stiffness=stiffness)).reduced(freedoms)
    stretch = displacement_at(mounts.position)[..., freedoms]
    return Resting(matrices, np.eye(6)[:, freedoms], stretch, stiffness)


def assembled(
    mounts: Mounts,
    freedoms: np.ndarray,
    matrices: Linear,
    reach: np.ndarray,
    stretch: np.ndarray,
    resting: Resting,
    carried: np.ndarray,
    below: Linear | None = None,
) -> OnMounts:
    """A system with its modes; `below` has the stiffness of springs that are no mounts."""
    constant = None
    if below is not None:
        constant = below._replace(
            mass=matrices.mass, mass_error=matrices.mass_error,
            damping=matrices.damping, damping_error=matrices.damping_error,
        )  # fmt: skip
    shapes, spectral = modes_on_mounts(matrices, mounts, stretch, constant)
    return OnMounts(
        matrices=matrices, shapes=shapes, spectral=spectral,
        translations=int(np.sum(freedoms < 3)), mounts=mounts, freedoms=freedoms, reach=reach,
        stretch=stretch, resting=resting, carried=carried,
    )  # fmt: skip


def in_direction(mounts: Mounts, along: int) -> Mounts:
    """Mounts that stiffen one direction alone."""
    only = (..., slice(along, along + 1), slice(along, along + 1))
    each = {name: getattr(mounts, name)[only] for name in ("stiffness", "damping", "structural")}
    return replace(mounts, **each)


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
    few = in_direction(mounts, up)
    mass = side_by_side([body.mass, body.inertia[..., turned, turned]])[..., None] * np.eye(2)
    whole = on_springs(rounded(mass, DATA_ROUNDINGS), stretch, few)
    found = assembled(
        few, np.array([3 + turned]), whole.reduced(np.array([1])), both[..., 1:], stretch[..., 1:],
        Resting(whole, both, stretch, few.stiffness), np.eye(1),
    )  # fmt: skip
    return replace(found, directions=(up,))


# ----------------------------------------------------------------------------
# A transmissibility as curves, and the frequencies at which they are drawn.
# ----------------------------------------------------------------------------


def of_each(passing: Bounded) -> Bounded:
    """Magnitudes (b, frequencies) of what each coordinate does along itself, of all (..., b, b)."""
    return reshaped(abs(passing), lambda part: np.diagonal(part, axis1=-2, axis2=-1).T)


#: around each natural frequency, relative distances of samples; none is on it
_NEAR = np.geomspace(1.0e-3, 0.3, 12)
_FAR = 240


def frequency_grid(natural: np.ndarray, lowest: float = 0.0, highest: float = 0.0) -> np.ndarray:
    """Frequencies for a curve, rad/s: even by ratio, dense around each natural frequency.

    From a fifth of the lowest natural frequency to five times the highest, further where `lowest`
    or `highest` lie outside.
    """
    known = natural[natural > 1.0e-6 * natural.max()]
    start, stop = 0.2 * known.min(), 5.0 * known.max()
    start, stop = min(start, lowest or start), max(stop, highest)
    around = known[:, None] * (1.0 + np.concatenate([-_NEAR, _NEAR]))
    even = np.geomspace(start, stop, _FAR)
    # two natural frequencies may be one to rounding, and so may samples around them
    clear = np.all(np.abs(even[:, None] / known - 1.0) > 0.5 * _NEAR[0], axis=1)
    return rising([even[clear], around.ravel()], 1.0e-9)


def rising(parts: Sequence[np.ndarray], apart: float) -> np.ndarray:
    """All places in their order, without those that follow one by less than a share `apart`."""
    every = np.sort(np.concatenate(parts))
    return np.asarray(every[np.concatenate([[True], np.diff(every) > apart * every[1:]])])
