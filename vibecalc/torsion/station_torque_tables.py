"""[[machine.shaft_line.excitations]] in a case: torques that act on stations, beside cylinders."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Frequency,
    Moment,
    Name,
    Number,
    Table,
    key,
)
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

    speed: tuple[AngularSpeed, ...] = key(
        "ascending, of the crankshaft", min_length=2, max_length=2000
    )
    factor: tuple[Number, ...] = key("one per speed", min_length=2, max_length=2000)
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

    angle: tuple[Angle, ...] = key(
        "ascending, of the shaft, one turn or two", min_length=4, max_length=100_000
    )
    torque: tuple[Moment, ...] = key(
        "one per angle; the last equals the first", min_length=4, max_length=100_000
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

    name: Name | None = key("label; default: that of the station", None)
    on: Name = key("name of a station")
    orders: tuple[Order, ...] = key(
        "periods in a turn of its own shaft, or of the crankshaft, see `of`", (), max_length=MOST
    )
    blades: Blades | None = key(
        "instead: of a propeller or wheel; the orders are its multiples", None
    )
    teeth: Blades | None = key("instead: of a gear or sprocket; the orders are its multiples", None)
    frequencies: tuple[Annotated[Frequency, Field(gt=0)], ...] = key(
        "instead: that do not follow the speed, '50 Hz'", (), max_length=MOST
    )
    record: TorqueOverAngle | None = key(
        "instead: over its own angle, a table or a CSV; its mean does not count", None
    )
    harmonics: int = key(
        "of a record: how many orders are taken from it", 24, strict=True, ge=1, le=MOST
    )
    of: Literal["shaft", "crankshaft"] = key(
        "whose turns the orders count: its own shaft's or the crankshaft's", "shaft"
    )
    torques: tuple[Amplitude, ...] = key(
        "amplitudes, 0-to-peak, on its own shaft, at the operating speed", (), max_length=MOST
    )
    shares: tuple[Share, ...] = key(
        "instead: of the mean torque that the station takes, at every speed", (), max_length=MOST
    )
    phases: tuple[Angle, ...] = key("at crank angle zero; default: 0", (), max_length=MOST)
    exponent: Number = key("of the speed, for torques: 2 as a fan", 0.0, ge=0, le=4)
    over_speed: FactorOverSpeed | None = key("instead of exponent: a table or a CSV", None)
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
