"""Read a case file: text, TOML, overrides, schema; all problems at once, or a validated case."""

import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.inputs import files_seen, inputs
from vibecalc.core.case.locate import Overridden, at_line, refused, unreadable
from vibecalc.core.case.raw import Setting, apply_overrides, similar
from vibecalc.core.case.row_files import Rows, files_of_rows, with_line
from vibecalc.core.case.rules import cross_check
from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.named import named
from vibecalc.core.results.steps import step
from vibecalc.core.results.text_files import LARGEST, Missing, Unfit, checked, content_of, text_of
from vibecalc.errors import CaseError, KeyPath, Problem
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Rows of reference tables as single references.
# ----------------------------------------------------------------------------


def expand_references(case: Case) -> tuple[Case, dict[KeyPath, KeyPath]]:
    """The case with one reference for each row of its tables, and where those rows stand.

    The second result maps the key path of every reference made here to that of its table.
    """
    if not case.reference_table:
        return case, {}
    from vibecalc.core.case.tables import Printed, Reference

    rows = list(case.reference)
    origins: dict[KeyPath, KeyPath] = {}
    for number, table in enumerate(case.reference_table):
        same = {key: getattr(table, key) for key in Printed.model_fields}
        stated = table.uncertainties or (table.uncertainty,) * len(table.value)
        for entry, value, uncertainty in zip(table.entry, table.value, stated, strict=True):
            origins["reference", len(rows)] = ("reference_table", number)
            where = {**table.where, table.axis: entry}
            of_row = {"where": where, "value": value, "uncertainty": uncertainty}
            rows.append(Reference(**same | of_row))
    return case.model_copy(update={"reference": tuple(rows), "reference_table": ()}), origins


# ----------------------------------------------------------------------------
# Read a case file: text, TOML, overrides, schema; all problems at once, or a validated case.
# ----------------------------------------------------------------------------

EarlyChecks = Callable[[dict[str, Any]], list[Problem]]

#: what follows from an order of firing
_FIRING = "vibecalc.parts.firing"
_AT_LINE = re.compile(r" \(at line (\d+), column (\d+)\)\Z")
_MANY_DOTS = re.compile(r"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){40}""")


@dataclass(frozen=True, kw_only=True)
class LoadedCase:
    """A validated case with all that a result file keeps of it.

    `text` is the file as written; `resolved` the same case as plain dicts and lists in SI with
    every default filled in (values of references and limits stay as written, their unit is that of
    a result), `resolved_toml` that as TOML; `sha256` covers the resolved values and the versions of
    schema and program, not the comments of the file. `origins` maps the references that come from
    a table to the place of that table, `files` the lists that stand in files to their lines.
    `inputs` is the line that tells of a case file whether a result of it is up to date, `freed` the
    resolved case without what follows from other keys, where something does.
    """

    case: Case
    name: str
    path: Path
    text: str
    overrides: tuple[Overridden, ...]
    resolved: dict[str, Any]
    resolved_toml: str
    sha256: str
    origins: dict[KeyPath, KeyPath] = field(default_factory=dict)
    files: dict[KeyPath, Rows] = field(default_factory=dict)
    inputs: str = ""
    freed: dict[str, Any] | None = None

    def base(self, keys: Iterable[str]) -> dict[str, Any]:
        """The resolved case that a study sets these keys of: what follows from them is open."""
        if self.freed is not None and named(f"{_FIRING}:orders_throws")(keys):
            return self.freed
        return self.resolved


#: a file, `-` for standard input, or the tables themselves
CaseSource = str | Path | Mapping[str, Any]


def load_case(
    source: CaseSource,
    overrides: Sequence[Setting] = (),
    early: EarlyChecks | None = None,
    unset: Sequence[str] = (),
) -> LoadedCase:
    """Read one case, with settings that replace or add keys; without those `unset`.

    Where the form is wrong, `early` may add what later floors already find wrong with the case as
    tomllib reads it, so that one message shows all.

    CaseError, with all problems and their places, if there is no valid case in the file;
    UsageError if an override cannot be applied.
    """
    path, text = read_source(source)
    data = parse_source(text, str(path))
    overridden = apply_overrides(data, overrides, unset)
    with files_seen() as seen:
        files = attach_files(data, path.parent)
    lists = files_of_rows(data)
    try:
        case, origins = expand_references(validate(data, files))
    except CaseError as error:
        taken = {problem.path for problem in error.problems}
        later = [found for found in early(data) if found.path not in taken] if early else []
        problems = [with_line(found, lists) for found in (*error.problems, *later)]
        raise refused(problems, text, str(path), overridden) from None
    resolved = resolve(case)
    import tomli_w

    return LoadedCase(
        case=case,
        name=path.stem.strip("<>"),
        path=path,
        text=text,
        overrides=overridden,
        resolved=resolved,
        resolved_toml=tomli_w.dumps(resolved),
        sha256=case_hash(resolved),
        origins=origins,
        files=lists,
        inputs=inputs(path, text, seen, overrides, unset),
        freed=named(f"{_FIRING}:without_phases")(resolved, data),
    )


