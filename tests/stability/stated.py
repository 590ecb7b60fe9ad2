"""What `stated.toml` says of each hard case: its condition, and the digits that each way loses."""

import tomllib
from pathlib import Path
from typing import NamedTuple

from stability.hard_case import Lost


class Stated(NamedTuple):
    """Condition; digits that vibecalc loses at most; digits of the other ways, to a half."""

    condition: float
    own: Lost
    others: dict[str, Lost]


_TEXT = (Path(__file__).parent / "stated.toml").read_text(encoding="utf-8")
STATED = {name: Stated(**row) for name, row in tomllib.loads(_TEXT).items()}
