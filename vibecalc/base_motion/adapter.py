"""Adapter: a base that moves, to the motion of the machine and the work of its mounts."""

from typing import Any

import numpy as np

from vibecalc.base_motion.model import at_reference, density_of, harmonics_of, on_base
from vibecalc.base_motion.results import HARMONIC, PEAKS, RESPONSES, ROOT, SPECTRUM
from vibecalc.base_motion.spectrum import Density, curve_frequencies, mean_squares, panel_ends
from vibecalc.base_motion.tables import BaseMotion
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid, of_each
from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import uncertain
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.body import COORDINATES, DIRECTIONS
from vibecalc.points.model import QUANTITIES, readings_of

#: turns of 2 pi
_TURN = 2.0 * np.pi
#: damping ratio below which a mean square is no number
_UNDAMPED = 1e-7


def run_base_motion(scene: Scene) -> None:
    """Emit transmissibilities, the response to each harmonic, and that to the spectra."""
    given, body, mounts = scene.case.base_motion, scene.parts.body, scene.parts.mounts
    assert given is not None and body is not None and mounts is not None
    system, readings = on_base(scene.case, body, mounts), readings_of(scene.case)
    scene.handed_on["on_base"] = system
    scene.cite(
        "rigid body on mounts whose base moves, complex dynamic stiffness",
        "motion of the base",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 11",
    )
    grid = frequency_grid(system.shapes.natural_frequency)
    passing = system.transmissibility(grid)
    curves = {"": passing, "relative_": passing - np.eye(passing.shape[-1])}
    axes = {"coordinate": COORDINATES, "base_frequency": grid / _TURN}
    for name, of in curves.items():
        scene.emit(f"{ROOT}/{name}transmissibility", of_each(of), axes=axes)
    axes = {"direction": DIRECTIONS, "mount": mounts.names, "sensor": readings.names}
    if given.harmonics:
        _emit_harmonics(scene, system, readings.row, given, axes)
    if given.spectra:
        _emit_spectra(scene, system, readings.row, given, axes)


def _responses(
    system: OnMounts, rows: FloatArray, relative: Bounded, motion: Bounded, frequency: FloatArray
) -> dict[str, Bounded]:
    """What has results, (..., m, own axes), of motions (..., m, f) against the base and in all.

    Points are read by the `rows` (readings, 6).
    """
    rate, deflection = 1j * frequency[:, None], system.at_mounts(relative)
    rates = [motion[..., :6], motion[..., :6] * rate, motion[..., :6] * rate**2]
    pairs = {
        "translation rotation": rates[0],
        "relative_translation relative_rotation": relative[..., :6],
        "velocity angular_velocity": rates[1],
        "acceleration angular_acceleration": rates[2],
        "foundation_translation foundation_rotation": motion[..., 6:],
    }
    found: dict[str, Bounded] = {}
    for names, part in pairs.items():
        along, about = names.split()
        found |= {along: part[..., :3], about: part[..., 3:]}
    at_mounts = {"deflection": deflection, "mount_force": system.force(deflection, frequency)}
    for name, part in at_mounts.items():
        found[name] = reshaped(part, lambda one: np.moveaxis(one, -1, -3))
    for name, part in zip(QUANTITIES, rates, strict=True):
        found[f"point_{name}"] = part @ rows.T
    return {name: part for name, part in found.items() if part.value.size}


# ----------------------------------------------------------------------------
# Harmonics of the base, one by one: they have no common period, so that peaks are sums.
# ----------------------------------------------------------------------------


def _emit_harmonics(
    scene: Scene, system: OnMounts, rows: FloatArray, given: BaseMotion, axes: dict[str, Any]
) -> None:
    names, (frequency, base) = [one.name for one in given.harmonics], harmonics_of(scene.case)
    relative, motion = system.moved_by_base(base, frequency)
    lost = uncertain(system.matrices.mass, relative)
    if np.any(lost):
        place = int(np.argmax(lost))
        raise NumericalFailure(
            f"harmonic {names[place]!r} of the base at {frequency[place] / _TURN:.6g} Hz meets an "
            "undamped natural frequency of the machine on its mounts: there is no steady motion; "
            "give the mounts damping or a loss factor, or another frequency"
        )
    axes = {**axes, "base_harmonic": names}
    scene.emit(f"{HARMONIC}/frequency", frequency, axes=axes)
    for name, part in _responses(system, rows, relative, motion, frequency).items():
        over, by_harmonic = RESPONSES[name][2], part
        if over != "direction":
            by_harmonic = reshaped(part, lambda one: np.moveaxis(one, 0, -1))
        scene.emit(f"{HARMONIC}/{name}", by_harmonic, axes=axes)
        if name in PEAKS:
            size = _longest(part) if over == "mount direction" else abs(part)
            scene.emit(f"{HARMONIC}/{name}_peak", size.sum(0), axes=axes)


def _longest(vector: Bounded) -> Bounded:
    """Largest length (...) over the cycle of vectors (..., 3) of one frequency."""
    found = vector_cycle_peak(vector.value[..., None], [1])
    return Bounded(found.value, found.error + vector.norm().error)


# ----------------------------------------------------------------------------
# Spectra of the base: mean squares of directions that know nothing of each other add.
# ----------------------------------------------------------------------------


def _emit_spectra(
    scene: Scene, system: OnMounts, rows: FloatArray, given: BaseMotion, axes: dict[str, Any]
) -> None:
    densities = [density_of(one, given.interpolation) for one in given.spectra]
    chosen = [COORDINATES.index(one.direction) for one in given.spectra]
    base = at_reference(given.point)[:, chosen]
    ratio, natural = system.damping_ratio().value, system.shapes.natural_frequency
    _require_damping(system, ratio, base, densities)

    def powers(frequency: FloatArray) -> dict[str, FloatArray]:
        """Densities (frequencies, own axes) of each response; unit accelerations of the base."""
        unit = Bounded(-base.T[:, None] / np.square(frequency)[:, None], np.zeros(()))
        found = {"base_acceleration": base[:3].T[:, None] + 0.0 * frequency[:, None]}
        moved = system.moved_by_base(unit, frequency)
        for name, part in _responses(system, rows, *moved, frequency).items():
            if not name.startswith("foundation"):
                found[name] = part.value
        weight = np.stack([one.at(frequency) for one in densities])
        return {
            name: np.einsum("sf...,sf->f...", np.square(np.abs(part)), weight)
            for name, part in found.items()
        }

    ends = panel_ends(densities, natural, ratio)
    squares = mean_squares(powers, ends, min(scene.case.accuracy.rtol, 1e-6))
    for name, part in squares.items():
        rms = bounded.sqrt(part)
        scene.emit(f"{SPECTRUM}/{name}_rms", rms, axes=axes)
        if name in RESPONSES:
            scene.emit(f"{SPECTRUM}/{name}_peak", rms * given.peak_factor, axes=axes)
    drawn = curve_frequencies(ends, natural)
    found, axes = powers(drawn), {**axes, "base_frequency": drawn / _TURN}
    for name, of in (("base_density", "base_acceleration"), ("density", "acceleration")):
        scene.emit(f"{SPECTRUM}/{name}", found[of].T, 1e-11 * np.max(found[of]), axes)
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
