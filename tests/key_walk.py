"""Every key that no shipped or starter case has, put into one of them, to be run and shown.

An aim is a place of the schema, an optional key or one value of a choice or a switch, of a kind of
machine whose cases have most of what stands above it. The values come from shipped cases that have
the key, from what the base case has there, from defaults and bounds, and from `VALUES` where none
of these is plausible. What has to come or to go along with it is read from the rules between keys,
and from what `check` says.
"""

import copy
import hashlib
import re
import shutil
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from schema_places import Pattern, places

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.fields import Table
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import EACH, apply_overrides, parse_key, set_key
from vibecalc.core.case.rules import ByKind, Needs, OneOf, Row
from vibecalc.core.case.walk import Shape, keys_of, shape_of
from vibecalc.core.run.plan import needs_of
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, KeyPath, Problem, UsageError
from vibecalc.kinds import KINDS
from vibecalc.schema import Case
from vibecalc.unit_table import DIMENSIONS

ROOT = Path(__file__).resolve().parents[1]
Data = dict[str, Any]

# ----------------------------------------------------------------------------
# The places of the schema, for each kind of machine.
# ----------------------------------------------------------------------------


class Aim(NamedTuple):
    """A key of a kind of machine; `value` is one of a choice or switch, None is any value."""

    kind: str
    pattern: Pattern
    value: Any = None

    def __str__(self) -> str:
        path = ".".join(self.pattern).replace(".*", "[0]")
        return f"{self.kind}: {path}" + ("" if self.value is None else f" = {self.value!r}")

    @property
    def number(self) -> int:
        """A number that is the same in every run, to share the aims out."""
        return int.from_bytes(hashlib.sha256(str(self).encode()).digest()[:6], "big")


def aims(kind: str) -> Iterator[Aim]:
    """Every optional key, and every value of choices and switches."""
    for pattern, (shape, _, field) in places(kind).items():
        if pattern == ("machine", "kind"):
            continue
        inner = shape.item if shape.item and shape.item.kind == "choice" else shape
        if inner.kind == "flag":
            yield from (Aim(kind, pattern, value) for value in (True, False))
        elif inner.kind == "choice" and len(inner.choices) > 1:
            yield from (Aim(kind, pattern, value) for value in inner.choices)
        elif not field.is_required():
            yield Aim(kind, pattern)


@cache
def every_aim() -> tuple[Aim, ...]:
    """What no shipped or starter case has, once, of the kind of machine that comes nearest."""
    wanted: dict[tuple[Pattern, Any], list[Aim]] = {}
    for kind in KINDS:
        for aim in aims(kind):
            wanted.setdefault((aim.pattern, repr(aim.value)), []).append(aim)
    found = []
    for each in wanted.values():
        if not any(_has(written(path), aim) for path in _files() for aim in each):
            found.append(min(each, key=lambda aim: min(_far(written(path), aim.pattern)
                                                       for path in _own(aim.kind))))  # fmt: skip
    return tuple(found)


def _has(data: Data, aim: Aim) -> bool:
    """Whether a case of the kind of an aim has it."""
    if data["machine"]["kind"] != aim.kind:
        return False
    there = [get(data, path) for path in spots(data, aim.pattern)]
    values = [one for some in there for one in (some if isinstance(some, list) else [some])]
    return bool(there) if aim.value is None else aim.value in values


# ----------------------------------------------------------------------------
# The cases into which keys are put, made light; and the values that they have.
# ----------------------------------------------------------------------------

#: numbers that only make a run long
LIGHTER: dict[Pattern, Any] = {
    ("response", "torsion", "speeds", "points"): 31,
    ("response", "impact", "members"): 3,
    ("response", "impact", "revolutions"): 6,
    ("response", "impact", "discard"): 2,
    ("optimisation", "robust", "samples"): 8,
    ("optimisation", "starts"): 1,
    ("optimisation", "front_points"): 3,
    ("find", EACH, "points"): 5,
    ("sweep", "axes", EACH, "points"): 3,
    ("sweep", "axes", EACH, "in_step", EACH, "points"): 3,
}
#: tables in which such a number stays away if it is: an axis may list values
_MAY_LACK: tuple[Pattern, ...] = (
    ("optimisation",),
    ("sweep", "axes", EACH),
    ("sweep", "axes", EACH, "in_step", EACH),
)

