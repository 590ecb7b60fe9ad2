"""Can mounts that depend on load or frequency be, and does what is asked of them have an answer?"""

from collections.abc import Iterator

from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.parts import body_tables as parts
from vibecalc.parts.mount_needs import foundation_kind, frequency_counts, loads_count
from vibecalc.parts.mounts import mount_entries
from vibecalc.schema import Case

MOUNTS: KeyPath = ("machine", "mounts")
#: properties of mounts and where they stand
_At = tuple[KeyPath, parts.MountProperties | None]
_ROWS = ("over_frequency", "over_load")
_PLACED = "model = 'rigid_body', or 'planar'"


@listing
def mount_problems(case: Case) -> Iterator[Problem]:
    """Problems of mounts of which some have static, over_load or over_frequency."""
    given, isolation = case.machine.mounts, case.isolation
    assert given is not None
    yield from _twice(given)
    yield from _factor_of_nothing(given)
    where = _place_of(given)
    if isolation is not None and isolation.model == "pitch":
        yield Problem(
            path=("isolation", "model"),
            message="the pitch model takes mounts of constant stiffness",
            found=f"{where[-1]} of [machine.mounts]",
            allowed=_PLACED,
            also=where,
        )
    if loads_count(given) and isolation is None:
        yield Problem(
            path=where,
            message="the static load of a mount needs [isolation], which defines the vertical",
            allowed=f"[isolation] with {_PLACED}, or mounts of constant stiffness",
        )
    if frequency_counts(given):
        yield from _of_one_frequency(case, _place_of(given, ("over_frequency",)))


def _tables(mounts: parts.Mounts) -> list[_At]:
    """All tables with properties of mounts, that of `each` first."""
    own = [((*MOUNTS, "individual", n), one) for n, one in enumerate(mounts.individual or ())]
    return [((*MOUNTS, "each"), mounts.each), *own]


def _place_of(mounts: parts.Mounts, keys: tuple[str, ...] = ("static", *_ROWS)) -> KeyPath:
    """Where the first of these keys stands."""
    return next(
        (*path, key) for path, one in _tables(mounts) for key in keys if getattr(one, key, None)
    )


def _twice(mounts: parts.Mounts) -> Iterator[Problem]:
    """Of each mount, with what it takes from `each`, a value stands once."""
    common, *own = _tables(mounts)
    for tables in [[one, common] for one in own] or [[common]]:
        for value in ("stiffness", "loss_factor"):
            places = [_stands(tables, value), *(_stands(tables, rows, value) for rows in _ROWS)]
            found = [place for place in places if place is not None]
            if len(found) > 1:
                yield Problem(
                    path=found[1],
                    message=f"the {value.replace('_', ' ')} of a mount is given twice",
                    found=" and ".join(".".join(map(str, place)) for place in found),
                    allowed=f"{value} in one place"
                    + (", stiffness_factor in the others" if value == "stiffness" else ""),
                    also=found[0],
                )
                return


def _factor_of_nothing(mounts: parts.Mounts) -> Iterator[Problem]:
    """A factor over the load is one on a stiffness, also beside a load over deflection."""
    for one in mount_entries(mounts):
        rows = one.over_load
        if rows is not None and rows.stiffness_factor and one.stiffness is None:
            yield Problem(
                path=_place_of(mounts, ("over_load",)),
                message=f"stiffness_factor of over_load has no stiffness of mount {one.name!r} to "
                "multiply",
                allowed="stiffness of the mount, or over_load with stiffness",
            )
            return


def _stands(tables: list[_At], key: str, column: str = "") -> KeyPath | None:
    """Where a key of a mount stands, in the first of the tables that has it, or a column of it."""
    for path, table in tables:
        value = None if table is None else getattr(table, key)
        if value is not None:
            if not column:
                return (*path, key)
            return None if getattr(value, column, None) is None else (*path, key, column)
    return None


def _of_one_frequency(case: Case, where: KeyPath) -> Iterator[Problem]:
    """Results of no frequency, or of all at once, take no stiffness over frequency."""
    response, mounts = case.response, case.machine.mounts
    asked: list[tuple[bool, KeyPath, str]] = [
        (foundation_kind(case) == "mass", ("foundation",), "a foundation of one mass"),
        (
            mounts is not None and bool(mounts.modal_damping),
            (*MOUNTS, "modal_damping"),
            "damping by modes",
        ),
    ]
    if response is not None:
        asked += [
            (response.method == "modal", ("response", "method"), "superposition of modes"),
            (response.energies, ("response", "energies"), "the potential energy of all orders"),
            (bool(response.operations), ("response", "operations"), "the ways of running"),
            (response.run_up is not None, ("response", "run_up"), "the energies of a run-up"),
            (response.switching is not None, ("response", "switching"), "a motion in time"),
        ]
    for there, path, words in asked:
        if there:
            yield Problem(
                path=path,
                message=f"{words} needs mounts whose stiffness does not change with frequency",
                found="over_frequency of a mount",
                allowed="mounts without over_frequency, or leave it out",
                hint="each order of [isolation], and of [response] by the direct method, has the "
                "stiffness of its own frequency",
                also=where,
            )
