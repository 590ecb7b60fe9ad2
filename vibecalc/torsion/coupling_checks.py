"""Can what a case asks be answered of couplings that follow load, heat, frequency or vibration?"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.firing import is_separate, with_torque
from vibecalc.torsion.shaft_line_tables import crank_station, joints, section_names, speed_ratios

if TYPE_CHECKING:
    from vibecalc.schema import Case
    from vibecalc.torsion.coupling_tables import Coupling

# ----------------------------------------------------------------------------
# Questions that take one line for all speeds and frequencies, and have none here.
# ----------------------------------------------------------------------------

TORSION: KeyPath = ("response", "torsion")
SHAFTS: KeyPath = ("machine", "shaft_line", "shafts")
_FOLLOWS = {
    "over_mean_torque": "the mean torque",
    "over_temperature": "its own temperature",
    "over_frequency": "the frequency",
    "over_amplitude": "its vibratory torque",
}


def coupling_problems(case: "Case") -> list[Problem]:
    """Problems of couplings whose stiffness is not one number."""
    line = case.machine.shaft_line
    if line is None:
        return []
    varying = [
        (place, follows)
        for place, shaft in enumerate(line.shafts)
        if shaft.coupling is not None and (follows := what_it_follows(shaft.coupling))
    ]
    return [*_asked(case, varying), *_loops(case)] if varying else []


def what_it_follows(coupling: "Coupling") -> list[str]:
    """Keys of the rows that its stiffness and damping follow; a given temperature is one number."""
    found = [key for key in _FOLLOWS if getattr(coupling, key) is not None]
    return [key for key in found if key != "over_temperature" or coupling.temperature is None]


def _asked(case: "Case", varying: list[tuple[int, list[str]]]) -> Iterator[Problem]:
    """What a march in time, a sum over modes or a damper's map cannot take."""
    place, follows = varying[0]
    torsion = None if case.response is None else case.response.torsion
    asked: list[tuple[KeyPath, str]] = []
    if torsion is not None:
        for key, why in (
            ("transient", "a march in time has no frequency and no steady state to take it at"),
            ("variable_inertia", "its motion couples all orders in one line"),
            ("as_published", "its closed forms are of one set of modes"),
            ("damping_model", "it damps one set of modes and leaves out what the coupling damps"),
        ):
            if getattr(torsion, key) is not None:
                asked.append(((*TORSION, key), why))
        if torsion.method == "modal":
            asked.append(((*TORSION, "method"), "a sum over modes takes one line for all orders"))
    if case.damper_design is not None:
        asked.append((("damper_design",), "its map takes one line for all dampers"))
    if not is_separate(case):
        why = "the couple on the mounts is that of one line"
        asked += [((table,), why) for table in with_torque(case)]
    for path, why in asked:
        yield Problem(
            path=path,
            message=f"a coupling of the line follows {_words(follows)}: {why}",
            found=f"{path[-1]}, with {', '.join(follows)}",
            allowed="a coupling of constant stiffness and relative_damping, or the steady response",
            hint="a variant of the case with the values that hold there",
            also=(*SHAFTS, place, "coupling", follows[0]),
        )


def _words(follows: list[str]) -> str:
    *first, last = (_FOLLOWS[key] for key in follows)
    return f"{', '.join(first)} and {last}" if first else last


def _loops(case: "Case") -> Iterator[Problem]:
    """In a loop the mean torque of a coupling follows its stiffness, which follows that."""
    line = case.machine.shaft_line
    assert line is not None, "asked of a shaft line"
    joined = joints(line)
    for place, shaft in enumerate(line.shafts):
        if shaft.coupling is None or shaft.coupling.over_mean_torque is None:
            continue
        others = [one for number, one in enumerate(joined) if number != place]
        part = speed_ratios(len(line.stations), others, crank_station(line)).part
        own = joined[place]
        if part[own.first] == part[own.second]:
            yield Problem(
                path=(*SHAFTS, place, "coupling", "over_mean_torque"),
                message=f"coupling {section_names(line)[place][:60]!r} is in a closed loop, where "
                "its mean torque is no matter of equilibrium alone",
                allowed="the stiffness at its mean torque, as `stiffness`",
            )