SEARCHES = ("optimisation", "fit", "find")
STUDIES = (*SEARCHES, "tuning", "damper_design")


class Base(NamedTuple):
    """A case with its name and the seconds that `check` says of it."""

    name: str
    data: Data
    seconds: float


@cache
def _files() -> tuple[Path, ...]:
    folders = (ROOT / "cases", ROOT / "vibecalc" / "starters")
    return tuple(path for folder in folders for path in sorted(folder.glob("*.toml")))


def files_beside(folder: Path) -> None:
    """Write the files that cases name into a folder."""
    for path in (ROOT / "cases").iterdir():
        if path.is_dir():
            shutil.copytree(path, folder / path.name)
        elif path.suffix != ".toml":
            shutil.copy(path, folder)
    for name, text in VALUES["files"].items():
        (folder / name).write_text(text, encoding="utf-8")
    _, names, *rows = (ROOT / "cases" / "roll_records.csv").read_text("utf-8").splitlines()
    bare = [re.sub(r" \[.*?\]", "", names).replace("tachometer", "speed")]
    bare += [re.sub(r",[^,]*", ", 930.0", row, count=1) for row in rows]
    (folder / "walk_record.csv").write_text("\n".join(bare), encoding="utf-8")
    untimed = "\n".join(row.partition(",")[2] for row in bare)
    (folder / "walk_untimed.csv").write_text(untimed, encoding="utf-8")


@cache
def written(path: Path) -> Data:
    """A case as TOML reads it."""
    return tomllib.loads(path.read_text(encoding="utf-8"))


@cache
def bases(kind: str) -> list[Base]:
    """Cases of a kind without what they are held against, the shortest first."""
    found = [_base(path) for path in sorted(_own(kind))]
    return sorted(found, key=lambda base: base.seconds)


@cache
def _own(kind: str) -> frozenset[Path]:
    return frozenset(path for path in _files() if written(path)["machine"]["kind"] == kind)


@cache
def _base(path: Path) -> Base:
    """A case without what it is held against."""
    data = copy.deepcopy(written(path))
    for key in ("limit", *(() if "fit" in data else ("reference", "reference_table"))):
        data.pop(key, None)
    del data.get("optimisation", {}).get("variables", [])[1:]
    lighten(data)
    (loaded,) = load_checked([data])
    return Base(path.stem, data, needs_of(loaded.case).seconds)


def lighten(data: Data, but: Pattern = ()) -> None:
    """Set the numbers that only make a run long, in the tables that are there."""
    for pattern, value in LIGHTER.items():
        for above in _tables(data, pattern[:-1]) if pattern != but else ():
            if pattern[:-1] not in _MAY_LACK or pattern[-1] in get(data, above):
                get(data, above)[pattern[-1]] = copy.deepcopy(value)


def get(data: Any, path: KeyPath) -> Any:
    """What stands at a path, or None."""
    for part in path:
        if isinstance(part, str):
            data = data.get(part) if isinstance(data, dict) else None
        else:
            data = data[part] if isinstance(data, list) and part < len(data) else None
    return data


def drop(data: Any, path: KeyPath) -> bool:
    """Take a key out, or an entry of a list; whether it was there."""
    above = get(data, path[:-1])
    if get(data, path) is None:
        return False
    del above[path[-1]]
    if above == [] or above == {}:
        drop(data, path[:-1])
    return True


