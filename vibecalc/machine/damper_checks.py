"""Can a damper be designed for this place of the line, with these numbers?"""

from collections.abc import Iterator

from vibecalc.case.schema import Case
from vibecalc.case.shaft_parts import ShaftLine
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.shaft_line_checks import unknown
from vibecalc.machine.shaft_sections import has_stress, section_names

DESIGN: KeyPath = ("damper_design",)


def design_problems(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """Problems of where the damper hangs, of what is looked for, and of its bounds."""
    design = case.damper_design
    if design is None:
        return
    dampers = {damper.name: damper for damper in line.dampers}
    stations = [station.name for station in line.stations]
    replaced = dampers.get(design.on)
    if replaced is None and design.on not in stations:
        yield unknown((*DESIGN, "on"), "station or damper", design.on, [*stations, *dampers])
    if replaced is not None and replaced.kind == "pendulum":
        yield Problem(
            path=(*DESIGN, "on"),
            message="pendulums are tuned by their order, not by a spring and a damper",
            found=repr(design.on[:60]),
            allowed="a station, or a damper of kind 'viscous' or 'spring'",
        )
    bounds = design.bounds
    for key in ("inertia", "stiffness", "damping"):
        bound = None if bounds is None else getattr(bounds, key)
        sought = key in design.find
        given = getattr(design, key)
        path: KeyPath = (*DESIGN, key)
        if sought and key == "inertia" and bound is None:
            yield Problem(
                path=DESIGN,
                message="an inertia that is looked for needs bounds: more is always better",
                allowed="bounds = { inertia = ['2 kg*m^2', '9 kg*m^2'] }, for example",
            )
        if sought and given is not None:
            yield Problem(
                path=path,
                message=f"{key} is given and looked for",
                allowed=f"no {key}, or find without it",
                also=(*DESIGN, "find") if "find" in design.model_fields_set else None,
            )
        elif not sought and given is None and replaced is None and design.on in stations:
            yield Problem(
                path=DESIGN,
                message=f"the new damper has no {key}, and it is not looked for",
                allowed=f"{key} here, or in find",
            )
        if bound is not None and not sought:
            yield Problem(
                path=(*DESIGN, "bounds", key),
                message=f"{key} is not looked for, and bounds hold nothing",
                allowed=f"{key} in find, or no such bounds",
            )
        elif bound is not None and not 0.0 <= bound[0] <= bound[1]:
            yield Problem(
                path=(*DESIGN, "bounds", key),
                message="bounds go from a smaller number to a larger one, from zero on",
                found=f"{bound[0]:.6g} to {bound[1]:.6g}",
                allowed="0 <= from <= to",
            )
    known = section_names(line)
    for place, name in enumerate(design.sections):
        if name not in known:
            yield unknown((*DESIGN, "sections", place), "shaft", name, known)
    shafts = zip(known, line.shafts, strict=True)
    if design.objective == "stress" and not any(
        has_stress(shaft)
        for name, shaft in shafts
        if not design.sections or name in design.sections
    ):
        yield Problem(
            path=(*DESIGN, "objective"),
            message="no shaft that counts has a section modulus for a stress",
            allowed="diameter, section_modulus or section on the shafts, or objective = 'torque'",
        )
