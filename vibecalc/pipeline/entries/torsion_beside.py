"""Results of the same shaft line in another state: without its dampers, or with all gas.

Names and meanings are those of the line itself.
"""

from vibecalc.pipeline.entries.entry import Entry, entry

ROOT = "response/torsion"
_CURVE = "section speed"
_BARE, _HEALTHY = "the line without its dampers", "all cylinders firing"


def _half_ranges(place: str, words: str) -> tuple[Entry, ...]:
    here, top = f"{words}, at the operating speed", f"{words}, at any speed of the range"
    return (
        entry(f"{place}/torque_half_range", "section", "N*m", here),
        entry(f"{place}/twist_half_range", "section", "rad", here),
        entry(f"{place}/stress_half_range", "section", "Pa", here),
        entry(f"{place}/speeds/torque_half_range", _CURVE, "N*m", words),
        entry(f"{place}/speeds/twist_half_range", _CURVE, "rad", words),
        entry(f"{place}/speeds/stress_half_range", _CURVE, "Pa", words),
        entry(f"{place}/largest/torque_half_range", "section", "N*m", top),
        entry(f"{place}/largest/twist_half_range", "section", "rad", "there"),
        entry(f"{place}/largest/stress_half_range", "section", "Pa", "there"),
        entry(f"{place}/largest/speed", "section", "rad/s", "where that is"),
    )


ENTRIES = (
    *_half_ranges(f"{ROOT}/bare", _BARE),
    entry(f"{ROOT}/bare/natural_frequency", "bare_mode", "rad/s", "without its dampers"),
    entry(f"{ROOT}/reduction", "section", "", "largest torque without dampers over that with them"),
    *_half_ranges(f"{ROOT}/healthy", _HEALTHY),
    entry(f"{ROOT}/healthy/mean_torque", "", "N*m", "of all cylinders, all firing"),
    entry(f"{ROOT}/healthy/damper/heat", "damper", "W", f"mean power, {_HEALTHY}"),
    entry(f"{ROOT}/healthy/damper/travel", "damper", "rad", f"largest magnitude, {_HEALTHY}"),
    entry(f"{ROOT}/healthy/limit/operating_use", "limit", "",
          f"stress over allowed at the operating speed, {_HEALTHY}"),
    entry(f"{ROOT}/healthy/limit/largest_use", "limit", "",
          f"largest stress over allowed, at any speed, {_HEALTHY}"),
)  # fmt: skip