def spots(data: Data, pattern: Pattern) -> list[KeyPath]:
    """Where a pattern is in a case, one of each set of keys that the entries of a list have."""
    found: list[KeyPath] = [()]
    for part in pattern:
        if part != EACH:
            found = [(*path, part) for path in found if isinstance(get(data, path), dict)]
            found = [path for path in found if path[-1] in get(data, path[:-1])]
            continue
        forms: dict[Any, KeyPath] = {}
        for path in found:
            rows = get(data, path)
            for number, row in enumerate(rows if isinstance(rows, list) else ()):
                if isinstance(row, dict):
                    kind = next((row[key] for key in ("kind", "model") if key in row), None)
                    forms.setdefault((path, frozenset(row), str(kind)), (*path, number))
        found = [*forms.values()]
    return found


@cache
def donors() -> dict[tuple[type[Table], str], list[tuple[str, Any]]]:
    """What shipped cases have at each key of each table, with the kind of their machine."""
    found: dict[tuple[type[Table], str], list[tuple[str, Any]]] = {}
    for path in _files():
        data = written(path)
        kind = data["machine"]["kind"]
        for pattern, place in places(kind).items():
            mine = found.setdefault((place.model, pattern[-1]), [])
            for spot in spots(data, pattern):
                value = get(data, spot)
                if (kind, value) not in mine:
                    mine.append((kind, value))
    return found


# ----------------------------------------------------------------------------
# Values that a key may plausibly have.
# ----------------------------------------------------------------------------

#: where nothing else gives a plausible value: the name of a table, its key, and values that come
#: before those of shipped cases
VALUES: dict[str, dict[str, list[Any]]] = tomllib.loads(
    (Path(__file__).parent / "key_values.toml").read_text(encoding="utf-8")
)


def given(model: type[Table], key: str, kind: str) -> list[Any]:
    """What a key may have: values from the table by hand, then those of shipped cases."""
    by_hand = VALUES.get(model.__name__, {}).get(key, [])
    shipped = sorted(donors().get((model, key), []), key=lambda one: one[0] != kind)
    return copy.deepcopy([*by_hand, *(value for _, value in shipped)])


_NUMBER = re.compile(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)(.*)", re.S)


def scaled(value: Any, factor: float) -> Any:
    """A number, or a text with a unit, times a factor."""
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        return float(f"{value * factor:.6g}")
    if isinstance(value, str) and (parts := _NUMBER.fullmatch(value)):
        return f"{float(parts[1]) * factor:.6g}{parts[2]}"
    if isinstance(value, list):
        return [scaled(one, factor) for one in value]
    return value


def names_in(data: Any) -> list[str]:
    """Every name in a case."""
    found: dict[str, None] = {}
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if key == "name" and isinstance(value, str):
            found[value] = None
        elif isinstance(value, dict | list):
            found.update(dict.fromkeys(names_in(value)))
    return [*found]


def values(aim: Aim, data: Data, spot: KeyPath) -> Iterator[Any]:
    """Values for the key of an aim at a spot of a case, the most plausible first."""
    place = places(aim.kind)[aim.pattern]
    if aim.value is not None:
        if place.shape.item is None:
            yield aim.value
        else:
            yield from ([aim.value], [*place.shape.item.choices])
        return
    present = get(data, spot)
    if present is not None and place.shape.kind == "number":
        yield from (scaled(present, factor) for factor in (1.1, 0.9, 1.5, 0.5))
    known = given(place.model, aim.pattern[-1], aim.kind)
    yield from (value for value in known[:6] if value != present)
    beside = [len(one) for one in get(data, spot[:-1]).values() if isinstance(one, list)]
    if beside and place.shape.kind == "list" and place.shape.item:
        for one in made(place.shape.item, None, data):
            rising = [scaled(one, 1.0 + 0.1 * row) for row in range(beside[0])]
            yield from (rising, [one] * beside[0])
    yield from made(place.shape, place.field.get_default(call_default_factory=True), data)
    if present is not None:
        yield present


