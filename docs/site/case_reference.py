"""The reference of case files, from the schema: each table and each of its keys.

Type, unit, bounds and allowed values are the words that messages have for them (`walk.words`);
an example is what a starter or a shipped case has there, else its default or a value of its kind.
"""

import functools
import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w
from page_parts import cell, code, table, toctree

from vibecalc.core.case.fields import Table
from vibecalc.core.case.row_files import LISTS
from vibecalc.core.case.rules import ByKind, Needs, OneOf, both
from vibecalc.core.case.walk import Shape, examples_of, keys_of, noun, shape_of, words
from vibecalc.schema import Case

ROOT = Path(__file__).resolve().parents[2]
STARTERS = sorted((ROOT / "vibecalc" / "starters").glob("*.toml"))
SHIPPED = sorted((ROOT / "cases").glob("*.toml"))
#: letters of an example that is shown
_LONGEST = 90


class Place(NamedTuple):
    """A table of the schema, the headers under which a case may have it, and its page."""

    model: type[Table]
    headers: list[str]
    page: str

    @property
    def anchor(self) -> str:
        """Where the section of the table stands."""
        return "case-" + re.sub(r"\W+", "-", self.headers[0].strip("[]"))


@functools.cache
def places() -> dict[type[Table], Place]:
    """Every table that a case may have, those near the root first."""
    found: dict[type[Table], Place] = {Case: Place(Case, ["case"], "case")}
    waiting: list[tuple[type[Table], tuple[str, ...]]] = [(Case, ())]
    for model, path in waiting:
        for key, field in keys_of(model).items():
            shape = shape_of(field)
            below, listed = table_of(shape)
            if below is None:
                continue
            whole = (*path, key)
            header = f"[[{'.'.join(whole)}]]" if listed else f"[{'.'.join(whole)}]"
            if below in found:
                found[below].headers.append(header)
                continue
            parts = whole[: 2 if whole[0] in ("machine", "response") else 1]
            found[below] = Place(below, [header], "_".join(parts))
            waiting.append((below, whole))
    return found


def table_of(shape: Shape) -> tuple[type[Table] | None, bool]:
    """The table that stands at a place, and whether it is one of a list."""
    if shape.item is not None and shape.item.table is not None:
        return shape.item.table, True
    return shape.table, False


# ----------------------------------------------------------------------------
# Examples: what starters and shipped cases have at a key, the first that is short enough.
# ----------------------------------------------------------------------------

#: a key that a starter has as a comment, for the table above or an entry of the list below
_COMMENTED = re.compile(r"#  ? ?(?P<key>\w+) = (?P<rest>.*)")
_HEADER = re.compile(r"(?:# )?\[{1,2}([\w.]+)\]{1,2}")


@functools.cache
def examples() -> dict[tuple[type[Table], str], str]:
    """A line of TOML for each key that has a value in a starter or in a shipped case."""
    found: dict[tuple[type[Table], str], str] = {}
    for path in (*STARTERS, *SHIPPED):
        text = path.read_text(encoding="utf-8")
        for model, key, value in _values(tomllib.loads(text), Case):
            line = _line(key, value)
            if len(line) <= _LONGEST:
                found.setdefault((model, key), line)
    for path in STARTERS:
        for model, key, line in _commented(path.read_text(encoding="utf-8")):
            found.setdefault((model, key), line)
    for model in places():
        for key, field in keys_of(model).items():
            shape = shape_of(field)
            if table_of(shape)[0] is None and (model, key) not in found:
                default = None if field.is_required() else field.get_default()
                empty = default in (None, (), {})
                found[model, key] = _line(key, _typical(shape, key) if empty else default)
    return found


def _typical(shape: Shape, key: str) -> Any:
    """A value for a key that neither starters nor cases have: of its kind, within its bounds."""
    if shape.kind == "number":
        return examples_of(shape)[0]
    if shape.kind == "whole":
        return max(2, int(_ends(shape)[0]) + 1) if shape.bounds else 2
    if shape.kind == "list" and shape.item is not None:
        count = max(shape.lengths[0], min(2, shape.lengths[1] or 2))
        return [_typical(shape.item, key)] * count
    if shape.kind == "choice":
        return shape.choices[-1]
    if shape.kind == "labels":
        return {"order": 1}
    return {"flag": True, "value": "10 N"}.get(shape.kind, key)


