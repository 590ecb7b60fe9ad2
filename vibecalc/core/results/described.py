"""Results described by the fields of frozen dataclasses: path, unit and words said once.

A class names its `ROOT`; a result is the field of it, and its path is root and field:

    @dataclass(frozen=True)
    class Modes:
        ROOT: ClassVar[str] = "isolation/modes"
        natural_frequency: Any = q("mode", "rad/s", "undamped natural frequency")

`scene.emit_all(Modes(natural_frequency=found), {"mode": numbers})` hands results over.

Families of results that differ in a name are classes below one, each with a `ROOT` of its own and
the `WORDS` that stand where the entries have names in braces:

    @dataclass(frozen=True)
    class Energy:
        ROOT: ClassVar[str]
        mean: Any = q("", "J", "mean {kind} energy over a turn")

    class Kinetic(Energy):
        ROOT = "response/kinetic_energy"
        WORDS: ClassVar = {"kind": "kinetic"}
"""

from collections.abc import Iterator, Mapping
from dataclasses import field, fields
from typing import Any, ClassVar, Protocol

from vibecalc.core.results.record import Entry, Headline, entry


class Group(Protocol):
    """A frozen dataclass whose fields are results below its root; those not given are None."""

    ROOT: ClassVar[str]
    __dataclass_fields__: ClassVar[dict[str, Any]]


def q(axes: str, unit: str, long_name: str, amplitude: str | None = None, **more: Any) -> Any:
    """A result as a field, described as an `entry` is, but for its path."""
    return field(
        default=None, metadata={"entry": entry("", axes, unit, long_name, amplitude, **more)}
    )


def entries_of(*groups: type[Group]) -> Iterator[Entry]:
    """What is known of the results of groups, in the order of their fields."""
    for group in groups:
        words = getattr(group, "WORDS", {})
        for one in fields(group):
            known: Entry = _filled(one.metadata["entry"], words)
            yield known._replace(path=f"{group.ROOT}/{one.name}")


def _filled(part: Any, words: Mapping[str, str]) -> Any:
    """A text, or a tuple with texts, with the words of a family in place of their names."""
    if isinstance(part, str):
        return part.format(**words)
    if isinstance(part, tuple):
        filled = [_filled(one, words) for one in part]
        return type(part)(*filled) if isinstance(part, Entry | Headline) else tuple(filled)
    return part


def paths_of(group: type[Group], *names: str) -> tuple[str, ...]:
    """Paths of the results of a group: of all, or of some fields."""
    known = [one.name for one in fields(group)]
    if unknown := set(names) - set(known):
        raise ValueError(f"{group.__name__} has no {', '.join(sorted(unknown))}")
    return tuple(f"{group.ROOT}/{name}" for name in names or known)


def given_in(group: Group) -> Iterator[tuple[str, Any]]:
    """Paths and values of the results that are given."""
    for one in fields(group):
        if (value := getattr(group, one.name)) is not None:
            yield f"{group.ROOT}/{one.name}", value