def made(shape: Shape, default: Any, data: Data) -> Iterator[Any]:
    """Values made from shape and default alone."""
    if shape.kind == "number":
        if isinstance(default, int | float) and default:
            yield from (default * factor for factor in (1.1, 0.9, 0.5))
        examples = [0.5, 0.05, 2.0, 1e-3, 10.0, 100.0, 1e5, 1e-5]
        if shape.unit in DIMENSIONS and shape.unit:
            examples = [*re.findall(r"'(.*?)'", DIMENSIONS[shape.unit].examples), *examples]
        yield from examples
        if shape.or_three:
            yield [examples[0]] * 3
    elif shape.kind == "whole":
        bounds = dict(shape.bounds)
        low = int(bounds.get("ge", bounds.get("gt", -1) + 1))
        if isinstance(default, int):
            yield from (default + 1, default - 1)
        yield from (low + 1, low + 2, low, low + 10)
    elif shape.kind == "flag":
        yield from (True, False)
    elif shape.kind == "choice":
        yield from shape.choices
    elif shape.kind == "text":
        yield from names_in(data)[:12]
        yield "some words"
    elif shape.kind == "value":
        yield from (1.0, 0.1, 10.0)
    elif shape.kind == "labels":
        yield {}
    elif shape.kind == "list" and shape.item is not None:
        size = max(shape.lengths[0], 1)
        if shape.item.kind == "text":
            names = names_in(data)
            yield from (names[at : at + size] for at in range(min(len(names) - size + 1, 12)))
        else:
            for one in made(shape.item, None, data):
                rows = [scaled(copy.deepcopy(one), 1.0 + 0.1 * row) for row in range(size)]
                yield rows if shape.item.kind == "number" else [one] * size
    elif shape.kind == "table" and shape.table is not None:
        yield new_table(shape.table, data)


def new_table(model: type[Table], data: Data) -> Data:
    """A table with the keys that it must have."""
    found: Data = {}
    for key, field in keys_of(model).items():
        if field.is_required():
            found[key] = first_value(model, key, data)
    return found


def first_value(model: type[Table], key: str, data: Data, kind: str = "") -> Any:
    """A value for a key that has to come along."""
    known = given(model, key, kind)
    if known:
        return known[0]
    field = keys_of(model)[key]
    return next(made(shape_of(field), None, data), None)


# ----------------------------------------------------------------------------
# A key in its place, and what has to come or go along with it.
# ----------------------------------------------------------------------------


def problems_of(data: Data) -> list[Problem]:
    """All that `check` finds wrong with a case."""
    try:
        with_files = copy.deepcopy(data)
        validate(with_files, attach_files(with_files, Path()))  # without the words for people
        load_checked([data])
    except CaseError as error:
        return list(error.problems)
    return []


def plans(aim: Aim) -> Iterator[tuple[str, Data]]:
    """Cases that have the key and that `check` takes, each with the name of its base."""
    refused = REFUSED[aim] = Counter[str]()
    by_hand = [base for row in _rows("together", aim) for base in _by_hand(aim, row)]
    if aim.value is None:
        yield from ((base.name, base.data) for base in by_hand if spots(base.data, aim.pattern))

    own = sorted(bases(aim.kind), key=lambda base: (*_far(base.data, aim.pattern), base.seconds))
    for base in by_hand or own[:8]:
        if not by_hand:  # what is searched for is another matter
            kept = {key: one for key, one in base.data.items() if key not in SEARCHES}
            here = {key: base.data[key] for key in SEARCHES if key == aim.pattern[0] in base.data}
            base = base._replace(data=kept | here)
        for spot in _made_spots(base.data, aim)[:4]:
            tried: list[Any] = []
            for value in values(aim, spot[0], spot[1]):
                if value in tried or value is None:
                    continue
                tried.append(value)
                data = copy.deepcopy(spot[0])
                set_key(data, spot[1], copy.deepcopy(value))
                lighten(data, aim.pattern)
                why = settle(data, spot[1], aim.kind)
                if not why:
                    yield base.name, data
                    continue
                refused[why] += 1
                if len(tried) > 12 or refused[why] > 6 or refused.total() > 60:
                    break
            if refused.total() > 60 or (refused and max(refused.values()) > 14):
                return