def _values(data: dict[str, Any], model: type[Table]) -> Iterator[tuple[type[Table], str, Any]]:
    fields = keys_of(model)
    for key, value in data.items():
        if key not in fields:
            continue
        below, listed = table_of(shape_of(fields[key]))
        entries = value if isinstance(value, list) else [value]
        inner = [one for one in entries if isinstance(one, dict)]
        if below is not None and inner:
            for one in inner:
                yield from _values(one, below)
            if listed:
                continue
        yield model, key, value


def _line(key: str, value: Any) -> str:
    """`key = value` in one line."""
    if isinstance(value, dict):
        inside = ", ".join(_line(*pair) for pair in value.items())
        return f"{key} = {{ {inside} }}"
    if isinstance(value, list | tuple):
        inside = ", ".join(_line("", one).removeprefix(" = ") for one in value)
        return f"{key} = [{inside}]"
    return f"{key}{tomli_w.dumps({'x': value}).strip()[1:]}"


def _commented(text: str) -> Iterator[tuple[type[Table], str, str]]:
    """Keys that stand as comments; the table of one is that of the header or list next to it."""
    lines = text.split("\n\n", 1)[1].splitlines()
    models = dict(_models_by_line(lines))
    for number, line in enumerate(lines):
        match = _COMMENTED.match(line)
        if match is None or number not in models:
            continue
        model = models[number]
        if line.startswith("#   "):  # of an entry of the list that comes next
            lists = (re.match(r"(\w+) = ", one) for one in lines[number:])
            name = next(one[1] for one in lists if one)
            below, _ = table_of(shape_of(keys_of(model)[name]))
            model = below or model
        if match["key"] in keys_of(model):
            value = tomllib.loads(f"x = {match['rest']}")["x"]
            yield model, match["key"], _line(match["key"], value)


def _models_by_line(lines: list[str]) -> Iterator[tuple[int, type[Table]]]:
    model: type[Table] | None = Case
    for number, line in enumerate(lines):
        header = _HEADER.match(line)
        if header and not line.startswith("#"):
            model = Case
            for key in header[1].split("."):
                field = None if model is None else keys_of(model).get(key)
                model = None if field is None else table_of(shape_of(field))[0]
        if model is not None:
            yield number, model


def _ends(shape: Shape) -> tuple[float, float]:
    bounds = dict(shape.bounds)
    low = bounds.get("gt", bounds.get("ge", -math.inf))
    return low, bounds.get("lt", bounds.get("le", math.inf))


# ----------------------------------------------------------------------------
# Pages.
# ----------------------------------------------------------------------------


def pages() -> dict[str, str]:
    """Markdown of every page by its name; `index` leads to the others."""
    known, shown = places(), examples()
    texts: dict[str, list[str]] = {}
    for place in known.values():
        if place.model is Case:
            continue
        texts.setdefault(place.page, []).append(_section(place, known, shown))
    made = {page: "\n\n".join(sections) + "\n" for page, sections in texts.items()}
    made["index"] = _index(known, shown, list(texts))
    return made


_HOW = (
    "A number is written in SI (angles in rad) or as a text with a unit; "
    "*needed* says that there is no default."
)


def _index(known: dict[type[Table], Place], shown: dict[Any, str], names: list[str]) -> str:
    about = "All keys that a case may have, with unit, bounds, default and an example of each."
    head = f"# Case file\n\n{about} A case is a TOML file; `vibecalc new` writes commented ones, "
    head += "`vibecalc check` finds every mistake, `vibecalc schema` lets editors complete keys.\n"
    rows = _rows(known[Case], known, shown)
    return f"{head}\n{_HOW}\n\n{table(_HEADS, rows)}\n\n{toctree(sorted(names), hidden=True)}\n"


_HEADS = ("key", "takes", "default", "what it is, and an example")


