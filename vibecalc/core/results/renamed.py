"""Names that cases and results had before, and what they are called now: one table for all.

`diagnose` says of an unknown key what it is called now, `migrate` rewrites cases by it, and paths
and axes of earlier result files are read under the names that they have now.
"""

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from vibecalc.errors import KeyPath

#: damping of an absorber, c2 / (2 sqrt(K1 J1)) and c2 / (2 J2 w2). Neither was named
#: `damping_ratio` anew, so that no older case gets another meaning
_OVER_PRIMARY, _OF_ABSORBER = "damping_over_primary_critical", "absorber_damping_ratio"
#: name now -> what else a reader of the old name may have meant
_MEANT = {_OVER_PRIMARY: f", of the primary (the absorber's own is `{_OF_ABSORBER}`)"}
#: tables with bounds of a number
_BOUNDED = ("variables", "find", "distribution", "tune.gain", "tune.acceleration_feedback")
#: end of the place of a key, positions in lists left out -> its name now
KEYS: dict[str, str] = {
    "crank_train.stroke": "stroke_axis",
    "shaft_line.load": "balanced_by",
    "shaft_line.loads": "absorbed_torques",
    "machine.secondary.damping_ratio": _OVER_PRIMARY,
    "machine.secondary.own_damping_ratio": _OF_ABSORBER,
    "machine.secondaries.damping_ratio": _OVER_PRIMARY,
    "machine.secondaries.own_damping_ratio": _OF_ABSORBER,
    "tuning.bounds.damping_ratio": _OVER_PRIMARY,
    "absorber.vary.secondary_damping": _OVER_PRIMARY,
    "absorber.vary.own_damping": _OF_ABSORBER,
    **{f"{table}.lower": "min" for table in _BOUNDED},
    **{f"{table}.upper": "max" for table in _BOUNDED},
    "find.seek": "sense",
    "find.also": "scaled_with",
    "stock.also": "further_tables",
    "variables.with": "followed_by",
    "axes.with": "in_step",
    "switching.stand": "dwell",
    "switching.after": "time_after",
    "switching.settled": "settling_tolerance",
    "start_up.settled": "settling_tolerance",
    "torsion.transient.before": "time_before",
    "torsion.transient.after": "time_after",
    "torsion.curves.of": "quantities",
    "excitations.of": "orders_of",
    "fatigue.below": "below_knee",
    "motor.beyond": "extrapolation",
}
#: end of the place of a choice -> what it was called -> what it is called now
VALUES: dict[str, dict[str, str]] = {
    "machine.kind": {"generator": "machine"},
    "find.sense": {"minimum": "min", "maximum": "max"},
}
#: axis of a result -> its name now
AXES = {
    "half_order": "order",
    "masked": "resonance_skipped",
    "bare_mode": "mode_without_dampers",
    "secondary_damping": _OVER_PRIMARY,
}
#: axis of a result -> pattern of a whole entry of it -> what it is called now
ENTRIES: dict[str, dict[str, str]] = {
    "curve": {"own damping (.*)": r"absorber damping ratio \1"},
    "condition": {
        "(?!misfire of )(.*) misfires": r"misfire of cylinder \1",
        "(?!imbalance of )(.*) out of balance": r"imbalance of cylinder \1",
    },
}
#: field of a stored verdict -> its name now
VERDICT_FIELDS = {"use": "utilisation"}

#: a share of what is permitted; behind each of these, and alone in some folders
_USE = ("largest_use", "largest_use_speed", "operating_use", "unbarred_use")
_USED = ("coupling", "coupling/speeds", "limit/each", "limit/operating", "clutch", "balance/weight")
#: folders of results that have dampings of absorbers
_OF_ABSORBERS = (
    *("tuning", "tuning/each", "tuning/method", "tuning/sensitivity", "tuning/unbounded"),
    *("tuning/chart", "tuning/optimum", "tuning/tolerances/exact"),
    *("hardware/built", "hardware/oil", "hardware/damper", "hardware/warming"),
)
_TORQUE, _FORCE, _BODY = "isolation/torque_reaction", "isolation/support_force", "isolation/body"
#: parts of a result path -> what stands there now
PATHS = {
    "half_order": "order",
    "also": "scaled_with",
    "support_displacement/sag": "support_displacement/static",
    "support_displacement/excursion": "support_displacement/total",
    "lever_force": "couple_over_lever",
    "rigid_peak": "blocked_peak",
    "rigid_harmonics": "blocked_harmonics",
    f"{_TORQUE}/translation": f"{_BODY}/translation_harmonics",
    f"{_TORQUE}/rotation": f"{_BODY}/rotation_harmonics",
    f"{_TORQUE}/support_force": f"{_FORCE}/steady_harmonics",
    f"{_TORQUE}/support_force_peak": f"{_FORCE}/steady_peak",
    f"{_TORQUE}/mean_support_force": f"{_FORCE}/mean",
    f"{_TORQUE}/largest_load": f"{_FORCE}/largest_load",
    f"{_TORQUE}/minimum_load": f"{_FORCE}/minimum_load",
    "foundation/coupled/machine/translation": f"{_BODY}/translation_harmonics",
    "foundation/coupled/machine/rotation": f"{_BODY}/rotation_harmonics",
    "foundation/coupled/mount_force": f"{_FORCE}/steady_harmonics",
    **{f"{folder}/secondary_damping": f"{folder}/{_OVER_PRIMARY}" for folder in _OF_ABSORBERS},
    **{f"{folder}/own_damping": f"{folder}/{_OF_ABSORBER}" for folder in _OF_ABSORBERS},
    "isolation/masked": "isolation/resonances_skipped",
    "response/masked": "response/resonances_skipped",
    "torsion/masked": "torsion/resonances_skipped",
    "torsion/bare": "torsion/without_dampers",
    "transient_use": "passage_utilisation",
    **{old: old.replace("use", "utilisation") for old in _USE},
    **{f"{folder}/use": f"{folder}/utilisation" for folder in _USED},
}
_REWRITES = "`vibecalc migrate CASE` rewrites the case"
_NAME = re.compile(r"[A-Za-z_][\w-]*")
_ONE_SEARCH = (
    "[optimisation] has one search, with nothing to choose: leave out method and compare; "
    "`vibecalc accuracy` holds it against other methods"
)
#: keys that are gone -> what to do about them
GONE: dict[KeyPath, str] = {
    ("optimisation", "method"): _ONE_SEARCH,
    ("optimisation", "compare"): _ONE_SEARCH,
}


