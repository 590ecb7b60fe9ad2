"""Adapter: a base that moves, to the motion of the machine and the work of its mounts."""

import numpy as np

from vibecalc.base_motion.model import (
    amplitude_of,
    at_reference,
    densities_of,
    frequency_of,
    on_base,
)
from vibecalc.base_motion.results import HARMONIC, MOTIONS, OF_MOUNTS, SPECTRUM, OverFrequency
from vibecalc.base_motion.spectrum import Density, mean_squares, panel_ends
from vibecalc.base_motion.tables import BaseMotion
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.at_mounts import mount_stiffness
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid
from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, FloatArray
from vibecalc.parts.body import COORDINATES, DIRECTIONS
from vibecalc.points.model import QUANTITIES, Readings, readings_of

#: turns of 2 pi
_TURN = 2.0 * np.pi
#: frequencies of a density that is drawn
_DRAWN = 320
#: damping ratio below which a mean square is no number
_UNDAMPED = 1e-7


def run_base_motion(scene: Scene) -> None:
    """Emit transmissibilities, the response to each harmonic, and that to the spectra."""
    given, body, mounts = scene.case.base_motion, scene.parts.body, scene.parts.mounts
    if given is None or body is None or mounts is None:
        raise ValueError("[base_motion] needs a body and mounts")
    system = on_base(scene.case, body, mounts)
    scene.handed_on["on_base"] = system
    readings = readings_of(scene.case)
    scene.cite(
        "rigid body on mounts whose base moves, complex dynamic stiffness",
        "motion of the base",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 11",
    )
    _emit_curves(scene, system)
    if given.harmonics:
        _emit_harmonics(scene, system, readings, given)
    if given.spectra:
        _emit_spectra(scene, system, readings, given)


def _emit_curves(scene: Scene, system: OnMounts) -> None:
    """Of motions of the base at the reference point, each in the direction in which it moves."""
    grid = frequency_grid(system.shapes.natural_frequency)
    passing = system.transmissibility(grid)
    relative = passing - np.eye(passing.shape[-1])
    axes = {"coordinate": COORDINATES, "base_frequency": grid / _TURN}
    both = (
        reshaped(abs(part), lambda one: np.diagonal(one, axis1=-2, axis2=-1).T)
        for part in (passing, relative)
    )
    scene.emit_all(OverFrequency(*both), axes)


# ----------------------------------------------------------------------------
# Harmonics of the base, one by one: they have no common period, so that peaks are sums.
# ----------------------------------------------------------------------------


def _emit_harmonics(scene: Scene, system: OnMounts, readings: Readings, given: BaseMotion) -> None:
    frequency = np.array([frequency_of(one, scene.case) for one in given.harmonics])
    said = np.array(
        [amplitude_of(one, w) for one, w in zip(given.harmonics, frequency, strict=True)]
    )
    names = [one.name for one in given.harmonics]
    turned = at_reference(given.point)
    size = np.abs(said) @ np.abs(turned).T
    base = Bounded(said @ turned.T, 8.0 * UNIT_ROUNDOFF * size)
    relative, motion = system.moved_by_base(base, frequency)
    _require_digits(system, relative, names, frequency)
    axes = {"base_harmonic": names, "direction": DIRECTIONS}
    scene.emit(f"{HARMONIC}/frequency", frequency, axes=axes)
    rate = 1j * frequency[:, None]
    own, against = motion[:, :6], relative[:, :6]
    series = (own, against, own * rate, own * rate**2)
    names_of = [name for name, *_ in MOTIONS]
    for place, part in enumerate(series):
        scene.emit(f"{HARMONIC}/{names_of[2 * place]}", part[:, :3], axes=axes)
        scene.emit(f"{HARMONIC}/{names_of[2 * place + 1]}", part[:, 3:], axes=axes)
    if motion.shape[-1] > 6:
        for name, part in (("translation", motion[:, 6:9]), ("rotation", motion[:, 9:])):
            scene.emit(f"{HARMONIC}/foundation_{name}", part, axes=axes)
    total = abs(series[-1][:, :3]).sum(0)
    scene.emit(f"{HARMONIC}/acceleration_peak", total, axes={"direction": DIRECTIONS})
    if readings.names:
        at = (own @ readings.row.T, own * rate @ readings.row.T, own * rate**2 @ readings.row.T)
        axes = {"sensor": readings.names, "base_harmonic": names}
        for name, part in zip(QUANTITIES, at, strict=True):
            scene.emit(f"{HARMONIC}/point_{name}", part.T, axes=axes)
            scene.emit(f"{HARMONIC}/point_{name}_peak", abs(part).sum(0), axes=axes)
    deflection = system.at_mounts(relative)
    force = system.force(deflection, frequency)
    axes = {"mount": system.mounts.names, "direction": DIRECTIONS, "base_harmonic": names}
    for (name, *_), part in zip(OF_MOUNTS, (deflection, force), strict=True):
        scene.emit(f"{HARMONIC}/{name}", part, axes=axes)
        # the length of a vector is largest where its ellipse is: at most root of both axes squared
        vector = reshaped(part, lambda one: np.moveaxis(one, -1, 0))
        scene.emit(f"{HARMONIC}/{name}_peak", _longest(vector).sum(0), axes=axes)


