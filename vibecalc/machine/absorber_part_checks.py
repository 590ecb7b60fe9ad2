"""Can rod, springs, ring, gap and oils of an absorber be built, and is their oil known?"""

from collections.abc import Iterator

from vibecalc.case.absorber_fields import ICE
from vibecalc.case.absorber_hardware import Gap, Oil
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, NumericalFailure, Problem
from vibecalc.hardware.viscosity import (
    COLDEST,
    HOTTEST,
    THICKEST,
    THINNEST,
    Walther,
    kinematic_viscosity,
)
from vibecalc.machine.absorber import single_absorber
from vibecalc.machine.absorber_checks import within
from vibecalc.machine.absorber_hardware import clearance

MACHINE: KeyPath = ("machine",)
GAP: KeyPath = ("machine", "gap")
WARMING: KeyPath = ("tuning", "temperatures")
#: K: below this a number without a unit was meant in degrees Celsius
_MEANT_CELSIUS = 200.0
_IN_KELVIN = "temperatures without a unit are in K: '60 degC'"


def absorber_part_problems(case: Case) -> list[Problem]:
    """Problems of the parts one by one, then of the ratios that they give together."""
    machine = case.machine
    if machine.primary is None:
        return []
    problems = [*_rod(case), *_springs(case), *_rings(case), *_oils(case)]
    if machine.gap is not None:
        problems += _gap(machine.gap)
    if problems:
        return problems
    built = single_absorber(machine)
    if built is None:
        return []
    for what, value, part in (
        ("mass", built.mass_ratio, "ring"),
        ("stiffness", built.stiffness_ratio, "springs"),
        ("damping", built.secondary_damping, "oil"),
    ):
        number = float(value)  # type: ignore[arg-type]
        if getattr(machine, part) is not None and number == number:
            problems += within((*MACHINE, part), what, number)
    return problems


def _rod(case: Case) -> Iterator[Problem]:
    rod, wheel = case.machine.rod, case.machine.flywheel
    if rod is not None and rod.bore >= rod.diameter:
        yield Problem(
            path=(*MACHINE, "rod", "bore"),
            message="the bore is as wide as the rod",
            found=f"{rod.bore:.6g} m",
            allowed=f"< {rod.diameter:.6g} m",
            also=(*MACHINE, "rod", "diameter"),
        )
    span, whole = (None, None) if rod is None else (rod.span, rod.total_length)
    if span is not None and whole is not None and span > whole:
        yield Problem(
            path=(*MACHINE, "rod", "span"),
            message="the supports stand further apart than the rod is long",
            found=f"{span:.6g} m",
            allowed=f"<= {whole:.6g} m",
            also=(*MACHINE, "rod", "total_length"),
        )
    if wheel is not None and wheel.polar_inertia > 2.0 * wheel.diametral_inertia * (1.0 + 1e-6):
        yield Problem(
            path=(*MACHINE, "flywheel", "polar_inertia"),
            message="no body has this polar inertia: it is at most twice the diametral one",
            found=f"{wheel.polar_inertia:.6g} kg*m^2",
            allowed=f"<= {2.0 * wheel.diametral_inertia:.6g} kg*m^2",
            also=(*MACHINE, "flywheel", "diametral_inertia") if wheel.diametral_inertia else None,
        )


def _springs(case: Case) -> Iterator[Problem]:
    springs = case.machine.springs
    if springs is None or springs.wire_diameter is None or springs.coil_diameter is None:
        return
    if springs.coil_diameter <= springs.wire_diameter:
        yield Problem(
            path=(*MACHINE, "springs", "coil_diameter"),
            message="the wire does not go round: the coil is no wider than its wire",
            found=f"{springs.coil_diameter:.6g} m",
            allowed=f"> {springs.wire_diameter:.6g} m",
            also=(*MACHINE, "springs", "wire_diameter"),
        )


def _rings(case: Case) -> Iterator[Problem]:
    for name in ("ring", "gap"):
        part = getattr(case.machine, name)
        if part is not None and part.inner_radius >= part.outer_radius:
            yield Problem(
                path=(*MACHINE, name, "inner_radius"),
                message="the inner radius is not below the outer one",
                found=f"{part.inner_radius:.6g} m",
                allowed=f"< {part.outer_radius:.6g} m",
                also=(*MACHINE, name, "outer_radius"),
            )


