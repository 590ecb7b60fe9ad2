"""Results described by the fields of classes: path, unit and words said once.

A class names its `ROOT`; a result is the field of it, and its path is root and field:

    class Modes(Group):
        ROOT: ClassVar[str] = "isolation/modes"
        natural_frequency: Any = q("mode", "rad/s", "undamped natural frequency")

`scene.emit_all(Modes(natural_frequency=found), {"mode": numbers})` hands results over.

Families of results that differ in a name are classes below one, each with a `ROOT` of its own and
the `WORDS` that stand where the entries have names in braces:

    class Energy(Group):
        ROOT: ClassVar[str]
        mean: Any = q("", "J", "mean {kind} energy over a turn")

    class Kinetic(Energy):
        ROOT = "response/kinetic_energy"
        WORDS: ClassVar = {"kind": "kinetic"}
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, dataclass_transform

from vibecalc.core.results.record import READ, Entry, Headline, entry


@dataclass_transform(frozen_default=True)
class Group:
    """Results below a root, by field; those not given are None.

    Type checkers treat a group as a frozen dataclass. It is not one, since building the methods of
    some eighty dataclasses takes a tenth of the start of a run.
    """

    ROOT: ClassVar[str]
    WORDS: ClassVar[Mapping[str, str]] = {}
    #: field -> what is known of it, without its path
    KNOWN: ClassVar[Mapping[str, Entry]] = {}

    def __init_subclass__(cls) -> None:
        own = {name: one for name, one in vars(cls).items() if isinstance(one, Entry)}
        cls.KNOWN = {**cls.KNOWN, **own}
        for name in own:
            setattr(cls, name, None)

    def __init__(self, *values: Any, **named: Any) -> None:
        given = dict(zip(self.KNOWN, values, strict=False)) | named
        if len(given) < len(values) + len(named) or given.keys() - self.KNOWN.keys():
            raise TypeError(f"{type(self).__name__} has the fields {', '.join(self.KNOWN)}")
        vars(self).update(given)


def q(axes: str, unit: str, long_name: str, amplitude: str | None = None, **more: Any) -> Any:
    """A result as a field, described as an `entry` is, but for its path."""
    return entry("", axes, unit, long_name, amplitude, **more)


def named(axes: str, unit: str, name: str, amplitude: str | None = None, **more: Any) -> Any:
    """A result whose words are its name in tables, too."""
    return q(axes, unit, name, amplitude, name=name, **more)


def lead(
    axes: str,
    unit: str,
    name: str,
    amplitude: str | None = None,
    *,
    read: str = "",
    pick: str = "largest",
    unless: str = "",
    about: str = "",
    each: str = "",
    **more: Any,
) -> Any:
    """A result that stands in the first table under its name, in the unit that people read.

    `read` is that unit where it is not the usual one, `about` words that the table does without;
    `each` is what one of several entries is called.
    Where the group has a field `X_speed` for a field X, it is the speed at which X is met.
    """
    headline = Headline(name, read or READ.get(unit, unit), pick, unless=unless)
    long_name = f"{name}, {about}" if about else name
    return q(axes, unit, long_name, amplitude, headline=headline, name=each, **more)


def entries_of(*groups: type[Group]) -> Iterator[Entry]:
    """What is known of the results of groups, in the order of their fields."""
    for group in groups:
        names = paths_of(group)
        for path, one in zip(names, group.KNOWN.values(), strict=True):
            known: Entry = _filled(one, group.WORDS) if group.WORDS else one
            if known.headline and f"{path}_speed" in names:
                known = known._replace(headline=known.headline._replace(at=f"{path}_speed"))
            yield known._replace(path=path)


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
    if unknown := set(names) - set(group.KNOWN):
        raise ValueError(f"{group.__name__} has no {', '.join(sorted(unknown))}")
    return tuple(f"{group.ROOT}/{name}" for name in names or group.KNOWN)


def given_in(group: Group) -> Iterator[tuple[str, Any]]:
    """Paths and values of the results that are given."""
    for name in group.KNOWN:
        if (value := getattr(group, name)) is not None:
            yield f"{group.ROOT}/{name}", value
