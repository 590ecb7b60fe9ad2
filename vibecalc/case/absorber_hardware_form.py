"""Checks of form of what an absorber is built of: what goes with what, each number in one way."""

from collections.abc import Iterator

from vibecalc.case.absorber_ratio_form import WIRE
from vibecalc.case.raw import Data, either, misspelt, table_at
from vibecalc.errors import KeyPath, Problem

MACHINE: KeyPath = ("machine",)
#: part -> the part that it goes with
_NEEDS = {
    "flywheel": "rod",
    "oil": "gap",
    "stock_oils": "gap",
    "oil_catalogue": "gap",
    "stock_springs": "springs",
    "stock_dampers": "secondary",
    "spring_catalogue": "springs",
    "rod": "primary",
    "springs": "secondary",
    "gap": "secondary",
    "ring": "primary",
}
_OILS = ("oil", "stock_oils", "oil_catalogue")
_CATALOGUES = ("spring_catalogue", "oil_catalogue")
_BENDING = ("total_length", "span", "elastic_modulus")


def check_hardware(data: Data, machine: Data, motion: str) -> Iterator[Problem]:
    """Yield the problems of rod, flywheel, springs, ring, gap, oils and stock."""
    several = "secondaries" in machine
    for part, other in _NEEDS.items():
        there = other in machine or (other == "secondary" and "ring" in machine)
        if part in machine and not there and not misspelt(machine, MACHINE, other):
            yield Problem(
                path=(*MACHINE, part),
                message=f"[machine.{part}] needs [machine.{other}]",
                hint="several absorbers have no parts as built" if several else "",
            )
    if "ring" in machine and several:
        yield Problem(
            path=(*MACHINE, "ring"),
            message="[machine.ring] is the mass of one absorber, and there are several",
            allowed="an inertia or a mass_ratio for each",
            also=(*MACHINE, "secondaries"),
        )
    if isinstance(machine.get("rod"), dict):
        yield from _rod(machine["rod"], "flywheel" in machine)
    if isinstance(machine.get("springs"), dict):
        yield from _springs(data, machine["springs"], motion)
    yield from _units(machine, motion)
    if isinstance(machine.get("gap"), dict):
        yield from _oils(machine, machine["gap"])
    for part in _CATALOGUES:
        columns = table_at(machine, part)
        sizes = {name: len(rows) for name, rows in columns.items() if isinstance(rows, list)}
        if len(set(sizes.values())) > 1:
            yield Problem(
                path=(*MACHINE, part),
                message=f"the columns of {part} are not of one length",
                found=", ".join(f"{size} of {name}" for name, size in sizes.items()),
                allowed="as many entries in each",
            )


def _rod(rod: Data, bends: bool) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "rod")
    for one, other in (("length", "shear_modulus"), ("shear_modulus", "length")):
        if one in rod and other not in rod and not misspelt(rod, path, other):
            yield Problem(
                path=(*path, one),
                message=f"the rod has {one} and no {other}: they give its stiffness together",
                allowed="both, or neither for a rod that only bends",
            )
    if bends:
        yield from either(rod, path, "mass", ("density",))
        for key in _BENDING:
            if key not in rod and not misspelt(rod, path, key):
                yield Problem(
                    path=path,
                    message=f"[machine.flywheel] asks how the rod bends, and the rod has no {key}",
                    allowed=", ".join((*_BENDING, "mass or density")),
                    also=(*MACHINE, "flywheel"),
                )
    elif not ({"length", "shear_modulus"} & rod.keys()) and not misspelt(rod, path, "length"):
        yield Problem(
            path=path,
            message="the rod is neither twisted nor bent",
            allowed="length and shear_modulus, or [machine.flywheel] on its end",
        )


def _springs(data: Data, springs: Data, motion: str) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "springs")
    wire = [key for key in WIRE if key in springs]
    yield from either(springs, path, "rate", WIRE, needed=False)
    missing = [key for key in WIRE if key not in springs and not misspelt(springs, path, key)]
    if wire and missing and "rate" not in springs:
        yield Problem(
            path=path,
            message=f"a spring from its wire needs {' and '.join(missing)}, too",
            allowed=f"all of {', '.join(WIRE)}, or rate",
            also=(*path, wire[0]),
        )
    unrated = not wire and "rate" not in springs and "tuning" not in data
    if unrated and not misspelt(springs, path, "rate", *WIRE):
        yield Problem(
            path=path,
            message="the springs have no rate, and no [tuning] finds one",
            allowed=f"rate, or {', '.join(WIRE)}, or [tuning]",
        )
    if motion == "torsion" and "radius" not in springs and not misspelt(springs, path, "radius"):
        yield Problem(
            path=path,
            message="springs of a mass that turns need the radius of their hooks",
            allowed="radius = '140 mm', for example",
        )
    elif motion == "translation" and "radius" in springs:
        yield Problem(
            path=(*path, "radius"),
            message="springs of a mass that moves in a line have no radius",
            allowed="count, angle and rate",
            also=(*MACHINE, "primary"),
        )
    if "allowed_stress" in springs and not wire:
        yield Problem(
            path=(*path, "allowed_stress"),
            message="the stress of a spring follows from its wire, which is not given",
            allowed=", ".join(WIRE),
        )


def _units(machine: Data, motion: str) -> Iterator[Problem]:
    """Parts have units, so that the primary needs them; what turns needs torsion."""
    turning = [part for part in ("rod", "ring", "gap") if part in machine]
    moving = [part for part in ("stock_dampers",) if part in machine]
    placed = [*turning, *moving, *(["springs"] if "springs" in machine else [])]
    if not isinstance(machine.get("primary"), dict) or not machine["primary"]:
        return
    if not motion and placed and placed != ["rod"]:
        part = next(part for part in placed if part != "rod")
        yield Problem(
            path=(*MACHINE, part),
            message=f"[machine.{part}] has units, and the primary is of ratios alone",
            allowed="a primary with inertia and stiffness",
            also=(*MACHINE, "primary"),
        )
    elif motion == "torsion" and moving:
        yield Problem(
            path=(*MACHINE, moving[0]),
            message=f"[machine.{moving[0]}] move in a line, and the primary turns",
            allowed="[machine.gap] with oils in stock, or a primary with mass and linear_stiffness",
            also=(*MACHINE, "primary"),
        )
    elif motion == "translation" and turning:
        yield Problem(
            path=(*MACHINE, turning[0]),
            message=f"[machine.{turning[0]}] turns, and the primary moves in a line",
            allowed="a primary with inertia and stiffness",
            also=(*MACHINE, "primary"),
        )


def _oils(machine: Data, gap: Data) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "gap")
    there = [part for part in _OILS if part in machine]
    if there and "temperature" not in gap and not misspelt(gap, path, "temperature"):
        yield Problem(
            path=path,
            message=f"[machine.{there[0]}] needs the temperature at which the oil runs",
            allowed="temperature = '60 degC', for example",
            also=(*MACHINE, there[0]),
        )
    if "bore_clearance" in gap and "inner_radius" not in gap:
        yield Problem(
            path=(*path, "bore_clearance"),
            message="a disc without a bore has no film in it",
            allowed="inner_radius > 0 beside it",
        )
