"""How the stations of a shaft line hang together: pieces, speed ratios, rigid gears.

Stations are numbers 0 .. n - 1 here. A ratio is a station's own speed over that of the crankshaft,
negative where it turns the other way.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from vibecalc.case.shaft_parts import Gear, ShaftLine


class Joined(NamedTuple):
    """Two stations that something joins, and the speed of the second over that of the first."""

    first: int
    second: int
    ratio: float = 1.0


class Ratios(NamedTuple):
    """Speed ratio of each station, and the first joint that contradicts the others, or None.

    A station that nothing joins to the crankshaft counts from the first one of its own piece.
    """

    ratio: list[float]
    piece: list[int]
    contradiction: tuple[int, float, float] | None


#: relative difference of two ways to a ratio that counts as one: ratios are often typed rounded
SAME_RATIO = 1e-6


def gear_ratio(gear: Gear) -> float:
    """Speed of the second station over that of the first, with its sign."""
    size = gear.ratio if gear.ratio is not None else _of_teeth(gear)
    return -size if gear.reverses else size


def _of_teeth(gear: Gear) -> float:
    assert gear.teeth is not None  # one of the two, says the form
    return gear.teeth[0] / gear.teeth[1]


def shaft_ends(line: ShaftLine) -> list[tuple[str, str]]:
    """Names of the two stations of each shaft; where none says them, each leads to the next."""
    names = [station.name for station in line.stations]
    ends = []
    for place, shaft in enumerate(line.shafts):
        follows = (names[place], names[place + 1]) if place + 1 < len(names) else ("", "")
        ends.append(shaft.between or follows)
    return ends


def joints(line: ShaftLine) -> list[Joined]:
    """All shafts, then all gears; those to stations that do not exist are left out."""
    at = {station.name: place for place, station in enumerate(line.stations)}
    ends = [(pair, 1.0) for pair in shaft_ends(line)]
    ends += [(gear.between, gear_ratio(gear)) for gear in line.gears]
    return [
        Joined(at[first], at[second], ratio)
        for (first, second), ratio in ends
        if first in at and second in at
    ]


def crank_station(line: ShaftLine) -> int:
    """The station whose speed is that of the crankshaft: the first with a cylinder."""
    for place, station in enumerate(line.stations):
        if station.cylinder is not None or station.cylinders:
            return place
    return 0


def speed_ratios(count: int, joined: Sequence[Joined], start: int) -> Ratios:
    """Join stations one joint after the other; a joint within a piece has to agree with it."""
    ratio, members = [1.0] * count, [[station] for station in range(count)]
    piece = list(range(count))
    contradiction = None
    for place, one in enumerate(joined):
        found, wanted = ratio[one.second], ratio[one.first] * one.ratio
        if piece[one.first] != piece[one.second]:
            small, large = piece[one.second], piece[one.first]
            factor = wanted / found
            if len(members[small]) > len(members[large]):
                small, large, factor = large, small, 1.0 / factor
            for station in members[small]:
                ratio[station], piece[station] = ratio[station] * factor, large
            members[large] += members[small]
        elif contradiction is None and abs(found - wanted) > SAME_RATIO * abs(wanted):
            contradiction = (place, found / ratio[one.first], one.ratio)
    for number in set(piece):
        base = ratio[start if piece[start] == number else min(members[number])]
        for station in members[number]:
            ratio[station] /= base
    return Ratios(ratio, piece, contradiction)


def merged(count: int, rigid: Iterable[tuple[int, int]]) -> list[int]:
    """Freedom of each station: those that rigid gears hold together share one, in their order."""
    leader = list(range(count))

    def find(station: int) -> int:
        while leader[station] != station:
            leader[station] = leader[leader[station]]
            station = leader[station]
        return station

    for first, second in rigid:
        low, high = sorted((find(first), find(second)))
        leader[high] = low
    numbers = {root: place for place, root in enumerate(sorted({find(s) for s in range(count)}))}
    return [numbers[find(station)] for station in range(count)]
