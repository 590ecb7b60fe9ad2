"""[[machine.shaft_line.excitations]] in a case: torques that act on stations, beside cylinders."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Angle, AngularSpeed, Frequency, Moment, Name, Number, Table
from vibecalc.core.case.rules import (
    Row,
    ascending,
    at_most_one,
    no,
    one_of,
    refuse,
    same_length,
)
from vibecalc.errors import Problem

Order = Annotated[float, Field(gt=0, le=100_000)]
Share = Annotated[float, Field(ge=0, le=10)]
Amplitude = Annotated[Moment, Field(ge=0)]
Blades = Annotated[int, Field(strict=True, ge=1, le=10_000)]
#: harmonics of one torque
MOST = 400
#: of a turn: a record ends where it began
_CLOSED = 1e-6
_TURN = 6.283185307179586


class FactorOverSpeed(Table):
    """What a torque is at other speeds, over what it is given as; straight between the entries."""

    speed: tuple[AngularSpeed, ...] = Field(
        min_length=2, max_length=2000, description="ascending, of the crankshaft"
    )
    factor: tuple[Number, ...] = Field(min_length=2, max_length=2000, description="one per speed")
    RULES = (same_length("speed", "factor"), ascending("speed"))


def _span(row: Row) -> Iterator[Problem]:
    angle = [one for one in row.listed("angle") if isinstance(one, float)]
    if len(angle) < 4 or len(angle) != len(row.entries("angle")):
        return
    turns = (angle[-1] - angle[0]) / _TURN
    if min(abs(turns - 1.0), abs(turns - 2.0)) > _CLOSED:
        yield row.problem(
            "angle",
            "a record of a torque goes over one turn of its shaft, or over two",
            found=f"{angle[-1] - angle[0]:.6g} rad, {turns:.6g} turns",
            allowed="angles from 0 to 360 deg, or to 720 deg",
        )
        return
    torque = [one for one in row.listed("torque") if isinstance(one, float)]
    if len(torque) != len(angle):
        return
    size = max(map(abs, torque))
    if abs(torque[-1] - torque[0]) > 1e-6 * size:
        yield row.problem(
            "torque",
            "a record of a torque ends with the value that it begins with",
            found=f"{torque[0]:.6g} N*m, and {torque[-1]:.6g} N*m in the last row",
            allowed="a last row that repeats the first",
        )


class TorqueOverAngle(Table):
    """A torque that was measured or computed over one turn of its shaft, or over two."""

    angle: tuple[Angle, ...] = Field(
        min_length=4, max_length=100_000, description="ascending, of the shaft, one turn or two"
    )
    torque: tuple[Moment, ...] = Field(
        min_length=4, max_length=100_000, description="one per angle; the last equals the first"
    )

    RULES = (same_length("angle", "torque"), ascending("angle"), _span)


def _amplitudes(row: Row) -> str:
    return "torques" if row.said("torques") else "shares"


def _harmonics(row: Row) -> Iterator[Problem]:
    """As many amplitudes as orders or frequencies, and as many phases."""
    key = _amplitudes(row)
    said = row.said(key, "orders", "frequencies", "phases")
    counts = {name: len(row.entries(name)) for name in said}
    if len(set(counts.values())) > 1:
        yield row.problem(
            key if row.said(key) else "",
            "each harmonic of a torque has one amplitude",
            found=", ".join(f"{count} of {name}" for name, count in counts.items()),
            allowed="as many entries in each",
        )


_BY_ORDER = ("orders", "blades", "teeth", "frequencies", "record")


class StationExcitation(Table):
    """A torque on a station: A cos(order x angle turned + phase), positive as the station turns."""

    name: Name | None = Field(None, description="label; default: that of the station")
    on: Name = Field(description="name of a station")
    orders: Annotated[tuple[Order, ...], Field(max_length=MOST)] = Field(
        (), description="periods in a turn of its own shaft, or of the crankshaft, see `of`"
    )
    blades: Blades | None = Field(
        None, description="instead: of a propeller or wheel; the orders are its multiples"
    )
    teeth: Blades | None = Field(
        None, description="instead: of a gear or sprocket; the orders are its multiples"
    )
    frequencies: Annotated[
        tuple[Annotated[Frequency, Field(gt=0)], ...], Field(max_length=MOST)
    ] = Field((), description="instead: that do not follow the speed, '50 Hz'")
    record: TorqueOverAngle | None = Field(
        None, description="instead: over its own angle, a table or a CSV; its mean does not count"
    )
    harmonics: Annotated[int, Field(strict=True, ge=1, le=MOST)] = Field(
        24, description="of a record: how many orders are taken from it"
    )
    of: Literal["shaft", "crankshaft"] = Field(
        "shaft", description="whose turns the orders count: its own shaft's or the crankshaft's"
    )
    torques: Annotated[tuple[Amplitude, ...], Field(max_length=MOST)] = Field(
        (), description="amplitudes, 0-to-peak, on its own shaft, at the operating speed"
    )
    shares: Annotated[tuple[Share, ...], Field(max_length=MOST)] = Field(
        (), description="instead: of the mean torque that the station takes, at every speed"
    )
    phases: Annotated[tuple[Angle, ...], Field(max_length=MOST)] = Field(
        (), description="at crank angle zero; default: 0"
    )
    exponent: Number = Field(0.0, ge=0, le=4, description="of the speed, for torques: 2 as a fan")
    over_speed: FactorOverSpeed | None = Field(
        None, description="instead of exponent: a table or a CSV"
    )
    RULES = (
        one_of(
            *_BY_ORDER,
            hint="blades = 4 with shares = [0.06, 0.01] for a propeller, for example",
        ),
        one_of("torques", "shares", when=lambda t: not t.said("record")),
        at_most_one("record", "torques"),
        at_most_one("record", "shares"),
        at_most_one("record", "phases"),
        at_most_one("exponent", "over_speed"),
        no(
            "exponent over_speed",
            lambda t: t.said("shares"),
            "{key} is of torques; shares follow the mean torque",
            "torques, or no {key}",
        ),
        no(
            "harmonics",
            lambda t: not t.said("record"),
            "harmonics are those of a record",
            "a record",
        ),
        no(
            "of",
            lambda t: not t.said("orders", "record"),
            "`of` says whose turns the orders count, and there are none",
            "orders with it",
        ),
        refuse(
            "orders",
            "an order stands twice",
            lambda t: len({*map(str, t.entries("orders"))}) < len(t.entries("orders")),
            "each order once",
        ),
        _harmonics,
    )