def _longest(vector: Bounded) -> Bounded:
    """Largest length (...) over the cycle of vectors (..., 3) of one frequency, an ellipse.

    |Re(v exp(i a))|^2 = (|v|^2 + Re(v.v exp(2 i a))) / 2.
    """
    value = vector.value
    whole = np.sum(np.square(np.abs(value)), axis=-1)
    longest = np.sqrt(0.5 * (whole + np.abs(np.sum(value * value, axis=-1))))
    error = np.linalg.norm(np.broadcast_to(vector.error, value.shape), axis=-1)
    return Bounded(longest, error + 8.0 * UNIT_ROUNDOFF * longest)


def _require_digits(
    system: OnMounts, relative: Bounded, names: list[str], frequency: FloatArray
) -> None:
    """Refuse a harmonic of whose response fewer than four digits are certain."""
    weight = np.sqrt(np.diagonal(system.matrices.mass))
    size = np.max(weight * np.abs(relative.value), axis=-1)
    lost = ~(np.max(weight * relative.error, axis=-1) < SINGULAR * size) & (size > 0.0)
    if np.any(lost):
        place = int(np.argmax(lost))
        raise NumericalFailure(
            f"harmonic {names[place]!r} of the base at {frequency[place] / _TURN:.6g} Hz meets an "
            "undamped natural frequency of the machine on its mounts: there is no steady motion; "
            "give the mounts damping or a loss factor, or another frequency"
        )


# ----------------------------------------------------------------------------
# Spectra of the base: mean squares of directions that know nothing of each other add.
# ----------------------------------------------------------------------------


def _emit_spectra(scene: Scene, system: OnMounts, readings: Readings, given: BaseMotion) -> None:
    logarithmic = given.interpolation == "logarithmic"
    densities = [Density(*densities_of(one), logarithmic) for one in given.spectra]
    squared = [one.velocity is not None for one in given.spectra]
    chosen = [COORDINATES.index(one.direction) for one in given.spectra]
    base = at_reference(given.point)[:, chosen]
    ratio, natural = system.damping_ratio().value, system.shapes.natural_frequency
    _require_damping(system, ratio, base, densities)

    def weights(frequency: FloatArray) -> FloatArray:
        """Densities (frequencies, spectra) of the acceleration."""
        found = [
            one.at(frequency) * (frequency**2 if by_speed else 1.0)
            for one, by_speed in zip(densities, squared, strict=True)
        ]
        return np.stack(found, axis=-1)

    def powers(frequency: FloatArray) -> FloatArray:
        response = _responses(system, readings.row, base, frequency)
        found = np.einsum("frs,fs->fr", np.square(np.abs(response)), weights(frequency))
        return np.asarray(found)

    count, read = 3 * len(system.mounts.names), len(readings.names)
    kinds = [*np.repeat(np.arange(10), 3), *np.repeat([10, 11], count)]
    kinds += [*np.repeat([12, 13, 14], read)]
    ends = panel_ends(densities, natural, ratio)
    tolerance = min(scene.case.accuracy.rtol, 1e-6)
    found = bounded.sqrt(mean_squares(powers, ends, np.array(kinds), tolerance))
    factor = given.peak_factor
    axes = {"direction": DIRECTIONS, "mount": system.mounts.names, "sensor": readings.names}
    scene.emit(f"{SPECTRUM}/base_acceleration_rms", found[:3], axes=axes)
    for place, (name, *_) in enumerate(MOTIONS, start=2):
        part = found[3 * place : 3 * place + 3]
        scene.emit(f"{SPECTRUM}/{name}_rms", part, axes=axes)
        scene.emit(f"{SPECTRUM}/{name}_peak", part * factor, axes=axes)
    for place, (name, *_) in enumerate(OF_MOUNTS):
        part = found[30 + place * count : 30 + (place + 1) * count]
        each = reshaped(part, lambda one: one.reshape(-1, 3))
        scene.emit(f"{SPECTRUM}/{name}_rms", each, axes=axes)
        scene.emit(f"{SPECTRUM}/{name}_peak", each * factor, axes=axes)
    for place, name in enumerate(QUANTITIES if read else ()):
        first = 30 + 2 * count + place * read
        part = found[first : first + read]
        scene.emit(f"{SPECTRUM}/point_{name}_rms", part, axes=axes)
        scene.emit(f"{SPECTRUM}/point_{name}_peak", part * factor, axes=axes)
    drawn = np.geomspace(ends[0], ends[-1], _DRAWN)
    inside = natural[(natural > ends[0]) & (natural < ends[-1])]
    around = (inside[:, None] * (1.0 + np.array([-0.02, -0.005, 0.005, 0.02]))).ravel()
    drawn = np.sort(np.concatenate([drawn, around[(around > ends[0]) & (around < ends[-1])]]))
    drawn = drawn[np.concatenate([[True], np.diff(drawn) > 1e-9 * drawn[1:]])]
    both = powers(drawn)
    axes = {"direction": DIRECTIONS, "base_frequency": drawn / _TURN}
    for name, density in (("base_density", both[:, :3].T), ("density", both[:, 24:27].T)):
        scene.emit(f"{SPECTRUM}/{name}", density, 1e-11 * np.max(density), axes)
    scene.cite(
        "Gauss rules on panels about each resonance, two orders compared",
        "mean squares by the spectra of the base",
        "docs/theory_base.md",
    )


