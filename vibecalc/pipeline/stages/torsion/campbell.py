"""Adapter: natural frequencies of a shaft line against the speed, where pendulums change them."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup, line_modes
from vibecalc.response.torsion.modes import natural_modes

PATH = f"{ROOT}/campbell/natural_frequency"
#: speeds at most; the curves are smooth
MOST = 101


def emit_campbell(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Modes at some of the speeds (s,), both ends included, if the case asks for them."""
    if not setup.torsion.campbell or not np.any(setup.model.speed_stiffness):
        return
    if not scene.wants(PATH):
        return
    chosen = np.unique(np.linspace(0, len(speed) - 1, min(MOST, len(speed))).round().astype(int))
    at = speed[chosen]
    found = [
        line_modes(setup.torsion, setup.model, natural_modes(setup.model.at(one)), one)
        for one in at.tolist()
    ]
    frequency = np.array([one.frequency for one in found]).T
    error = np.array([one.frequency_error for one in found]).T
    axes = {"mode": np.arange(1, len(frequency) + 1), "speed": at}
    scene.emit(PATH, frequency, error, axes)