def validate(data: dict[str, Any], known: Sequence[Problem] = ()) -> Case:
    """Hold a case, as tomllib reads it, against the schema; CaseError with all problems.

    `known` are problems found before, at whose places no others are reported.
    """
    problems: list[Problem] = []
    case: Case | None = None
    try:
        case = Case.model_validate(data)
    except ValidationError as error:
        from vibecalc.core.case.diagnose import explain

        problems = explain(error.errors(include_url=False))
    places = {problem.path for problem in known}
    problems = [*known, *(problem for problem in problems if problem.path not in places)]
    taken = {problem.path for problem in problems}
    problems += [problem for problem in cross_check(data) if problem.path not in taken]
    if problems or case is None:
        raise CaseError(problems)
    return case


def resolve(case: Case) -> dict[str, Any]:
    """Return a case as plain dicts and lists in SI, without what is absent or says nothing."""
    resolved: dict[str, Any] = _plain(case.model_dump(by_alias=True, exclude_none=True))
    return resolved


def raise_with_location(loaded: LoadedCase, problems: Sequence[Problem]) -> None:
    """Raise a CaseError that shows problems of a later floor at their places; none: do nothing."""
    if not problems:
        return
    placed = [
        with_line(problem, loaded.files)._replace(
            path=(*loaded.origins.get(problem.path[:2], problem.path[:2]), *problem.path[2:]),
        )
        for problem in problems
    ]
    once = list({(problem.path, problem.message): problem for problem in placed}.values())
    raise refused(once, loaded.text, str(loaded.path), loaded.overrides)


def read_source(source: CaseSource) -> tuple[Path, str]:
    """Where a case stands, for messages and for the files that it names, and its text."""
    if isinstance(source, Mapping):
        import tomli_w

        try:
            return Path("<case>"), tomli_w.dumps(source)
        except (TypeError, ValueError) as error:
            raise unreadable("<case>", f"<case> holds what TOML cannot: {error}", "") from None
    piped = str(source) == "-"
    path = Path("<stdin>") if piped else Path(source)
    try:
        if piped:
            raw = checked(sys.stdin.buffer.read(LARGEST + 1), LARGEST)
        else:
            raw = content_of(path, LARGEST, streams=True)
        text = text_of(raw)
        step(f"read {path}: {len(raw)} bytes")
        if not text.strip():
            raise Unfit("is empty", "`vibecalc new generator` writes a case to start from")
    except Unfit as error:
        hint = similar(path, "*.toml") if isinstance(error, Missing) else error.hint
        raise unreadable(str(path), f"{path} {error}", hint) from None
    return path, text


def parse_source(text: str, file_name: str) -> dict[str, Any]:
    """The tables of a case as tomllib reads them; CaseError with the place where it cannot."""
    line, column = 1, 1
    dotted = _MANY_DOTS.search(text)
    if dotted is None:
        try:
            return tomllib.loads(text)
        except RecursionError:
            reason = "lists or tables nested beyond reason"
        except ValueError as error:
            reason = str(error).removesuffix(" (at end of document)")
            place = _AT_LINE.search(reason)
            line, column = map(int, place.groups()) if place else (len(text.split("\n")), 1)
            if "integer string conversion" in reason:
                reason, line = "a whole number of thousands of digits", 1
            reason = _AT_LINE.sub("", reason)
            reason = next((said for part, said in _TOML_WORDS.items() if part in reason), reason)
    else:
        reason, line = "a key of more than 40 parts", text.count("\n", 0, dotted.start()) + 1
    unquoted = "cannot be read" in reason or "xpected newline" in reason
    hint = 'a text needs quotes, as in "4900 rpm"' if unquoted else ""
    message = f"not TOML: {reason[0].lower()}{reason[1:]}"
    raise unreadable(file_name, message, hint, at_line(text, line, column))


#: what tomllib says (a part of it) -> what a person understands
_TOML_WORDS = {
    **dict.fromkeys(
        ("Cannot overwrite", "Duplicate inline table key"), "a key that is given twice in its table"
    ),
    **dict.fromkeys(("Cannot declare", "Cannot mutate immutable"), "a table that is given twice"),
    "Invalid value": "a value that cannot be read",
}


#: lists that say something by being empty: no weights for any throw
_MEANT_WHEN_EMPTY = ("balanced_for",)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        plain = {key: _plain(entry) for key, entry in value.items()}
        return {
            key: entry
            for key, entry in plain.items()
            if entry not in ({}, []) or key in _MEANT_WHEN_EMPTY
        }
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value