#: what `check` said of cases with a key that it does not take, and how often
REFUSED: dict[Aim, Counter[str]] = {}


def _rows(name: str, aim: Aim | str) -> list[Any]:
    """Rows of the table by hand whose keys an aim is one of."""
    return [row for row in VALUES[name] if re.search(row["keys"], str(aim))]


def _by_hand(aim: Aim, row: Any) -> Iterator[Base]:
    """Cases with keys that have to stand together, of which the aim is one."""
    words = next(one for one in VALUES["study"].values() if aim.kind in one["kinds"])
    settings = _filled(row.get("set", {}), {**words, "value": aim.value})
    name = row.get("base") or (words["base"] if settings != row.get("set", {}) else "")
    named = [_base(path) for path in _own(aim.kind) if path.stem == name]
    for base in named if name else bases(aim.kind)[:6]:
        data = copy.deepcopy(base.data)
        unset = [key for key in row.get("unset", ()) if get(data, parse_key(key)) is not None]
        try:
            apply_overrides(data, [*copy.deepcopy(settings).items()], unset)
        except UsageError as error:
            REFUSED[aim][str(error)] += 1
            continue
        if row.get("stored"):  # as it stands in a result: with what was read from files
            attach_files(data, Path())
        (spot, *_) = spots(data, aim.pattern) or [_KIND]
        why = settle(data, spot, aim.kind)
        if not why:
            yield Base(base.name, data, base.seconds)
        REFUSED[aim].update(_words(problem) for problem in problems_of(data))


def _filled(value: Any, words: Data) -> Any:
    """A value with the words of a kind of machine in it, where it says `$word` or `$word[0]`."""
    if isinstance(value, dict):
        return {_filled(key, words): _filled(one, words) for key, one in value.items()}
    if isinstance(value, list):
        return [_filled(one, words) for one in value]
    if isinstance(value, str) and value.startswith("$"):
        return get(words, parse_key(value[1:]))
    return value


def _far(data: Data, pattern: Pattern) -> tuple[int, bool, bool]:
    """How many tables above a key a case lacks, whether it searches, and whether it has no key."""
    searches = any(study in data and pattern[0] != study for study in STUDIES)
    for size in range(len(pattern), 0, -1):
        if spots(data, pattern[:size]):
            return max(len(pattern) - 1 - size, 0), searches, size < len(pattern)
    return len(pattern), searches, True


def _tables(data: Data, above: Pattern) -> list[KeyPath]:
    """Where a table is, or a list of tables, in a case; not what is in a file."""
    there = spots(data, above) if above else [()]
    return [path for path in there if isinstance(get(data, path), dict | list)]


def _made_spots(data: Data, aim: Aim) -> list[tuple[Data, KeyPath]]:
    """The case with every table above the key, and where the key then stands."""
    above = aim.pattern[:-1]
    there = _tables(data, above)
    found = [(data, (*path, aim.pattern[-1])) for path in there]
    if found:
        return sorted(found, key=lambda one: get(data, one[1]) is None)
    known = places(aim.kind)
    size = next(size for size in range(len(above), -1, -1) if _tables(data, above[:size]))
    options = []
    for path in _tables(data, above[:size]):
        for choice in range(3):
            new = copy.deepcopy(data)
            spot: KeyPath = path
            for at in range(size, len(above)):
                if above[at] == EACH:
                    spot = (*spot, 0)
                    continue
                place = known[above[: at + 1]]
                spot = (*spot, above[at])
                ready = given(place.model, above[at], aim.kind)
                ready = [value for value in ready if isinstance(value, dict | list)]
                if choice < len(ready):
                    value: Any = ready[choice]
                elif place.shape.table is not None:
                    value = new_table(place.shape.table, new)
                else:
                    item = place.shape.item
                    value = [new_table(item.table, new)] if item and item.table else None
                set_key(new, spot, value)
            if isinstance(get(new, spot), dict):
                options.append((new, (*spot, aim.pattern[-1])))
    return options


