"""Checks of form of the parts of a machine: a body and its mounts from parts or from matrices."""

from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.raw import Data, either, misspelt, read_number, table_at, tables_at
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.parts.tables import BlockMatrix, DampingMatrix, MassMatrix, StiffnessMatrix
from vibecalc.units import convert

BODY: KeyPath = ("machine", "body")
MOUNTS: KeyPath = ("machine", "mounts")
#: what goes with a matrix of the suspension only
_WITH_MATRIX = ("damping_matrix", "loss_factor")
_BLOCKS = ("translation", "coupling", "rotation")
_MATRICES: tuple[tuple[KeyPath, type[BlockMatrix]], ...] = (
    ((*BODY, "mass_matrix"), MassMatrix),
    ((*MOUNTS, "stiffness_matrix"), StiffnessMatrix),
    ((*MOUNTS, "damping_matrix"), DampingMatrix),
)
#: a table of columns -> its columns
_COLUMNS: tuple[tuple[KeyPath, tuple[str, ...]], ...] = (
    (("machine", "crank_train", "gas_pressure"), ("crank_angle", "pressure")),
    (("machine", "motor", "torque"), ("order", "cosine", "sine")),
    (("machine", "motor", "slip_table"), ("slip", "torque")),
    (("response", "start_up", "load"), ("time", "factor")),
)
#: a list of tables, the key of each that holds a table of columns, its columns
_LISTED: tuple[tuple[tuple[str, ...], str, tuple[str, ...]], ...] = (
    (("machine", "crank_train", "cylinders"), "gas_force", ("crank_angle", "force")),
    (("machine", "crank_train", "gas_cards"), "gas_pressure", ("crank_angle", "pressure")),
    (("response", "torsion", "limits"), "curve", ("speed", "stress")),
)


def check_parts(data: Data) -> Iterator[Problem]:
    """Yield the problems of body, mounts, units of matrices, and columns of tables."""
    yield from _body(data)
    yield from _mounts(data)
    yield from _units(data)
    yield from _columns(data)


def _body(data: Data) -> Iterator[Problem]:
    body = table_at(data, "machine").get("body")
    if not isinstance(body, dict):
        return
    products = body.get("inertia_products")
    entries = products if isinstance(products, list) else []
    with_products = any(read_number(entry, "kg*m^2") for entry in entries)
    if "mass_matrix" in body:
        others = ("mass", "box", "inertia", "inertia_products", "inertia_block")
        given = {key: value for key, value in body.items() if key != others[3] or with_products}
        yield from either(given, BODY, "mass_matrix", others, needed=False)
        return
    complete = "mass" in body and body.keys() & {"inertia", "box"}
    if not complete and misspelt(body, BODY, "mass_matrix"):
        return
    if "mass" not in body and not misspelt(body, BODY, "mass"):
        yield Problem(
            path=(*BODY, "mass"),
            message="missing key 'mass' in [machine.body]",
            allowed="a mass > 0 kg, e.g. '0.4 kg' or '400 g', or a mass_matrix instead of parts",
            hint="mass: of the whole machine",
        )
    yield from either(body, BODY, "inertia", ("box",))
    if "box" in body and with_products:
        yield Problem(
            path=(*BODY, "inertia_products"),
            message="inertia_products go with inertia: a box has none",
            also=(*BODY, "box"),
        )