def current_path(path: str) -> str:
    """The path under which a result is found now."""
    return _in_a_path().sub(lambda old: PATHS[old[0]], path)


@lru_cache(maxsize=1)
def _in_a_path() -> re.Pattern[str]:
    """What finds the parts that have another name now."""
    parts = "|".join(sorted(map(re.escape, PATHS), key=len, reverse=True))
    return re.compile(f"(?<![^/])(?:{parts})(?![^/])")


def current_axis(name: str) -> str:
    """What an axis of a result is called now."""
    return AXES.get(name, name)


def current_entry(axis: str, entry: Any) -> Any:
    """What an entry of an axis, which is called so now, is called now."""
    patterns = ENTRIES.get(axis, {}) if isinstance(entry, str) else {}
    found = (re.fullmatch(old, entry) for old in patterns)
    old = next((one for one in found if one), None)
    return entry if old is None else old.expand(patterns[old.re.pattern])


def current_where(where: Any) -> Any:
    """A choice of entries with its axes, and these entries, as they are called now."""
    if not isinstance(where, Mapping):
        return where
    now = {current_axis(axis): entry for axis, entry in where.items()}
    return {axis: current_entry(axis, entry) for axis, entry in now.items()}


def current_name(path: KeyPath) -> str | None:
    """What the last key of a path is called now; None where it is called so still."""
    if not path or not isinstance(path[-1], str):
        return None
    names = [part for part in path if isinstance(part, str)]
    if names[-2:-1] == ["where"]:
        return AXES.get(names[-1])
    return next((KEYS[end] for end in _ends(names) if end in KEYS), None)


def current_choice(path: KeyPath, text: str) -> str | None:
    """What a choice at this place is called now; None where it is called so still."""
    names = [part for part in path if isinstance(part, str)]
    names[-1:] = [current_name(path) or name for name in names[-1:]]
    tables = (VALUES[end] for end in _ends(names) if end in VALUES)
    return next((table[text] for table in tables if text in table), None)


def renamed(path: KeyPath) -> str:
    """What the last key of a path is called now and what rewrites the case, or nothing."""
    now = current_name(path)
    return f"`{path[-1]}` is now `{now}`{_MEANT.get(now, '')}; {_REWRITES}" if now else ""


def renamed_choice(path: KeyPath, text: str) -> str:
    """What a choice at this place is called now and what rewrites the case, or nothing."""
    now = current_choice(path, text)
    return f'`{path[-1]} = "{text}"` is now `"{now}"`; {_REWRITES}' if now else ""


def current_key(key: str) -> str:
    """A key as `machine.mounts.each.stiffness` with all of its names as they are now."""
    names: list[str] = []

    def renamed(name: re.Match[str]) -> str:
        names.append(name[0])
        return current_name(tuple(names)) or name[0]

    return _NAME.sub(renamed, key)


def current_text(path: KeyPath, text: str) -> str:
    """A text of a case, as it is now: a choice, a key, the path of a result, an axis."""
    choice = current_choice(path, text)
    if choice is not None:
        return choice
    if path[-1:] == ("axis",):
        return current_axis(text)
    if path[-2:-1] == ("where",):
        return str(current_entry(current_axis(str(path[-1])), text))
    if "/" in text:
        return current_path(text)
    return current_key(text) if "." in text and not re.search(r"[\s/]", text) else text


def current_case(value: Any, path: KeyPath = ()) -> Any:
    """A case, as plain tables, or what stands at a place of it, with all names as they are now."""
    if isinstance(value, dict):
        return {
            current_name((*path, key)) or key: current_case(entry, (*path, key))
            for key, entry in value.items()
        }
    if isinstance(value, list):
        return [current_case(entry, path) for entry in value]
    return current_text(path, value) if isinstance(value, str) else value


def _ends(names: list[str]) -> list[str]:
    return [".".join(names[place:]) for place in range(len(names))]
