"""Adapter: the same shaft line without its dampers, at the same speeds."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.beside import State, emit_operating, emit_range
from vibecalc.pipeline.stages.torsion.setup import Setup, build_model, natural_of

BARE = f"{ROOT}/bare"


def bare_setup(setup: Setup) -> Setup:
    """The line without rings and what holds them; hubs belong to their stations and stay."""
    shaft, line = setup.shaft, setup.shaft.line
    stays = np.array([kind != "damper" for kind in shaft.section_kinds])
    count = len(line.inertia) - len(shaft.dampers)
    bare = line._replace(
        inertia=line.inertia[:count],
        absolute_damping=line.absolute_damping[:count],
        ground_stiffness=line.ground_stiffness[:count],
        first=line.first[stays],
        second=line.second[stays],
        stiffness=line.stiffness[stays],
        damping=line.damping[stays],
        loss_factor=line.loss_factor[stays],
    )
    torsion, speed = setup.torsion, setup.speed
    model, modes = build_model(torsion, bare, shaft.speed_stiffness[stays], speed, count)
    natural = natural_of(torsion, model, modes, speed)
    return setup._replace(model=model, modes=modes, natural=natural)


def emit_bare(
    scene: Scene, setup: Setup, speed: FloatArray, damped: FloatArray, damped_error: FloatArray
) -> None:
    """Curves and largest values without dampers; how much less they are with them.

    `damped` (e,) are the largest referred torques of the whole line, `damped_error` their errors.
    """
    bare, shaft = bare_setup(setup), setup.shaft
    stays = np.flatnonzero([kind != "damper" for kind in shaft.section_kinds])
    state = State(BARE, bare, stays)
    frequency = bare.modes.frequency
    modes = {"bare_mode": np.arange(1, len(frequency) + 1)}
    scene.emit(f"{BARE}/natural_frequency", frequency, bare.modes.frequency_error, modes)
    emit_operating(scene, state)
    found = emit_range(scene, state, speed)
    ratio = np.abs(shaft.section_ratio[stays])
    value, error = found.top.value / ratio, found.own.torque / ratio
    own, own_error = damped[stays] / ratio, damped_error[stays] / ratio
    finite = np.isfinite(own) & np.isfinite(value) & (own > 0.0)
    safe = np.where(finite, own, 1.0)
    gain = np.where(finite, np.where(finite, value, 0.0) / safe, np.inf)
    off = np.where(finite, (error + np.where(finite, gain, 0.0) * own_error) / safe, 0.0)
    axes = {"section": tuple(shaft.section_names[e] for e in stays)}
    scene.emit(f"{ROOT}/reduction", gain, off, axes)
