"""The JSON schema as a file next to cases, and the line of a case that tells editors of it."""

import json
import tomllib
from pathlib import Path

from vibecalc.cli.outputs import write_text
from vibecalc.core.results.text_files import text_file
from vibecalc.errors import UsageError

DIRECTIVE = "#:schema ./"
#: bytes of what a schema may replace
_LARGEST = 20_000_000
#: how a starter says where the schema comes from
_OF_ALL = "`vibecalc schema -o vibecalc.schema.json`"


def schema_text(kind: str) -> str:
    """The schema of one kind of machine, or of all of them; a line for each table and form."""
    from vibecalc.json_schema import json_schema

    def text(part: object) -> str:
        return json.dumps(part, ensure_ascii=False, separators=(",", ":"))

    schema = json_schema(kind)
    tables = ",\n".join(f"{text(name)}:{text(one)}" for name, one in schema.pop("$defs").items())
    return f'{text(schema)[:-1]},\n"$defs":{{\n{tables}\n}}}}\n'


def schema_name(kind: str) -> str:
    """The file that a folder of cases has it in."""
    return f"vibecalc.{kind}.schema.json" if kind else "vibecalc.schema.json"


def write_schema(folder: Path, kind: str) -> Path:
    """Write the schema into a folder, in the place of an earlier one."""
    path, text = folder / schema_name(kind), schema_text(kind)
    mark = "urn:vibecalc:case:"
    if path.exists() and mark not in text_file(path, _LARGEST, "the file for the schema"):
        raise UsageError(f"{path} exists already and is no schema of vibecalc; remove it")
    write_text(text, path)
    return path


def kind_in(text: str) -> str:
    """The kind of machine of a case."""
    kind: str = tomllib.loads(text)["machine"]["kind"]
    return kind


def with_directive(text: str, kind: str) -> str:
    """A case whose first line names the schema of its kind."""
    first, rest = text.split("\n", 1)
    below = rest if first.startswith(DIRECTIVE) else text
    below = below.replace(
        _OF_ALL, _OF_ALL.replace("-o vibecalc.schema.json", f"--kind {kind} -o ./")
    )
    return f"{DIRECTIVE}{schema_name(kind)}\n{below}"
