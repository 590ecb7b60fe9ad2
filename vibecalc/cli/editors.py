"""The JSON schema as a file next to cases, and the line of a case that tells editors of it."""

import json
import tomllib
from pathlib import Path

from vibecalc.cli.outputs import write_text
from vibecalc.errors import UsageError

DIRECTIVE = "#:schema ./"
#: how a starter says where the schema comes from
_OF_ALL = "`vibecalc schema -o vibecalc.schema.json`"


def schema_text(kind: str) -> str:
    """The schema of one kind of machine, or of all of them."""
    from vibecalc.json_schema import json_schema

    return json.dumps(json_schema(kind), indent=2, ensure_ascii=False) + "\n"


def schema_name(kind: str) -> str:
    """The file that a folder of cases has it in."""
    return f"vibecalc.{kind}.schema.json" if kind else "vibecalc.schema.json"


def write_schema(folder: Path, kind: str) -> Path:
    """Write the schema into a folder, in the place of an earlier one."""
    path, text = folder / schema_name(kind), schema_text(kind)
    if path.exists() and '"$id": "urn:vibecalc:case:' not in path.read_text("utf-8", "replace"):
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