def _mounts(data: Data) -> Iterator[Problem]:
    mounts = table_at(data, "machine").get("mounts")
    if not isinstance(mounts, dict):  # an empty table asks for mounts and has none
        return
    if "stiffness_matrix" in mounts:
        others = ("positions", "individual", "each")
        yield from either(mounts, MOUNTS, "stiffness_matrix", others, needed=False)
        return
    alone = [key for key in _WITH_MATRIX if key in mounts]
    for key in alone:
        yield Problem(
            path=(*MOUNTS, key),
            message=f"{key} goes with stiffness_matrix",
            allowed="stiffness_matrix beside it",
            hint="mounts with places have their damping and loss_factor in [machine.mounts.each] "
            "or one by one",
        )
    yield from either(mounts, MOUNTS, "positions", ("individual",), needed=False)
    ways = ("positions", "individual", "stiffness_matrix")
    if not alone and not mounts.keys() & set(ways) and not misspelt(mounts, MOUNTS, *ways):
        yield Problem(
            path=MOUNTS,
            message="[machine.mounts] has neither positions nor individual nor stiffness_matrix",
            allowed="positions of equal mounts, individual mounts, or one stiffness_matrix",
        )
    yield from _stiffness(data, mounts)


def _stiffness(data: Data, mounts: Data) -> Iterator[Problem]:
    each = table_at(mounts, "each")
    if "each" in mounts and not isinstance(mounts["each"], dict):
        return
    if "positions" in mounts and "stiffness" not in each:
        yield Problem(
            path=(*MOUNTS, "each") if each else MOUNTS,
            message="mounts given by positions have no stiffness",
            allowed="each = { stiffness = ... }",
        )
    for position, mount in tables_at(data, "machine", "mounts", "individual"):
        if "stiffness" not in mount and "stiffness" not in each:
            yield Problem(
                path=(*MOUNTS, "individual", position),
                message=f"mount {mount.get('name', position + 1)!r} has no stiffness",
                allowed="a stiffness of its own, or one in [machine.mounts.each]",
            )


def _units(data: Data) -> Iterator[Problem]:
    for path, kind in _MATRICES:
        units = table_at(data, *path).get("units")
        if not isinstance(units, list) or len(units) != len(kind.SI):
            continue
        for position, (unit, si) in enumerate(zip(units, kind.SI, strict=True)):
            if isinstance(unit, str) and 0 < len(unit) <= 80:
                yield from _unit((*path, "units", position), unit, si, _BLOCKS[position])


def _unit(path: KeyPath, unit: str, si: str, block: str) -> Iterator[Problem]:
    said, found, hint = "", f"{unit!r}", ""
    try:
        factor = convert(1.0, unit, si)
        if not 1e-100 < factor < 1e100:
            said = "too far from SI to compute with"
    except UnitError as error:
        said, hint = error.message, error.hint
        if said == "wrong dimension":
            found = f"{unit!r}, {error.found}"
    if "rad" in unit:
        hint = "an angle counts as a plain number here: leave rad out"
    if said:
        yield Problem(
            path=path,
            message=f"{path[-3]}, unit of the {block} block: {said}",
            found=found,
            allowed=f"a unit that converts to {si}",
            hint=hint,
        )


def _columns(data: Data) -> Iterator[Problem]:
    nested: list[tuple[KeyPath, tuple[str, ...]]] = [
        ((*above, place, key), names)
        for above, key, names in _LISTED
        for place, _ in tables_at(data, *above)
    ]
    for path, names in (*_COLUMNS, *nested):
        table = table_at(data, *path)
        lists = {name: table[name] for name in names if isinstance(table.get(name), list)}
        sizes = [len(entries) for entries in lists.values()]
        if len(set(sizes)) > 1 and not _too_short(path, lists):
            yield Problem(
                path=path,
                message=f"the columns of {path[-1]} are not of one length",
                found=", ".join(f"{len(entries)} of {name}" for name, entries in lists.items()),
                allowed="as many entries in each",
            )


def _too_short(path: KeyPath, lists: dict[str, list[Any]]) -> bool:
    """Whether the schema refuses one of these columns, whatever the others are."""
    from vibecalc.core.case.walk import keys_of, shape_at

    shape = shape_at(path)
    fields = keys_of(shape.table) if shape is not None and shape.table is not None else {}
    return any(
        len(lists[name]) < getattr(rule, "min_length", 0)
        for name, field in fields.items()
        if name in lists
        for rule in field.metadata
    )