def _section(place: Place, known: dict[type[Table], Place], shown: dict[Any, str]) -> str:
    first, *others = place.headers
    level = "#" if first.strip("[]").replace(".", "_") == place.page else "##"
    doc = (place.model.__doc__ or "").split("\n\n")[0]
    parts = [f"({place.anchor})=", f"{level} {code(first)}", _sentence(doc)]
    parts += [f"Part of the reference of case files. {_HOW}"] if level == "#" else []
    if others:
        listed = ", ".join(code(one) for one in dict.fromkeys(others) if one != first)
        parts.append(f"The same keys in {listed}." if listed else "")
    if _is_columns(place.model):
        parts.append("A CSV file with these columns may stand for it, by its name.")
    if tuple(first.strip("[]").split(".")) in LISTS:
        parts.append("A CSV file, a line for each, may stand for the list, by its name.")
    parts.append(table(_HEADS, _rows(place, known, shown)))
    together = [f"- {line}" for line in rules_in_words(place.model)]
    parts += ["\n".join(together)] if together else []
    return "\n\n".join(part for part in parts if part)


def _rows(place: Place, known: dict[type[Table], Place], shown: dict[Any, str]) -> list[list[str]]:
    rows = []
    for key, field in keys_of(place.model).items():
        shape = shape_of(field)
        below, listed = table_of(shape)
        if below is not None:
            takes = f"[{'list of tables' if listed else 'table'}](#{known[below].anchor})"
        else:
            takes = takes_in_words(shape)
        default = _default(field.is_required(), field.get_default(call_default_factory=True))
        about = cell(field.description or "")
        example = shown.get((place.model, key), "")
        if example and below is None:
            about += f"<br>{code(example)}"
        rows.append([code(key), takes, default, about])
    return rows


def takes_in_words(shape: Shape) -> str:
    """What may stand at a key: type, unit, bounds, allowed values."""
    if shape.kind == "number":
        unit = f" {code(shape.unit)}" if shape.unit else ""
        three = ", or three in a list" if shape.or_three else ""
        kind = re.sub("^an? ", "", noun(shape)).replace(" without unit", "")
        return f"{kind}{unit}{_bounds(shape)}{three}"
    if shape.kind == "whole":
        return f"whole number{_bounds(shape)}"
    if shape.kind == "list" and shape.item is not None:
        fewest, most = shape.lengths
        count = f"{fewest} or more" if most is None else f"{fewest} to {most}"
        count = str(fewest) if fewest == most else count
        return f"list of {count}: {takes_in_words(shape.item)}"
    if shape.kind == "choice":
        return " or ".join(code(_line("", one).removeprefix(" = ")) for one in shape.choices)
    return words(shape)


def _bounds(shape: Shape) -> str:
    """`, above 0, up to 10`, in the unit that stands before it."""
    signs = {"gt": "above", "ge": "from", "lt": "below", "le": "up to"}
    return "".join(f", {signs[name]} {bound:g}" for name, bound in shape.bounds)


def _default(required: bool, value: Any) -> str:
    if required:
        return "*needed*"
    if value is None or value == () or value == {} or isinstance(value, Table):
        return ""
    return code(_line("", list(value) if isinstance(value, tuple) else value).removeprefix(" = "))


def rules_in_words(model: type[Table]) -> Iterator[str]:
    """Which keys of a table go together, as far as its rules are data."""
    for rule in model.RULES:
        if isinstance(rule, OneOf):
            ways = both([both([*map(code, keys)]) for keys in rule.alternatives], "or")
            yield f"{'Exactly' if rule.needed is True else 'At most'} one of {ways}."
        elif isinstance(rule, Needs) and rule.when is None and rule.key:
            others = both([*map(code, rule.others)], "or")
            yield f"{code(rule.key)} needs {others}{cell(rule.why)}."
        elif isinstance(rule, ByKind):
            for kind, (needed, other) in rule.kinds.items():
                has = f"needs {both([*map(code, needed)])}" if needed else "needs nothing more"
                more = f" and may have {both([*map(code, other)])}" if other else ""
                yield f"With {code(f'{rule.key} = {kind!r}')} it {has}{more}."


def _is_columns(model: type[Table]) -> bool:
    shapes = [shape_of(field) for field in keys_of(model).values()]
    items = [one.item.kind if one.item else "" for one in shapes]
    return bool(items) and all(kind in ("number", "whole") for kind in items)


def _sentence(text: str) -> str:
    text = cell(text).rstrip(".")
    return f"{text[:1].upper()}{text[1:]}." if text else ""
