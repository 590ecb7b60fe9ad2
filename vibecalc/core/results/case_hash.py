"""Hashes of cases: they tell cases apart, and show whether that of a result is as it was run."""

import hashlib
import json
from typing import Any

from vibecalc import __version__

#: attribute of a result file: the hash of the case as written
WRITTEN = "case_toml_sha256"


def text_hash(text: str | bytes) -> str:
    """Hash (hexadecimal SHA-256) of a text, or of bytes."""
    return hashlib.sha256(text if isinstance(text, bytes) else text.encode()).hexdigest()


def case_hash(resolved: dict[str, Any], version: str = __version__) -> str:
    """Hash (hexadecimal SHA-256) of resolved values, schema version and program version."""
    content = {"case": resolved, "schema": resolved.get("schema"), "vibecalc": version}
    return text_hash(json.dumps(content, sort_keys=True, separators=(",", ":")))
