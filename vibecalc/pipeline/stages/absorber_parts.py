"""Adapter: rod, springs, ring, gap and oils of an absorber, and what to buy for its tuning."""

import numpy as np

from vibecalc.hardware.gap import gap_shares, viscosity_for_damping
from vibecalc.hardware.oils import oil_damping
from vibecalc.hardware.overhung_rod import bending_frequencies, whirl_frequencies
from vibecalc.hardware.rayleigh import rayleigh_frequency
from vibecalc.hardware.rings import ring_inertia
from vibecalc.hardware.rods import torsional_stiffness
from vibecalc.hardware.spring_couple import rate_for_couple
from vibecalc.machine.absorber import AbsorberParts, build_absorber
from vibecalc.machine.absorber_hardware import Bending
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.absorber_parts import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber_stock import Held, emit_stock, emit_stock_in_line
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks


def run(scene: Scene) -> None:
    """Emit what the parts give, what the tuning asks of them, and the best parts in stock."""
    parts = build_absorber(scene.case)
    _emit_rod(scene, parts)
    if parts.bending is not None:
        _emit_bending(scene, parts.bending)
    if parts.scale is None or parts.absorber is None:
        return
    own = parts.scale.frequency
    scene.emit(f"{ROOT}/primary_frequency", own, 8.0 * EPSILON * own)
    _emit_built(scene, parts)
    _emit_gap(scene, parts)
    tuned: Absorber | None = scene.handed_on.get("tuned")
    if tuned is not None:
        _emit_wanted(scene, parts, tuned)
    if not parts.scale.torsion:
        emit_stock_in_line(scene, parts, tuned)
    held = None if parts.filling is None else emit_stock(scene, parts, tuned)
    if held is not None:
        _emit_warming(scene, parts, held)


def _emit_rod(scene: Scene, parts: AbsorberParts) -> None:
    machine = scene.case.machine
    rod, ring = machine.rod, machine.ring
    if rod is not None and rod.length is not None and rod.shear_modulus is not None:
        found = torsional_stiffness(rod.shear_modulus, rod.diameter, rod.length, rod.bore)
        scene.emit(f"{ROOT}/rod_stiffness", found.value, found.error)
        scene.cite(
            "torsion of a round rod", "stiffness of the primary", "Baca Vasquez (2007), section 3.7"
        )
    if ring is not None:
        inertia = ring_inertia(ring.density, ring.outer_radius, ring.inner_radius, ring.width)
        scene.emit(f"{ROOT}/ring_mass", inertia.mass.value, inertia.mass.error)
        scene.emit(f"{ROOT}/ring_inertia", inertia.polar.value, inertia.polar.error)


def _emit_bending(scene: Scene, given: Bending) -> None:
    modes = {"mode": np.arange(1, given.modes + 1)}
    found = bending_frequencies(given.rod, given.body, given.modes)
    scene.emit(f"{ROOT}/bending/frequency", found.value, found.error, modes)
    if given.spin:
        whirl = whirl_frequencies(given.rod, given.body, given.spin, given.modes)
        scene.emit(f"{ROOT}/bending/forward", whirl.forward.value, whirl.forward.error, modes)
        scene.emit(f"{ROOT}/bending/backward", whirl.backward.value, whirl.backward.error, modes)
    guess = rayleigh_frequency(given.rod, given.body)
    scene.emit(f"{ROOT}/bending/rayleigh", guess.value, guess.error)
    scene.cite(
        "characteristic determinant of an overhung beam with a rigid body on its end",
        "bending of the rod",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), section 3.16, for the quotient",
    )


def _emit_built(scene: Scene, parts: AbsorberParts) -> None:
    """Springs and oil that are in, and the response that they make."""
    if parts.scale is None or parts.absorber is None:
        return
    z1, m, k, _ = (float(np.asarray(part)) for part in parts.absorber)
    springs = parts.springs
    if springs is not None and springs.rate is not None and springs.stiffness is not None:
        ratio = springs.stiffness / parts.scale.stiffness
        scene.emit(f"{ROOT}/built/stiffness_ratio", ratio, 40.0 * EPSILON * ratio)
        scene.emit(f"{ROOT}/built/spring_rate", springs.rate, 16.0 * EPSILON * springs.rate)
    filled = parts.filling
    if filled is None or filled.oil is None:
        return
    found = oil_damping(filled.oil, filled.gap, filled.temperature)
    size = found.value / parts.scale.damping
    error = found.error / parts.scale.damping + 8.0 * EPSILON * size
    scene.emit(f"{ROOT}/built/secondary_damping", size, error)
    if not scene.wants(f"{ROOT}/built/peak", f"{ROOT}/built/peak_frequency"):
        return
    if springs is None or springs.rate is None:
        tuning = scene.case.tuning
        if tuning is None or tuning.kind not in ("viscous", "lanchester"):
            return
        k = 0.0
    pair = _pair(scene)
    top = peaks(Absorber(z1, m, k, float(size)), *pair)
    value = float(top.largest)
    doubt = float(top.largest_error) + 2.0 * value * (float(error / size) + 40.0 * EPSILON)
    scene.emit(f"{ROOT}/built/peak", value, doubt if np.isfinite(value) else 0.0)
    place = float(top.where) * parts.scale.frequency
    scene.emit(f"{ROOT}/built/peak_frequency", place, 1e-9 * place if np.isfinite(place) else 0.0)


def _emit_gap(scene: Scene, parts: AbsorberParts) -> None:
    filled = parts.filling
    if filled is None:
        return
    gap = filled.gap
    play = float(np.asarray(gap.rim_clearance))
    scene.emit(f"{ROOT}/clearance", play, 8.0 * EPSILON * play)
    shares = gap_shares(gap)
    error = float(shares.total.error)
    for name in ("rim", "sides", "bore"):
        scene.emit(f"{ROOT}/gap/{name}", float(getattr(shares, name)), error)
    scene.cite(
        "films between cylinders and at the sides of a ring",
        "damping from viscosity",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), equations 3.16, 3.17 and 3.19",
    )


def _emit_wanted(scene: Scene, parts: AbsorberParts, wanted: Absorber) -> None:
    """Rate of the springs and viscosity of the oil that the wanted tuning asks for."""
    scale, springs, filled = parts.scale, parts.springs, parts.filling
    if scale is None:
        return
    k, z2 = float(np.asarray(wanted.stiffness_ratio)), float(np.asarray(wanted.secondary_damping))
    if springs is not None:
        rate = rate_for_couple(k * scale.stiffness, springs.count, springs.radius, springs.angle)
        scene.emit(f"{ROOT}/spring_rate", rate.value, float(rate.error) + 1e-11 * float(rate.value))
    if filled is not None:
        thick = viscosity_for_damping(filled.gap, z2 * scale.damping)
        scene.emit(
            f"{ROOT}/dynamic_viscosity", thick.value, thick.error + 1e-11 * float(thick.value)
        )


def _pair(scene: Scene) -> tuple[str, str]:
    tuning = scene.case.tuning
    if tuning is None:
        return "force", "displacement"
    return tuning.excitation, tuning.response


def _emit_warming(scene: Scene, parts: AbsorberParts, held: Held) -> None:
    from vibecalc.pipeline.stages.absorber_warming import emit_warming

    tuning = scene.case.tuning
    if tuning is not None and tuning.temperatures is not None:
        emit_warming(scene, tuning, parts, held)
