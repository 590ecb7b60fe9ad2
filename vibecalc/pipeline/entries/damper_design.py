"""Results of the search for the damper of a shaft line.

The damper's values are own ones, of the shaft that it hangs on. What is made small is the largest
half range over the cycle of all sections that count at all speeds of the range.
"""

from vibecalc.pipeline.entries.entry import Entry, entry

ROOT = "damper_design/"
#: objective -> unit
OBJECTIVES = {"torque": "N*m", "twist": "rad", "stress": "Pa"}


def _seen(stem: str, whose: str) -> tuple[Entry, ...]:
    """What one damper does over the range of speeds."""
    each = tuple(
        entry(f"{ROOT}{stem}worst_{name}", "", unit, f"largest half range, {whose}")
        for name, unit in OBJECTIVES.items()
    )
    return (
        *each,
        entry(f"{ROOT}{stem}worst_section", "", "", "where that is, counted from 1"),
        entry(f"{ROOT}{stem}worst_speed", "", "rad/s", "where that is"),
        entry(f"{ROOT}{stem}heat", "", "W", f"mean power at its own worst speed, {whose}"),
        entry(f"{ROOT}{stem}heat_speed", "", "rad/s", "where that is"),
        entry(f"{ROOT}{stem}travel", "", "rad",
              f"of the ring against its station, at its own worst speed, {whose}"),
        entry(f"{ROOT}{stem}travel_speed", "", "rad/s", "where that is"),
    )  # fmt: skip


def _by_objective(stem: str, axes: str, words: str) -> tuple[Entry, ...]:
    return tuple(
        entry(f"{ROOT}{stem}{name}", axes, unit, words) for name, unit in OBJECTIVES.items()
    )


_MAP = "chart_stiffness chart_damping"
ENTRIES = (
    entry(f"{ROOT}inertia", "", "kg*m^2", "of the ring"),
    entry(f"{ROOT}stiffness", "", "N*m/rad", "of its springs; 0: none"),
    entry(f"{ROOT}damping", "", "N*m*s/rad", "viscous"),
    entry(f"{ROOT}own_frequency", "", "rad/s", "of the ring on its springs, station held"),
    entry(f"{ROOT}own_damping", "", "", "damping over twice the root of stiffness times inertia"),
    *_seen("", "with the damper found"),
    *_seen("table/", "with the table value"),
    entry(f"{ROOT}table/gain", "", "", "worst of the table value over that of the damper found"),
    entry(f"{ROOT}active/kind", "active", "", "0: a section, 1: heat, 2: travel"),
    entry(f"{ROOT}active/section", "active", "", "the section, counted from 1; 0: none"),
    entry(f"{ROOT}active/speed", "active", "rad/s", "of the summit"),
    entry(f"{ROOT}active/level", "active", "", "over the worst half range, or over the limit"),
    entry(f"{ROOT}active/weight", "active", "",
          "of the summit in the proof; of a limit: its price, relative fall for relative rise"),
    entry(f"{ROOT}pull", "design_value", "",
          "slope of the optimum by the logarithm of a bound that holds it; 0: none does"),
    entry(f"{ROOT}certificate", "", "", "what is left of the weighted slopes, over the worst"),
    entry(f"{ROOT}curvature", "", "",
          "least one along what the summits leave free; above 0: a minimum"),
    entry(f"{ROOT}basin/stiffness", "basin", "N*m/rad", "end of a descent"),
    entry(f"{ROOT}basin/damping", "basin", "N*m*s/rad", "end of a descent"),
    entry(f"{ROOT}basin/worst", "basin", "", "there, over that of the damper found"),
    entry(f"{ROOT}sensitivity", "stiffness_factor damping_factor", "",
          "worst with so many times stiffness and damping, over the best"),
    *_by_objective("chart/", _MAP, "largest half range, read on a grid of speeds"),
    entry(f"{ROOT}chart/heat", _MAP, "W", "mean power at its worst speed"),
    entry(f"{ROOT}chart/travel", _MAP, "rad", "at its worst speed"),
    *_by_objective("ring/", "ring_inertia", "largest half range with the best damper of that ring"),
    entry(f"{ROOT}ring/stiffness", "ring_inertia", "N*m/rad", "of that damper"),
    entry(f"{ROOT}ring/damping", "ring_inertia", "N*m*s/rad", "of that damper"),
    *_by_objective("curve/", "damper_curve speed",
                   "half range of the section that is largest at this speed"),
)  # fmt: skip
