"""The record of cases/roll_records.toml: a rigid plate in three harmonics, and what moves it.

    python tests/record_cases.py

writes the file anew.
"""

from pathlib import Path

import numpy as np

CASE = Path(__file__).resolve().parents[1] / "cases" / "roll_records.toml"
SEED = 3
RATE = 400.0  # Hz
SAMPLES = 1200
#: turns per second at the start, what it gains in a second, angle at the start in rad
START, GAIN, AHEAD = 15.0, 0.4, 1.1
#: order -> translation m/s^2, roll and pitch rad/s^2, complex against the pulse
MOTION = {
    1: (0.6 * np.exp(0.5j), 7.0 * np.exp(2.0j), 1.0 * np.exp(-1.0j)),
    2: (1.2 + 0.0j, 2.5 * np.exp(-0.7j), 1.5 * np.exp(2.5j)),
    3: (0.1 * np.exp(1.5j), 0.5 * np.exp(0.3j), 0.1 + 0.0j),
}
POSITIONS = {"1": (0.55, -0.27), "2": (0.55, 0.27), "3": (-0.55, -0.27), "4": (-0.55, 0.27)}
NOISE = 0.05  # m/s^2


def accelerations(angle: np.ndarray) -> np.ndarray:
    """Signals (4, n) of the four positions."""
    found = np.zeros((len(POSITIONS), angle.size))
    for order, (lift, roll, pitch) in MOTION.items():
        for place, (x, y) in enumerate(POSITIONS.values()):
            amplitude = lift + y * roll - x * pitch
            found[place] += np.real(amplitude * np.exp(1j * order * (angle - np.pi / 2)))
    return found


def rows() -> list[str]:
    """Lines of the file; the tachometer rises through zero where the angle is a quarter turn."""
    times = np.arange(SAMPLES) / RATE
    angle = 2.0 * np.pi * (START * times + 0.5 * GAIN * times**2) + AHEAD
    signals = accelerations(angle)
    signals = signals + NOISE * np.random.default_rng(SEED).standard_normal(signals.shape)
    tachometer = -np.cos(angle)
    names = [f"a{name} [m/s^2]" for name in POSITIONS]
    lines = [", ".join(["time [s]", "tachometer", *names])]
    for place, time in enumerate(times):
        shown = [f"{one:.3f}" for one in signals[:, place]]
        lines.append(", ".join([f"{time:.4f}", f"{tachometer[place]:.4f}", *shown]))
    return lines


def text_of_record() -> str:
    """The whole file."""
    return "# made by tests/record_cases.py\n" + "\n".join(rows()) + "\n"


if __name__ == "__main__":
    CASE.with_suffix(".csv").write_text(text_of_record(), encoding="utf-8")
