"""Numbers of a case that may differ from point to point, as arrays over the points."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.errors import KeyPath
from vibecalc.numerics.typing import FloatArray

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


class Columns:
    """A case with some of its numbers set to arrays.

    `varied` maps key paths to values (points,). What varies is read as (points,), all else as (1,),
    so that what does not vary is computed once and broadcast.
    """

    def __init__(self, case: "Case", varied: Mapping[KeyPath, np.ndarray], count: int):
        self.case, self.count = case, count
        self.varied = {path: np.asarray(values, dtype=float) for path, values in varied.items()}

    def rows(self, chosen: np.ndarray) -> "Columns":
        """The same case at some of the points only."""
        varied = {path: values[chosen] for path, values in self.varied.items()}
        return Columns(self.case, varied, len(chosen))

    def varies(self, *path: str | int) -> bool:
        """Whether anything at a place, or below it, varies."""
        return any(key[: len(path)] == path for key in self.varied)

    def written(self, *path: str | int) -> Any:
        """What the case has at a place; None where it, or a table above it, is absent."""
        found: Any = self.case
        for part in path:
            if found is None:
                return None
            found = found[part] if isinstance(part, int) else getattr(found, part)
        return found

    def optional(self, *path: str | int) -> FloatArray | None:
        """A number (points,) or (1,), or None where the case has none."""
        if path in self.varied:
            return self.varied[path]
        found = self.written(*path)
        return None if found is None else np.array([found], dtype=float)

    def number(self, *path: str | int) -> FloatArray:
        """A number (points,) or (1,); zero where the case has none."""
        found = self.optional(*path)
        return np.zeros(1) if found is None else found

    def vector(self, *path: str | int) -> FloatArray:
        """A list of numbers (points or 1, entries)."""
        return together([self.number(*path, place) for place in range(len(self.written(*path)))])


def together(parts: Sequence[FloatArray]) -> FloatArray:
    """Arrays (points or 1,) as columns of one array (points or 1, entries)."""
    if not parts:
        return np.zeros((1, 0))
    return np.stack(np.broadcast_arrays(*parts), axis=-1)
