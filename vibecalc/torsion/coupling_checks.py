"""Can what a case asks be answered of couplings that follow load, heat, frequency or vibration?"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.case.rules import both
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.firing import is_separate, with_torque
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine

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


#: questions that take one line, and why
_ONE_LINE = {
    "transient": "a march in time has no frequency and no steady state to take it at",
    "variable_inertia": "its motion couples all orders in one line",
    "as_published": "its closed forms are of one set of modes",
    "damping_model": "it damps one set of modes and leaves out what the coupling damps",
}


def coupling_problems(case: "Case", line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Problems of couplings whose stiffness is not one number."""
    given = [(place, shaft.coupling) for place, shaft in enumerate(line.shafts) if shaft.coupling]
    varying = [(place, follows) for place, one in given if (follows := what_it_follows(one))]
    if not varying:
        return
    yield from _asked(case, *varying[0])
    # in a loop the mean torque of a coupling follows its stiffness, which follows that
    for place, one in given:
        part, joint = layout.parts_without(place), layout.joints[place]
        if one.over_mean_torque is not None and part[joint.first] == part[joint.second]:
            yield Problem(
                path=(*SHAFTS, place, "coupling", "over_mean_torque"),
                message=f"coupling {layout.sections[place][:60]!r} is in a closed loop, where "
                "its mean torque is no matter of equilibrium alone",
                allowed="the stiffness at its mean torque, as `stiffness`",
            )


def what_it_follows(coupling: "Coupling") -> list[str]:
    """Keys of the rows that its stiffness and damping follow; a given temperature is one number."""
    found = [key for key in _FOLLOWS if getattr(coupling, key) is not None]
    return [key for key in found if key != "over_temperature" or coupling.temperature is None]


def _asked(case: "Case", place: int, follows: list[str]) -> Iterator[Problem]:
    """What a march in time, a sum over modes or a damper's map cannot take."""
    torsion = None if case.response is None else case.response.torsion
    asked: list[tuple[KeyPath, str]] = [
        ((*TORSION, key), why)
        for key, why in _ONE_LINE.items()
        if getattr(torsion, key, None) is not None
    ]
    if torsion is not None and torsion.method == "modal":
        asked.append(((*TORSION, "method"), "a sum over modes takes one line for all orders"))
    if case.damper_design is not None:
        asked.append((("damper_design",), "its map takes one line for all dampers"))
    if not is_separate(case):
        why = "the couple on the mounts is that of one line"
        asked += [((table,), why) for table in with_torque(case)]
    for path, why in asked:
        words = both([_FOLLOWS[key] for key in follows])
        yield Problem(
            path=path,
            message=f"a coupling of the line follows {words}: {why}",
            found=f"{path[-1]}, with {', '.join(follows)}",
            allowed="a coupling of constant stiffness and relative_damping, or the steady response",
            hint="a variant of the case with the values that hold there",
            also=(*SHAFTS, place, "coupling", follows[0]),
        )
