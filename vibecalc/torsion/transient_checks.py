"""Can a change in time happen to this line: its cylinder, its clutch, the sections it counts?"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.case.raw import strangers, unknown
from vibecalc.errors import KeyPath, Problem
from vibecalc.schema import Case
from vibecalc.torsion.asked import least_steps, turned_angles
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine
from vibecalc.torsion.tables import Torsion

if TYPE_CHECKING:
    from vibecalc.torsion.transient_tables import Transient

# ----------------------------------------------------------------------------
# A change in time against the shaft line that it happens to.
# ----------------------------------------------------------------------------

TRANSIENT_TABLE: KeyPath = ("response", "torsion", "transient")
LINE: KeyPath = ("machine", "shaft_line")


def change_problems(line: ShaftLine, layout: Layout, torsion: Torsion) -> Iterator[Problem]:
    """Problems of [response.torsion.transient] against the line."""
    change = torsion.transient
    if change is None:
        return
    if change.cylinder is not None and change.cylinder in torsion.misfire:
        yield Problem(
            path=(*TRANSIENT_TABLE, "cylinder"),
            message=f"cylinder {change.cylinder[:60]!r} does not fire from the begin",
            allowed="a cylinder that is not in misfire",
            also=("response", "torsion", "misfire"),
        )
    if change.clutch is not None:
        yield from _clutch(line, layout, change.clutch)
    yield from _form(line, torsion, change)
    yield from _massless(line, layout)
    yield from _counting(line, layout, change)


def _form(line: ShaftLine, torsion: Torsion, change: "Transient") -> Iterator[Problem]:
    """What does not damp, or turn, in time as it does at a steady speed."""
    from vibecalc.torsion.transient_tables import AT_CONSTANT_SPEED

    if torsion.damping_model is not None and torsion.damping_model.kind == "modal":
        yield Problem(
            path=("response", "torsion", "damping_model", "kind"),
            message="damping ratios by mode have no dashpots to follow in time",
            allowed="kind = 'rayleigh', or no damping_model and dampings of shafts, stations or "
            "dampers",
            also=TRANSIENT_TABLE,
        )
    hung = [n for n, one in enumerate(line.dampers) if one.kind == "pendulum"]
    if hung and change.kind not in AT_CONSTANT_SPEED:
        yield Problem(
            path=(*LINE, "dampers", hung[0]),
            message="pendulums change their stiffness with the speed, which a change of speed in "
            "time does not follow",
            allowed=f"a change at constant speed: {', '.join(AT_CONSTANT_SPEED)}",
            also=(*TRANSIENT_TABLE, "kind"),
        )


def _massless(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Stations without inertia, but those that rigid gears join to an inertia."""
    named = [*zip(layout.freedom, line.stations, strict=True)]
    heavy = {freedom for freedom, one in named if one.inertia != 0.0}
    for n, (freedom, one) in enumerate(named):
        if freedom not in heavy:
            yield Problem(
                path=(*LINE, "stations", n, "inertia"),
                message=f"station {one.name[:60]!r} has no inertia, and a change in time needs one "
                "at every station",
                found="0",
                allowed="an inertia above 0, or its two shafts as one of their common stiffness",
                also=TRANSIENT_TABLE,
            )


def _clutch(line: ShaftLine, layout: Layout, name: str) -> Iterator[Problem]:
    """A clutch parts the line in two, one of them with all cylinders, and nothing holds either."""
    path = (*TRANSIENT_TABLE, "clutch")
    if name not in layout.sections:
        yield unknown(path, "shaft", name, layout.sections)
        return
    place = layout.sections.index(name)
    part, joint = layout.parts_without(place), layout.joints[place]
    if part[joint.first] == part[joint.second]:
        yield Problem(
            path=path,
            message=f"stations {layout.names[joint.first][:60]!r} and "
            f"{layout.names[joint.second][:60]!r} are joined by another way, too, and cannot turn "
            "at two speeds",
            found=repr(name[:60]),
            allowed="a shaft that is the only way between the two parts of the line",
            also=(*LINE, "shafts", place),
        )
        return
    if len({number for number, fires in zip(part, layout.fires, strict=True) if fires}) > 1:
        yield Problem(
            path=path,
            message="there are cylinders on both sides of the clutch",
            found=repr(name[:60]),
            allowed="a clutch with all cylinders on one side of it",
            also=(*LINE, "shafts", place),
        )
    held = [n for n, one in enumerate(line.stations) if one.ground_stiffness]
    if held:
        yield Problem(
            path=path,
            message="a station that a stiffness to ground holds cannot change its speed",
            allowed="no ground_stiffness, or another change",
            also=(*LINE, "stations", held[0], "ground_stiffness"),
        )


def _counting(line: ShaftLine, layout: Layout, change: "Transient") -> Iterator[Problem]:
    counting = change.counting
    if counting is None:
        return
    others = [gear.label for gear in line.gears if gear.mesh_stiffness]
    known = [*layout.sections, *others, *(damper.name for damper in line.dampers)]
    path = (*TRANSIENT_TABLE, "counting")
    yield from strangers((*path, "sections"), "section", counting.sections, known)
    for place, (shaft, name) in enumerate(zip(line.shafts, layout.sections, strict=True)):
        asked = not counting.sections or name in counting.sections
        by_stress = shaft.fatigue is not None and shaft.fatigue.stress is not None
        if asked and by_stress and not shaft.has_stress:
            yield Problem(
                path=(*LINE, "shafts", place, "fatigue"),
                message=f"shaft {name[:60]!r} has no section modulus for a stress",
                allowed="diameter, section_modulus or section on this shaft, or fatigue with a "
                "torque",
                also=path,
            )


# ----------------------------------------------------------------------------
# Does a change in time end within the steps that a run may take?
# ----------------------------------------------------------------------------


def steps_problems(case: Case, change: "Transient") -> Iterator[Problem]:
    """The problem of a change that takes longer than the march in time goes."""
    from vibecalc.torsion.transient.march import MOST_STEPS

    steps = least_steps(case)
    if steps <= MOST_STEPS:
        return
    spans = turned_angles(case, change)
    key = max(spans, key=lambda key: spans[key])
    if key == "change":
        key = "duration" if change.acceleration is None else "acceleration"
    yield Problem(
        path=(*TRANSIENT_TABLE, key) if key in change.model_fields_set else TRANSIENT_TABLE,
        message="the change takes too many steps in time",
        found=f"{steps:.3g} steps or more, for {sum(spans.values()) / 6.283185307:.3g} turns of "
        "the crank",
        allowed=f"{MOST_STEPS:.3g} steps",
        hint="a faster change, less time before and after it, or fewer orders",
    )
