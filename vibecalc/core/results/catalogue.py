"""Every result path with its unit, axes, amplitude kind and long name: said once, here.

Adapters hand over arrays and errors under these paths; the file, the report, references, limits
and `check` read the rest from this table. The entries stand in `results.py` of each subject.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from vibecalc.core.results.record import ORDERS, RESONANCE, Entry
from vibecalc.subjects import SUBJECTS

#: axis name -> (unit, long name): those of several subjects, and those of each
AXES: dict[str, tuple[str, str]] = {
    "order": ("", "multiple of crank speed"),
    "direction": ("", "axis of the machine"),
    "cylinder": ("", "cylinder"),
    "speed": ("rad/s", "crank speed"),
    "mode": ("", "mode, lowest first"),
    "coordinate": ("", "coordinate of the rigid body"),
    "crank_angle": ("rad", "crank angle"),
    "frequency_ratio": ("", "excitation frequency over natural frequency"),
    "resonance_skipped": ("", "interval of speeds left out"),
    "method": ("", "method"),
    "pole": ("", "pole, rightmost first"),
    "peak": ("", "maximum, from low to high frequency"),
    "active": ("", "peak that holds the optimum, from low to high frequency"),
}
#: axis name -> names of its entries, where they are the same in every case
NAMES: dict[str, tuple[str, ...]] = {}
#: path -> subject that it belongs to
OWNER: dict[str, str] = {}
CATALOGUE: dict[str, Entry] = {}
#: beginning of paths -> what lets such results meet the tolerance; the longest that fits counts
HELPS: dict[str, tuple[str, ...]] = {"optimisation/": (ORDERS, RESONANCE)}
#: results of studies that hang on the path of the search, as those entries which say `diagnostic`
DIAGNOSTICS = (
    "*/evaluations",
    "*/failures",
    "*/kkt_residual",
    "optimisation/history/*",
    "optimisation/optima/*",
    "fit/search_chi_square",
)
#: angles of the case that studies change: the same after a turn
TURNING = (
    "optimisation/variable/*",
    "optimisation/front/variable/*",
    "fit/value/*",
    "find/*/value",
    "find/*/written",
    "find/*/others",
    "find/*/scaled_with/*",
)
#: (curve over the speeds, "max" or "min") -> the largest, or least, of it at any speed
EXTREMES: dict[tuple[str, str], str] = {}
#: a largest value -> the maxima of which it is one, where it is no end of its curve
MAXIMA: dict[str, str] = {}
#: subject -> what judges its own limits, those of rules and makers: a function of a result
JUDGES: dict[str, str] = {}
for _subject in SUBJECTS:
    _results = import_module(f"vibecalc.{_subject}.results")
    AXES |= getattr(_results, "AXES", {})
    NAMES |= getattr(_results, "NAMES", {})
    for _entry in _results.ENTRIES:
        CATALOGUE[_entry.path] = _entry
        OWNER[_entry.path] = _subject
    HELPS |= getattr(_results, "HELPS", {})
    EXTREMES |= getattr(_results, "EXTREMES", {})
    MAXIMA |= getattr(_results, "MAXIMA", {})
    JUDGES |= {_subject: _results.JUDGE} if hasattr(_results, "JUDGE") else {}
#: path -> how it stands in the first table of a report, in the order of that table
HEADLINES = {path: one.headline for path, one in CATALOGUE.items() if one.headline}


def deciding(path: str, where: Mapping[str, Any], side: str) -> str:
    """The result that a bound on a curve is held against: its extreme at any speed of the range.

    The curve itself where `where` names a speed, or it has no such extreme.
    """
    return path if "speed" in where else EXTREMES.get((path, side), path)


def speed_path(extreme: str) -> str:
    """Where the speeds stand at which the extremes of curves are met."""
    own = f"{extreme}_speed"
    return own if own in CATALOGUE else f"{extreme.rpartition('/')[0]}/speed"
