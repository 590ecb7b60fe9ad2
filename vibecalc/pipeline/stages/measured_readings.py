"""What instruments read beside what the motion found gives them."""

import numpy as np

from vibecalc.measurement.complex_motion import over_deviations
from vibecalc.measurement.level import DECIBEL, level_of
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.measured_motion import Found

#: roundings of a level on its way to an amplitude and back
_READ = 8.0 * EPSILON


def emit_readings(scene: Scene, found: list[Found]) -> None:
    """Emit levels read and computed, and of readings with a phase how far the motion is off."""
    levels: list[tuple[str, int, float, float, float]] = []
    signals: list[tuple[str, int, float, float]] = []
    for one in found:
        order = one.harmonic.order
        for read in one.harmonic.reads:
            value, error = one.signal(read.row)
            if read.amplitude > 0.0:
                computed, off = level_of(value, error, read.reference)
                own, _ = level_of(read.amplitude, 0.0, read.reference)
                levels.append((read.name, order, float(own), float(computed), float(off)))
            if read.phase is not None:
                shown = read.amplitude * np.exp(1j * read.phase)
                deviations = np.array([[read.deviation], [read.across[1]]])
                shift = np.array([complex(value) - shown])
                apart = float(over_deviations(shift, np.array([shown]), deviations)[0])
                rounding = float(error) + 8.0 * EPSILON * read.amplitude
                rounding /= float(np.min(deviations))
                signals.append((read.name, order, apart, rounding))
    if levels:
        names, orders, own_, computed_, off_ = (
            np.array(column) for column in zip(*levels, strict=True)
        )
        axes = {"reading": _unique([str(name) for name in names])}
        scene.emit("measurement/reading/order", orders, 0.0, axes)
        known = _READ * (np.abs(own_) + DECIBEL)
        scene.emit("measurement/reading/read", own_, known, axes)
        scene.emit("measurement/reading/computed", computed_, off_, axes)
        scene.emit("measurement/reading/residual", computed_ - own_, off_ + known, axes)
    if signals:
        names, orders, apart_, error_ = (np.array(column) for column in zip(*signals, strict=True))
        axes = {"signal": _unique([str(name) for name in names])}
        scene.emit("measurement/signal/order", orders, 0.0, axes)
        scene.emit("measurement/signal/residual", apart_, error_, axes)


def _unique(names: list[str]) -> np.ndarray:
    """Names as entries of an axis; a second instrument at one place gets a number."""
    seen: dict[str, int] = {}
    entries = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        entries.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return np.array(entries, dtype=object)
