"""Are the dimensions of shafts, throws and gears on a line possible?"""

from collections.abc import Iterator

from vibecalc.case.schema import Case
from vibecalc.case.shaft_parts import Shaft, Throw
from vibecalc.errors import KeyPath, Problem

LINE: KeyPath = ("machine", "shaft_line")


def shaft_part_problems(case: Case) -> list[Problem]:
    """Problems of bores and strengths, one shaft and one throw at a time."""
    line = case.machine.shaft_line
    if line is None:
        return []
    problems: list[Problem] = []
    for place, station in enumerate(line.stations):
        if station.throw is not None:
            problems += _bores((*LINE, "stations", place, "throw"), station.throw)
    for place, shaft in enumerate(line.shafts):
        problems += _shaft((*LINE, "shafts", place), shaft)
    for place, gear in enumerate(line.gears):
        if gear.ratio is not None and not 1e-6 <= gear.ratio <= 1e6:
            problems.append(
                Problem(
                    path=(*LINE, "gears", place, "ratio"),
                    message="no gear has such a ratio",
                    found=f"{gear.ratio:.6g}",
                    allowed="1e-06 to 1e+06",
                )
            )
    return problems


def _bores(path: KeyPath, throw: Throw) -> Iterator[Problem]:
    for part in ("journal", "pin"):
        bore, outer = getattr(throw, f"{part}_bore"), getattr(throw, f"{part}_diameter")
        if bore >= outer:
            yield _wider((*path, f"{part}_bore"), bore, outer, (*path, f"{part}_diameter"))


def _shaft(path: KeyPath, shaft: Shaft) -> Iterator[Problem]:
    if shaft.throw is not None:
        yield from _bores((*path, "throw"), shaft.throw)
    section = shaft.section
    if section is None:
        return
    inner, outer = section.inner_diameter, section.outer_diameter
    here: KeyPath = (*path, "section")
    if inner >= outer:
        yield _wider((*here, "inner_diameter"), inner, outer, (*here, "outer_diameter"))
        return
    bore, wide = section.end_inner_diameter, section.end_outer_diameter
    key = "end_inner_diameter" if bore is not None else "end_outer_diameter"
    other = "end_outer_diameter" if wide is not None else "outer_diameter"
    bore, wide = (inner if bore is None else bore), (outer if wide is None else wide)
    if bore >= wide:
        yield _wider((*here, key), bore, wide, (*here, other))


def _wider(path: KeyPath, bore: float, outer: float, also: KeyPath) -> Problem:
    return Problem(
        path=path,
        message="a bore has to be narrower than what it is in",
        found=f"{bore:.6g} m",
        allowed=f"< {outer:.6g} m",
        also=also,
    )
