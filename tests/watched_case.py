"""A case that remembers which of its places were read."""

from typing import Any

from vibecalc.case.fields import Table
from vibecalc.machine.build import MachineParts

#: attribute of the parts of a machine -> what it is built from
PARTS = {
    "crank_train": ("machine.crank_train", "excitation.working", "excitation.idle"),
    "rotating_masses": (
        "machine.crank_train",
        "excitation.working",
        "excitation.idle",
        "excitation.balanced_for",
    ),
    "body": ("machine.body",),
    "mounts": ("machine.mounts",),
}


class Watched:
    """Stands for a table of a case; what is read of it is added to `seen`, by attribute path."""

    def __init__(self, table: Table, path: str, seen: set[str]):
        self.__dict__["_watched"] = (table, path, seen)

    def __getattr__(self, name: str) -> Any:
        table, path, seen = self._watched
        if name.startswith(("model_", "__")):
            seen.add(path)  # all of it
            return getattr(table, name)
        place = f"{path}.{name}" if path else name
        seen.add(place)
        return _watch(getattr(table, name), place, seen)

    def __eq__(self, other: object) -> bool:
        raise AssertionError("a stage compares a whole table")

    def __hash__(self) -> int:
        raise AssertionError("a stage takes the hash of a whole table")


class WatchedParts:
    """Stands for the parts of a machine."""

    def __init__(self, parts: MachineParts, seen: set[str]):
        self.__dict__["_watched"] = (parts, seen)

    def __getattr__(self, name: str) -> Any:
        parts, seen = self._watched
        seen.update(PARTS[name])
        return getattr(parts, name)


class WatchedEntries(dict[str, Any]):
    """What stages hand on; the names that are looked up are kept in `read`."""

    def __init__(self, *given: Any):
        super().__init__(*given)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.read.add(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self.read.add(str(name))
        return super().__contains__(name)


def undeclared(seen: set[str], declared: tuple[str, ...]) -> list[str]:
    """Places that were read and are neither declared, nor below or above what is.

    A table above a declared place is read to get there. That it is absent shows in the place.
    """
    return sorted(
        place
        for place in seen
        if not any(
            f"{place}.".startswith(f"{one}.") or one.startswith(f"{place}.") for one in declared
        )
    )


def _watch(found: Any, place: str, seen: set[str]) -> Any:
    if isinstance(found, Table):
        return Watched(found, place, seen)
    if isinstance(found, tuple) and any(isinstance(entry, Table) for entry in found):
        return tuple(Watched(entry, place, seen) for entry in found)
    return found
