"""Do the shafts, stations, orders and cylinders that curves and conditions name exist?"""

from collections.abc import Iterator, Sequence

from vibecalc.core.case.raw import listed, unknown
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.asked import excited_orders, orders_words
from vibecalc.torsion.curve_tables import (
    OF_SECTIONS,
    OF_STATIONS,
    READINGS,
    LineCurve,
    curves_of,
)
from vibecalc.torsion.shaft_line_tables import Layout, stressed
from vibecalc.torsion.stage import names_of
from vibecalc.torsion.tables import LineSpeeds, Torsion

TORSION: KeyPath = ("response", "torsion")
#: of an end of the speeds, how far beyond it a measured one still counts as at it
_AT_END = 1e-9


def curve_problems(case: Case, torsion: Torsion) -> Iterator[Problem]:
    """Problems of curves, measured points and conditions against the machine."""
    for place, curve in enumerate(torsion.curves):
        path: KeyPath = (*TORSION, "curves", place)
        yield from _names(path, case, curve)
        yield from _orders((*path, "orders"), case, curve.orders)
        if curve.measured is not None and torsion.speeds is not None:
            yield from _measured((*path, "measured"), case, curve, torsion.speeds)
    yield from _conditions(case, torsion)


def _names(path: KeyPath, case: Case, curve: LineCurve) -> Iterator[Problem]:
    """Is there such a shaft or station, and does it have what is asked of it?"""
    known, line = names_of(case), case.machine.shaft_line
    assert line is not None
    every = list(dict.fromkeys([*known["section"], *known["station"]]))
    if curve.on not in every:
        yield unknown((*path, "on"), "shaft or station", curve.on, every)
        return
    columns = {name for name in READINGS if getattr(curve.measured, name, ())}
    of_it = [name for kind, names in (("section", OF_SECTIONS), ("station", OF_STATIONS))
             if curve.on in known[kind] for name in names]  # fmt: skip
    what = "a station" if curve.on in known["station"] else "a shaft"
    for place, name in enumerate(curve.of):
        if name not in of_it:
            yield Problem(
                path=(*path, "of", place),
                message=f"{curve.on[:60]!r} is {what}, which has no {name}",
                found=repr(name),
                allowed=listed(of_it),
            )
        elif name == "stress" and curve.on not in stressed(line, Layout(line)):
            yield Problem(
                path=(*path, "of", place),
                message=f"section {curve.on[:60]!r} has no section modulus for a stress",
                found="'stress'",
                allowed="diameter, section_modulus or section on this shaft",
                hint="torque and twist need none",
            )
    drawn = list(curves_of(line, [curve]))
    for column in sorted(columns.difference(drawn)):
        yield Problem(
            path=(*path, "measured", column),
            message=f"{column} was measured, and there is no curve of it",
            found=f"curves of {listed(drawn)}",
            allowed=f"of = ['{column}', ...] with it",
            also=(*path, "of"),
        )


def _orders(
    path: KeyPath, case: Case, orders: Sequence[float], or_all: str = ""
) -> Iterator[Problem]:
    """Is each of some orders excited? With `or_all` 0 stands for all of them."""
    excited = excited_orders(case)
    for place, order in enumerate(orders):
        # an order behind a gear is typed with the digits that a report shows
        if min(abs(order - one) / one for one in excited) > 1e-3 and (order or not or_all):
            yield Problem(
                path=(*path, place),
                message=f"the case has no order {order:g}",
                found=f"{order:g}",
                allowed=orders_words(case) + or_all,
                hint="orders of [response.torsion] says their step and the highest",
            )


def _measured(path: KeyPath, case: Case, curve: LineCurve, speeds: LineSpeeds) -> Iterator[Problem]:
    """Does each measured point stand on a curve?"""
    points = curve.measured
    assert points is not None
    low, high = speeds.start * (1.0 - _AT_END), speeds.stop * (1.0 + _AT_END)
    for place, speed in enumerate(points.speed):
        if not low <= speed <= high:
            yield Problem(
                path=(*path, "speed", place),
                message="this point was measured outside of the range of speeds",
                found=f"{speed:.6g} rad/s",
                allowed=f"{speeds.start:.6g} to {speeds.stop:.6g} rad/s",
                hint="rad/s, or a text with its unit: '480 rpm'",
                also=(*TORSION, "speeds"),
            )
    yield from _orders((*path, "order"), case, points.order, "; 0 for all orders together")


def _conditions(case: Case, torsion: Torsion) -> Iterator[Problem]:
    """Are there cylinders enough for conditions that differ?"""
    options = torsion.conditions
    if options is None or not has_crank_train(case.machine):
        return
    cylinders = case.machine.crank_train.cylinders
    path: KeyPath = (*TORSION, "conditions")
    scales = options.pressure_scale
    if len(cylinders) < 2 and (options.misfire == "each" or options.imbalance is not None):
        yield Problem(
            path=path,
            message="conditions in which one cylinder differs from the others need two or more",
            found=f"{len(cylinders)} cylinder{'s' * (len(cylinders) != 1)}",
            allowed="no [response.torsion.conditions]; or misfire = 'none' and a pressure_scale",
            also=("machine", "crank_train", "cylinders"),
        )
    if scales and len(scales) != len(cylinders):
        yield Problem(
            path=(*path, "pressure_scale"),
            message="pressure_scale has a factor for each cylinder",
            found=f"{len(scales)} factors",
            allowed=f"{len(cylinders)}, in the order of the cylinders",
            also=("machine", "crank_train", "cylinders"),
        )
    elif scales and all(one == 1.0 for one in scales):
        yield Problem(
            path=(*path, "pressure_scale"),
            message="these pressures are those of cylinders that all fire",
            found="1 for each",
            allowed="a factor other than 1",
        )