def _require_damping(
    system: OnMounts, ratio: FloatArray, base: FloatArray, densities: list[Density]
) -> None:
    """Refuse a mode without damping that a spectrum drives: its mean square has no bound."""
    shapes, carried = system.shapes, system.carried @ base
    momentum = system.matrices.mass @ carried
    whole = np.sqrt(np.einsum("ns,ns->s", carried, momentum))
    driven = np.abs(shapes.shape.T @ momentum) > 1e-9 * whole
    for mode, natural in enumerate(shapes.natural_frequency):
        met = [one.frequency[0] <= natural <= one.frequency[-1] for one in densities]
        if ratio[mode] < _UNDAMPED and np.any(driven[mode] & np.array(met)):
            raise NumericalFailure(
                f"mode {mode + 1} of the machine on its mounts, {natural / _TURN:.6g} Hz, has no "
                "damping and lies within a spectrum of the base that drives it: its mean square "
                "has no bound; give the mounts damping or a loss factor"
            )


def _responses(
    system: OnMounts, rows: FloatArray, base: FloatArray, frequency: FloatArray
) -> np.ndarray:
    """Responses (frequencies, responses, spectra) to unit accelerations of the base.

    Acceleration of the base; then displacement, relative displacement, velocity and acceleration of
    the body, three along and three about the axes each; then deflections and forces of the mounts;
    then displacement, velocity and acceleration by the `rows` (readings, 6).
    """
    mass, rate = system.matrices.mass, frequency[:, None, None]
    dynamic = system.at(frequency).passing(frequency).value - rate**2 * mass
    carried = system.carried @ base
    scale = 1.0 / np.sqrt(np.diagonal(mass))
    weight = scale[:, None] * scale
    load = -scale[:, None] * (mass @ carried)
    relative = scale[:, None] * np.linalg.solve(dynamic * weight, load)
    own = carried[:6] - rate**2 * relative[:, :6]
    still = np.broadcast_to(base, (len(frequency), *base.shape))
    deflection = system.stretch @ relative[:, None]
    passing = np.moveaxis(mount_stiffness(system.mounts, frequency).value, 1, 0)
    flat = [
        part.reshape(len(frequency), -1, base.shape[1])
        for part in (deflection, passing @ deflection)
    ]
    read = rows @ own
    points = [-read / rate**2, read / (1j * rate), read] if len(rows) else []
    return np.concatenate(
        [still, -own / rate**2, relative[:, :6], own / (1j * rate), own, *flat, *points], axis=1
    )
