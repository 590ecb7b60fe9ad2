"""Seeded random readings on plates, as case tables: five or more levels, or amplitude and phase."""

from itertools import combinations
from typing import Any

import numpy as np
from random_machines import Table

RTOLS = (1e-3, 1e-6, 1e-9, 1e-12)
ORDERS = (1, 2)


def random_measured_plate(seed: int) -> Table:
    """A whole case for `validate`; readings are rounded to their last digit."""
    random = np.random.default_rng([seed, 13])
    size = np.exp(random.uniform(np.log(0.1), np.log(3.0)))
    places = {f"p{n}": (size * random.uniform(-1.0, 1.0, 2)).tolist() for n in range(8)}
    motions = [
        np.exp(random.uniform(-3.0, 3.0)) * (random.normal(size=3) + 1j * random.normal(size=3))
        for _ in ORDERS
    ]
    motions = [motion / np.array([1.0, size, size]) for motion in motions]
    table: Table = {
        "amplitude": str(random.choice(["zero_to_peak", "rms"])),
        "reference_level": float(random.choice([1.0, 1e-5])),
        "orders": list(ORDERS),
        "base_frequency": 90.0,
        "reference_position": "p0",
        "positions": [{"name": name, "x": x, "y": y} for name, (x, y) in places.items()],
        "plate": {"x": [-size, size], "y": [-size, size], "points": 5},
    }
    if seed % 2:
        table |= _phased(random, places, motions)
    else:
        table["readings"] = _levels(random, places, motions, table["reference_level"])
    return {
        "schema": 1,
        "title": f"random plate {seed}",
        "machine": {"kind": "plate"},
        "measurement": table,
        "accuracy": {"rtol": float(random.choice(RTOLS))},
    }


def _row(one: list[float], other: list[float] | None = None) -> np.ndarray:
    if other is None:
        return np.array([1.0, one[1], -one[0]])
    return np.array([0.0, other[1] - one[1], one[0] - other[0]])


def _phased(random: np.random.Generator, places: dict[str, Any], motions: list[Any]) -> Table:
    """Amplitudes and phases at four or more points, whose noise is about their last digit."""
    names = list(places)[: int(random.integers(4, 9))]
    readings = []
    step = 1e-3 * float(np.abs(motions[0][0]))
    for name in names:
        signals = np.array([_row(places[name]) @ motion for motion in motions])
        signals = signals + step * (random.normal(size=2) + 1j * random.normal(size=2))
        readings.append(
            {"at": name, "amplitude": np.abs(signals).tolist(), "phase": np.angle(signals).tolist()}
        )
    return {"readings": readings, "amplitude_step": step, "phase_step": 1e-3}


def _levels(
    random: np.random.Generator, places: dict[str, Any], motions: list[Any], reference: float
) -> list[Table]:
    """Five levels that one or two motions have, or some more that contradict each other a bit."""
    pairs = list(combinations(list(places)[:5], 2))
    chosen = [pairs[n] for n in random.permutation(len(pairs))[:2]]
    rows: list[tuple[Table, np.ndarray]] = [
        ({"at": name}, _row(places[name])) for name in ("p0", "p1", "p2")
    ]
    rows += [({"between": list(p)}, _row(places[p[0]], places[p[1]])) for p in chosen]
    rows += [
        ({"at": name}, _row(places[name])) for name in ("p3", "p4", "p5")[: int(random.integers(4))]
    ]
    readings = []
    for words, row in rows:
        levels = [20.0 * np.log10(abs(row @ motion) / reference) for motion in motions]
        readings.append(words | {"level": np.round(levels, 1).tolist()})
    return readings