def _gap(gap: Gap) -> Iterator[Problem]:
    films = {"clearance": clearance(gap)}
    films |= {
        key: value
        for key in ("side_clearance", "bore_clearance")
        if (value := getattr(gap, key)) is not None
    }
    for key, wide in films.items():
        by_rule = key == "clearance" and gap.clearance is None
        if wide >= gap.width:
            yield Problem(
                path=GAP if by_rule else (*GAP, key),
                message="a gap as wide as the mass is no film: its damping cannot be told",
                found=f"{wide:.6g} m" + (", by the rule for its radius" if by_rule else ""),
                allowed=f"< {gap.width:.6g} m, the width of the mass",
                also=(*GAP, "width"),
            )
        elif key == "bore_clearance" and wide >= gap.inner_radius:
            yield Problem(
                path=(*GAP, key),
                message="the gap in the bore is as wide as the bore itself",
                found=f"{wide:.6g} m",
                allowed=f"< {gap.inner_radius:.6g} m",
                also=(*GAP, "inner_radius"),
            )


def _oils(case: Case) -> Iterator[Problem]:
    machine = case.machine
    asked: list[tuple[KeyPath, float]] = []
    if machine.gap is not None and machine.gap.temperature is not None:
        asked.append(((*GAP, "temperature"), machine.gap.temperature))
    warming = None if case.tuning is None else case.tuning.temperatures
    if warming is not None:
        ends = (("from", warming.start), ("to", warming.stop))
        asked += [((*WARMING, key), value) for key, value in ends]
        if not warming.start < warming.stop:
            yield Problem(
                path=(*WARMING, "from"),
                message="temperatures go from a lower one to a higher one",
                found=f"from {_celsius(warming.start)} to {_celsius(warming.stop)}",
                allowed="from < to",
            )
    told = [problem for path, value in asked for problem in _on_the_chart(path, value)]
    yield from told
    for place, one in enumerate(machine.stock_oils):
        yield from _line((*MACHINE, "stock_oils", place), one.temperatures, one.viscosities)
    rows = machine.oil_catalogue
    if rows is not None:
        both = zip(rows.viscosity_40, rows.viscosity_100, strict=True)
        for place, (thick, thin) in enumerate(both):
            points = (ICE + 40.0, ICE + 100.0), (thick, thin)
            yield from _line((*MACHINE, "oil_catalogue"), *points, keys=("viscosity_100", place))
    if machine.oil is not None:
        wrong = [*_line((*MACHINE, "oil"), machine.oil.temperatures, machine.oil.viscosities)]
        yield from wrong or (() if told else _known(machine.oil, asked))


def _on_the_chart(path: KeyPath, value: float) -> Iterator[Problem]:
    if not COLDEST <= value <= HOTTEST:
        yield Problem(
            path=path,
            message="the temperature is outside the model of viscosity (ASTM D341)",
            found=f"{value:.6g} K, {_celsius(value)}",
            allowed=f"{_celsius(COLDEST)} to {_celsius(HOTTEST)}",
            hint=_IN_KELVIN if value < _MEANT_CELSIUS else "",
        )


def _line(
    path: KeyPath,
    temperatures: tuple[float, float],
    viscosities: tuple[float, float],
    keys: tuple[str | int, ...] = ("viscosities",),
) -> Iterator[Problem]:
    """Two points make the line of an oil that grows thinner with heat."""
    told = False
    for place, value in enumerate(temperatures):
        for problem in _on_the_chart((*path, "temperatures", place), value):
            told = True
            yield problem
    for place, value in enumerate(viscosities):
        if not THINNEST <= value <= THICKEST:
            told = True
            yield Problem(
                path=(*path, keys[0], place) if len(keys) == 1 else (*path, *keys),
                message="the viscosity is outside the model (ASTM D341)",
                found=f"{1e6 * value:.6g} mm^2/s",
                allowed=f"{1e6 * THINNEST:.0f} to {1e6 * THICKEST:.0e} mm^2/s",
                hint="viscosities without a unit are in m^2/s: '86 cSt'" if value > 1.0 else "",
            )
    if told:
        return
    cooling = (temperatures[1] - temperatures[0]) * (viscosities[0] - viscosities[1])
    if cooling <= 0.0:
        yield Problem(
            path=(*path, *keys),
            message="no oil has these two points: it is thinner at the higher temperature",
            found=" and ".join(
                f"{1e6 * thick:.6g} mm^2/s at {_celsius(warm)}"
                for warm, thick in zip(temperatures, viscosities, strict=True)
            ),
            allowed="two temperatures, and less viscosity at the higher one",
        )


def _known(oil: Oil, asked: list[tuple[KeyPath, float]]) -> Iterator[Problem]:
    line = Walther(oil.temperatures, oil.viscosities)
    for path, value in asked:
        try:
            kinematic_viscosity(line, value)
        except NumericalFailure as failure:
            yield Problem(
                path=path,
                message=f"the oil of the case is not known there: {failure}",
                found=_celsius(value),
                allowed="temperatures at which the line of the oil stays within the model",
                also=(*MACHINE, "oil", "viscosities"),
            )


def _celsius(value: float) -> str:
    return f"{value - ICE:.6g} degC"
