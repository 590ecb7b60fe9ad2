"""Dampings of a shaft line that follow speed, load or a mode, as results."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: dampings of stations and sections on their own shafts, at one speed and over speeds.
# ----------------------------------------------------------------------------

#: of a law with a power, a table between entries, and what is referred and brought back
ROUNDINGS = 16.0


def _own(setup: Setup, speed: FloatArray | float) -> tuple[Bounded, Bounded, Bounded]:
    """Absolute dampings (..., s), dashpots and loss factors (..., e) at speeds (...)."""
    shaft = setup.shaft
    line = shaft.at(speed)
    found = (
        shaft.station_damping(speed) / shaft.station_ratio**2,
        line.damping / shaft.section_ratio**2,
        line.loss_factor,
    )
    station, dashpot, loss = (rounded(one, ROUNDINGS) for one in found)
    return station, dashpot, loss


def emit_dampings(scene: Scene, setup: Setup) -> None:
    """Those at the operating speed, where they are more than numbers of the case."""
    shaft = setup.shaft
    if not shaft.station_laws or setup.torsion.damping_model is not None:
        return
    axes = {"station": shaft.station_names, "section": shaft.section_names}
    for name, value in zip(
        ("station", "section", "loss_factor"), _own(setup, setup.speed), strict=True
    ):
        scene.emit(f"{ROOT}/damping/{name}", value, axes=axes)


def emit_damping_curves(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Those over speeds (s,) that follow them."""
    shaft, follow = setup.shaft, setup.model.over_speed
    if follow is None:
        return
    station, dashpot, loss = _own(setup, speed)
    moving = [n for n, laws in enumerate(shaft.station_laws) if any(one.follows for one in laws)]
    for name, axis, names, places, value in (
        ("station_damping", "station", shaft.station_names, moving, station),
        ("section_damping", "section", shaft.section_names, list(follow.element), dashpot),
        ("section_loss_factor", "section", shaft.section_names, list(follow.lossy), loss),
    ):
        if places:
            axes = {axis: tuple(names[n] for n in places), "speed": speed}
            value = Bounded(*(np.broadcast_to(one, (len(speed), one.shape[-1])) for one in value))
            scene.emit(f"{ROOT}/speeds/{name}", value[:, places].T, axes=axes)
