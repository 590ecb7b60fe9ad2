"""Hashes that name a sweep and its points: the same input, the same hash, on every machine."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc import __version__
from vibecalc.case.schema import SCHEMA_VERSION
from vibecalc.study.sweep.design import Design
from vibecalc.study.sweep.place import NOT_COMPUTED, case_at

_BLOCK = 1 << 14


@dataclass(frozen=True, kw_only=True)
class Identity:
    """Hashes (hexadecimal SHA-256) of a sweep.

    `base` covers what all its points share: the case but for the keys that vary and the tables
    that no point reads, and the versions of schema and program. `sweep` covers the whole case,
    the design and what is kept.
    """

    base: str
    sweep: str

    def point(self, design: Design, number: int) -> str:
        """Hash of the input of one point; equal in any sweep that comes to the same input."""
        return _sha256({"base": self.base, "settings": design.settings(number)})

    def points(self, design: Design, numbers: Iterable[int]) -> list[str]:
        """Hashes of the inputs of several points."""
        wanted = np.fromiter(numbers, dtype=np.int64)
        hashes = []
        for start in range(0, wanted.size, _BLOCK):
            columns = design.columns(wanted[start : start + _BLOCK])
            rows = zip(*(column.tolist() for column in columns.values()), strict=True)
            hashes += [
                _sha256({"base": self.base, "settings": dict(zip(columns, row, strict=True))})
                for row in rows
            ]
        return hashes


def identify(resolved: Mapping[str, Any], design: Design, keep: Sequence[str]) -> Identity:
    """Hashes of a sweep over a case in SI with its defaults; the order of `keep` is no matter."""
    versions = {"schema": SCHEMA_VERSION, "vibecalc": __version__}
    # a key that varies counts with its values only, whatever the case says
    without = (*NOT_COMPUTED, "title", "source")
    fixed = case_at(resolved, dict.fromkeys(design.keys), without)
    whole = {name: table for name, table in resolved.items() if name != "sweep"}
    base = _sha256({"case": fixed, **versions})
    content = {"case": whole, "design": design.description(), "keep": sorted(set(keep))}
    return Identity(base=base, sweep=_sha256({**content, **versions}))


def _sha256(content: Any) -> str:
    """Hash of plain values as JSON with sorted keys; a double is its shortest decimal form."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