def settle(data: Data, ours: KeyPath, kind: str) -> str:
    """Let come and go what has to along with the key at `ours`; what `check` refuses then."""
    value = copy.deepcopy(get(data, ours))
    seen = []
    for _ in range(12):
        problems = problems_of(data)
        if not problems:
            now = get(data, ours)
            table = isinstance(now, dict) or (
                isinstance(now, list) and now and isinstance(now[0], dict)
            )
            return "" if now == value or table or (now and isinstance(now, list)) else "it went"
        before = copy.deepcopy(data)
        for problem in problems:
            _mend(data, problem, ours, kind)
        if data == before or data in seen or get(data, ours) is None:
            return _words(problems[0])
        seen.append(before)
    return "no end"


def _words(problem: Problem) -> str:
    """What is wrong, whatever the numbers are."""
    return re.sub(r"[-+]?\d[\d.]*", "N", problem.message)


_NAMED = re.compile(r"no (.+?) is named")
_ABSENT = re.compile(r"there is no (\w+) named")
_NEEDS = re.compile(r"needs? \[([\w.]+)\]|(?:needs?|and) (\w+\.[\w.]+)")


def _model_at(path: KeyPath, kind: str) -> type[Table] | None:
    pattern = tuple(EACH if isinstance(part, int) else part for part in path)
    if not pattern:
        return Case
    place = places(kind).get(pattern if pattern[-1] != EACH else pattern[:-1])
    if place is None:
        return None
    return _model_of(place.shape)


def _model_of(shape: Shape) -> type[Table] | None:
    return shape.table or (shape.item.table if shape.item else None)


def _mend(data: Data, problem: Problem, ours: KeyPath, kind: str) -> None:
    """Change the case where a problem is, but not the key at `ours`."""
    for path in (problem.path, problem.path[:-1]):
        table, model = get(data, path), _model_at(path, kind)
        if isinstance(table, dict) and model is not None:
            row = Row(table, path, data, model)
            changed = [_by_rule(row, rule, ours, kind) for rule in model.RULES]
            if any(changed):
                return
    path = problem.path
    needed = [one or other for one, other in _NEEDS.findall(problem.message)]
    came = [_fill(data, tuple(place.split(".")), kind) for place in needed]
    if any(came):
        return
    if path and isinstance(path[-1], str) and "missing key" in problem.message:
        _fill(data, path, kind)
        return
    if _NAMED.search(problem.message) and path != ours:
        known = re.findall(r"'(.*?)'", problem.allowed)
        if known and get(data, path) is not None:
            beside = get(data, path[:-1]) if isinstance(path[-1], int) else ()
            set_key(data, path, next((name for name in known if name not in beside), known[0]))
            return
    absent = _ABSENT.match(problem.message)
    if absent and isinstance(place := get(data, path), dict) and ours[: len(path)] != path:
        place[absent[1]] = re.findall(r"'(.*?)'", problem.allowed)[0]
        return
    if _set_as_said(data, problem, ours) or _said(data, problem, kind):
        return
    if (beside := _BESIDE.match(problem.allowed)) and _fill(
        data, (*beside[2].split("."), beside[1]), kind
    ):
        return
    mine = ours[: len(path)] == path
    for other in (problem.also or (),) if mine else (path, problem.also or ()):
        kept = not other or ours[: len(other)] == other or _needed(other, kind)
        if not kept and drop(data, other):
            return


_KEY = re.compile(r"\b[a-z][a-z_]+\b")


_VALUE = re.compile(r"(\w+) = ['\"](\w+)['\"]")


