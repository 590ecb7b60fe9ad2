"""Torques given at stations of a line: do they have what they follow, can a question count them?"""

from collections.abc import Iterator

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.parts.firing import is_separate, with_torque
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine
from vibecalc.torsion.study_results import PASSAGES
from vibecalc.torsion.tables import Torsion

TORSION: KeyPath = ("response", "torsion")
DESIGN: KeyPath = ("damper_design",)
LINE: KeyPath = ("machine", "shaft_line")

# ----------------------------------------------------------------------------
# Torques given at stations: do they have what they follow, and can every question count them?
# ----------------------------------------------------------------------------

#: questions that know the torques of cylinders alone
_OF_CYLINDERS_ALONE = ("as_published", "variable_inertia")


def excitation_problems(
    case: Case, line: ShaftLine, layout: Layout, torsion: Torsion | None
) -> Iterator[Problem]:
    """Problems of [[machine.shaft_line.excitations]], and of a line without cylinders."""
    if not has_crank_train(case.machine) and not line.excitations and torsion is not None:
        yield Problem(
            path=LINE,
            message="nothing excites this line: it has no cylinders and no excitations",
            allowed="excitations = [{ on = 'pump', blades = 5, shares = [0.05] }], for example",
            hint="for natural and critical speeds alone, torques = ['0 N*m'] with the orders that "
            "count",
        )
    if not line.excitations:
        return
    asked = [key for key in _OF_CYLINDERS_ALONE if getattr(torsion, key, None)]
    refused: list[KeyPath] = [(*TORSION, key) for key in asked]
    for path in (*refused, DESIGN) if case.damper_design is not None else refused:
        yield Problem(
            path=path,
            message=f"{path[-1]} counts the torques of cylinders alone",
            allowed="no excitations in [machine.shaft_line] with it",
            also=(*LINE, "excitations", 0),
        )
    change = None if torsion is None else torsion.transient
    if change is not None and change.kind in PASSAGES:
        yield from _followed_in_passages(line, layout)
    elif change is not None and change.clutch is not None:
        yield from _not_behind_clutch(line, layout, change.clutch)
    for table in () if is_separate(case) else with_torque(case):
        yield Problem(
            path=(table,),
            message="the torque on the mounts counts the torques of cylinders alone",
            allowed="no excitations in [machine.shaft_line], or a driven machine that stands "
            "elsewhere: driven_machine = 'separate'",
            hint='loads = ["shaking"] leaves the torque out',
            also=(*LINE, "excitations", 0),
        )
    yield from _followed(case, line, layout)


def _followed(case: Case, line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Shares of a mean torque that there is, frequencies that are no orders."""
    loaded = {layout.names[layout.load], *(load.on for load in line.loads)}
    for place, one in enumerate(line.excitations):
        path: KeyPath = (*LINE, "excitations", place)
        if one.shares and one.on not in loaded:
            yield Problem(
                path=(*path, "shares"),
                message=f"station {one.on[:60]!r} takes no mean torque to have a share of",
                allowed="a station of `loads`, or that of `load`; or torques instead",
                also=(*LINE, "loads") if line.loads else None,
            )
        for number, frequency in enumerate(one.frequencies):
            half = 2.0 * frequency / case.machine.speed
            if abs(half - round(half)) <= 1e-9 * max(half, 1.0):
                yield Problem(
                    path=(*path, "frequencies", number),
                    message=f"this frequency is order {half / 2.0:g} at the operating speed",
                    allowed="orders instead, if it follows the speed; else a frequency that is no "
                    "multiple of half the speed",
                    also=("machine", "speed"),
                )


def _followed_in_passages(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """While the speed changes, torques stay as they are or go with its square."""
    taking = layout.names[layout.load]
    for place, one in enumerate(line.excitations):
        path: KeyPath = (*LINE, "excitations", place)
        loads = [load for load in line.loads if load.on == one.on]
        exponents = [load.exponent for load in loads if load.curve is None]
        by_square = one.exponent in (0.0, 2.0)
        if one.shares:
            by_square = one.on != taking and len(loads) == 1 and exponents in ([0.0], [2.0])
        key = next((key for key in ("frequencies", "over_speed") if getattr(one, key)), "")
        if key or not by_square:
            yield Problem(
                path=(*path, key or ("shares" if one.shares else "exponent")),
                message="while the speed changes, a torque at a station is constant or goes with "
                "the square of the speed",
                allowed="exponent 0 or 2, shares of one load with such an exponent; or a change "
                "at constant speed",
                also=(*TORSION, "transient", "kind"),
            )


def _not_behind_clutch(line: ShaftLine, layout: Layout, clutch: str) -> Iterator[Problem]:
    """Orders behind a clutch would count turns of a shaft that slips."""
    if clutch not in layout.sections:
        return
    part = layout.parts_without(layout.sections.index(clutch))
    for place, one in enumerate(line.excitations):
        size = one.record or any(one.torques) or any(one.shares)
        if size and part[layout.at[one.on]] != part[layout.crank]:
            yield Problem(
                path=(*LINE, "excitations", place, "on"),
                message="this station slips before the clutch holds, and orders of its shaft are "
                "none of the crank",
                allowed="torques on the side of the clutch that turns with machine.speed",
                also=(*TORSION, "transient", "clutch"),
            )
