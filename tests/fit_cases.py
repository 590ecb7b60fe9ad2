"""The measured points of cases/generator_mount_fit.toml, made from its truth with seeded noise.

    python tests/fit_cases.py

prints them.
"""

import re
from pathlib import Path

import numpy as np

from vibecalc.core.results.select import scalar
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked

CASE = Path(__file__).resolve().parents[1] / "cases" / "generator_mount_fit.toml"
TRUTH = {
    "machine.mounts.each.stiffness": 85.0e3,
    "machine.mounts.each.damping": 420.0,
    "machine.body.inertia[1]": 7.2,
}
SEED = 5
#: quantity, entries of speed in rpm, unit as written, over the SI unit, relative noise, digits
POINTS = (
    ("isolation/pitch/natural_frequency", {}, 2.0 * np.pi, 0.01, 4),
    ("isolation/support_displacement/vertical_peak", {"mount": "1"}, 1e-3, 0.02, 4),
    ("isolation/support_displacement/vertical_peak", {"mount": "3"}, 1e-3, 0.02, 4),
    *(
        ("isolation/support_force/run_up", {"mount": "1", "speed": f"{speed} rpm"}, 1.0, 0.02, 4)
        for speed in (600, 700, 800, 900, 1000, 1200, 1400)
    ),
)


def measured(seed: int = SEED) -> list[float]:
    """Values of `POINTS` for the truth with noise, rounded as they are written."""
    settings = [f"{key}={value}" for key, value in TRUTH.items()]
    record = run_case(load_checked([CASE], settings, ["fit"])[0].case)
    noise = np.random.default_rng(seed).standard_normal(len(POINTS))
    found = []
    for (path, where, unit, share, digits), one in zip(POINTS, noise, strict=True):
        value = float(scalar(record[path], where)) / unit * (1.0 + share * one)
        found.append(float(f"{value:.{digits}g}"))
    return found


def text_with(text: str, values: list[float]) -> str:
    """The case with other measured values."""
    first, *others = values
    text = re.sub(r'value = "[\d.]+ Hz"', f'value = "{first} Hz"', text)
    for before, found in (('entry = ["1", "3"]\n', others[:2]), ('"1400 rpm"]\n', others[2:])):
        start, _, rest = text.partition(f"{before}value = ")
        text = f"{start}{before}value = {found}{rest[rest.index(']') + 1 :]}"
    return text


if __name__ == "__main__":
    for point, value in zip(POINTS, measured(), strict=True):
        print(*point[:2], value)