def _set_as_said(data: Data, problem: Problem, ours: KeyPath) -> bool:
    """Give a key the value that a problem has for it, as `model = 'rigid_body'`."""
    for key, value in _VALUE.findall(problem.allowed):
        for path in (problem.path, problem.also or ()):
            place = path if path and path[-1] == key else (*path, key)
            if place == ours or get(data, place) in (None, value) or place[-2:] == _KIND:
                continue
            set_key(data, place, value)
            return True
    return False


_KIND = ("machine", "kind")


def _said(data: Data, problem: Problem, kind: str) -> bool:
    """Fill in the first key that the table lacks and that the words of a problem ask for."""
    for path in (problem.path, problem.path[:-1]):
        table, model = get(data, path), _model_at(path, kind)
        if isinstance(table, dict) and model is not None:
            keys = [*_KEY.findall(problem.allowed)[:3], *_KEY.findall(problem.message)]
            return any(_fill(data, (*path, key), kind) for key in keys if key not in table)
    return False


def _needed(path: KeyPath, kind: str) -> bool:
    """Whether a case cannot be without this key."""
    place = places(kind).get(tuple(EACH if isinstance(part, int) else part for part in path))
    return place is not None and (place.field.is_required() or path in _EVERY_MACHINE)


_EVERY_MACHINE = (("machine", "speed"), ("machine", "crank_train"), ("machine", "shaft_line"))
_BESIDE = re.compile(r"(\w+) in \[([\w.]+)\]")


def _fill(data: Data, path: KeyPath, kind: str) -> bool:
    above = get(data, path[:-1])
    model = _model_at(path[:-1], kind)
    if not isinstance(above, dict) or model is None or path[-1] not in keys_of(model):
        return False
    if path[-1] in above:
        return False
    value = first_value(model, str(path[-1]), data, kind)
    if value is None:
        return False
    above[path[-1]] = value
    return True


def _by_rule(row: Row, rule: Any, ours: KeyPath, kind: str) -> bool:
    """Follow a rule that says which keys go together; whether anything was changed."""
    mine = (
        str(ours[len(row.path)])
        if ours[: len(row.path)] == row.path and len(ours) > len(row.path)
        else ""
    )
    if not isinstance(rule, OneOf | Needs | ByKind) or not [*rule(row)]:
        return False
    if isinstance(rule, OneOf):
        given = [one for one in rule.alternatives if row.said(*one)]
        if not given:
            return _fill(row.case, (*row.path, rule.alternatives[0][0]), kind)
        kept = next((one for one in given if mine in one), given[0])
        for one in given:
            for key in one if one is not kept else ():
                row.data.pop(key, None)
        return True
    if isinstance(rule, Needs):
        return any(_fill(row.case, (*row.path, other), kind) for other in rule.others)
    owners = [name for name, keys in rule.kinds.items() if mine in (*keys[0], *keys[1])]
    present = rule.kind_of(row) if rule.kind_of else row[rule.key]
    if owners and present not in owners and mine != rule.key:
        row.data[rule.key] = owners[0]
        present = owners[0]
    if present not in rule.kinds:
        return False
    needed, others = rule.kinds[present]
    for key in row.said(*(key for key in row.data if key in rule._known())):
        if key not in (*needed, *others):
            del row.data[key]
    if rule.key not in row.data:
        row.data[rule.key] = present
    for key in needed:
        _fill(row.case, (*row.path, key), kind)
    return True


def refused_always(aim: Aim) -> bool:
    """Whether the list of what no run can reach has this key, with the words `check` has for it."""
    said = REFUSED.get(aim, ())
    return any(re.fullmatch(row["why"], one) for row in _rows("unreached", aim) for one in said)


def without_number(aim: Aim | str, said: str) -> dict[str, Any] | None:
    """The row of what only a run can refuse that has this key, with the words of the run."""
    words = said.rpartition("error: ")[2]
    rows = (row for row in _rows("without_number", aim) if re.fullmatch(row["why"], words))
    return next(rows, None)
