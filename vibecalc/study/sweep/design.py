"""Which points a sweep has, each from its number alone: nothing is stored for them.

A grid has the points of its axes in C order, the last axis varies fastest. A sampling has its
points in the order of its sequence. With Sobol indices a sampling of two halves, A and B, gives
k + 2 runs in a row for each of its points: A, B, and A with axis j taken from B for j = 1 to k
(Saltelli et al. 2010, Computer Physics Communications 181).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.case.sweep_tables import Sweep
from vibecalc.errors import CaseError, Problem
from vibecalc.study.sweep.axes import SweepAxis, read_axes
from vibecalc.study.sweep.sequences import SEQUENCES

LARGEST = 1_000_000_000
STANDARD_POINTS = 1024
STANDARD_SEED = 1


@dataclass(frozen=True, kw_only=True)
class Design:
    """The points of a sweep; `points` are those of a sampling before k + 2 runs come of each."""

    axes: tuple[SweepAxis, ...]
    sampling: str = "grid"
    points: int = 0
    seed: int = STANDARD_SEED
    indices: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis of the results: of the grid, or the number of runs."""
        if self.sampling == "grid":
            return tuple(axis.count or 0 for axis in self.axes)
        return (self.points * (len(self.axes) + 2) if self.indices else self.points,)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Name of each axis of the results."""
        grid = self.sampling == "grid"
        return tuple(axis.name for axis in self.axes) if grid else ("sample",)

    @property
    def count(self) -> int:
        """Number of runs."""
        return math.prod(self.shape)

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that vary, axis by axis."""
        return tuple(key for axis in self.axes for key in axis.keys)

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each key."""
        return tuple(unit for axis in self.axes for unit in axis.units)

    @property
    def choices(self) -> tuple[tuple[str, ...], ...]:
        """For each key the names that its values count from 0; empty for a number."""
        return tuple(names for axis in self.axes for names in axis.choices)

    def value_of(self, numbers: np.ndarray) -> np.ndarray:
        """Values (len, keys) in SI at point numbers (len,); a choice is counted from 0.

        IndexError for a number that the design does not have.
        """
        numbers = np.asarray(numbers, dtype=np.int64)
        if numbers.size and not 0 <= numbers.min() <= numbers.max() < self.count:
            raise IndexError(f"the sweep has the points 0 to {self.count - 1}")
        if self.sampling == "grid":
            places = np.unravel_index(numbers, self.shape)
            parts = [axis.at(place) for axis, place in zip(self.axes, places, strict=True)]
        else:
            shares = self._shares(numbers)
            parts = [axis.drawn(shares[:, column]) for column, axis in enumerate(self.axes)]
        return np.concatenate(parts, axis=1)

    def columns(self, numbers: np.ndarray) -> dict[str, np.ndarray]:
        """The values at some points by key: doubles, whole numbers, or names of choices."""
        values = self.value_of(numbers)
        return {key: self._typed(values[:, column], column) for column, key in enumerate(self.keys)}

    def settings(self, number: int) -> dict[str, float | int | str]:
        """What one point sets: a value in SI or the name of a choice for each key."""
        return {key: column[0].item() for key, column in self.columns(np.array([number])).items()}

    def roles(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For Sobol indices: the sampled point behind each run, and 0 for A, 1 for B, 1 + j."""
        if not self.indices:
            raise ValueError("only a sweep for Sobol indices has roles")
        return np.divmod(np.asarray(numbers, dtype=np.int64), len(self.axes) + 2)

    def description(self) -> dict[str, Any]:
        """The design as plain values, for hashes and result files."""
        sampled = self.sampling != "grid"
        return {
            "sampling": self.sampling,
            **({"points": self.points, "seed": self.seed} if sampled else {}),
            "indices": self.indices,
            "axes": [
                [
                    {"key": key, **course.description()}
                    for key, course in zip(axis.keys, axis.courses, strict=True)
                ]
                for axis in self.axes
            ],
        }

    def _typed(self, column: np.ndarray, index: int) -> np.ndarray:
        if self.choices[index]:
            return np.array(self.choices[index])[column.astype(np.int64)]
        whole = [shape.kind == "whole" for axis in self.axes for shape in axis.shapes]
        return column.astype(np.int64) if whole[index] else column

    def _shares(self, numbers: np.ndarray) -> np.ndarray:
        sequence, size = SEQUENCES[self.sampling], len(self.axes)
        if not self.indices:
            return sequence(numbers, size, self.points, self.seed)
        base, role = self.roles(numbers)
        both = sequence(base, 2 * size, self.points, self.seed)
        from_b = (role[:, None] == 1) | (role[:, None] == np.arange(size) + 2)
        return np.where(from_b, both[:, size:], both[:, :size])


def make_design(sweep: Sweep, resolved: Mapping[str, Any]) -> Design:
    """Read `[sweep]` for a case in SI with its defaults; CaseError with all problems found."""
    axes, problems = read_axes(sweep, resolved)
    problems += _sampling_problems(sweep)
    if not sweep.axes:
        problems.append(
            Problem(
                path=("sweep",),
                message="a sweep needs at least one axis",
                allowed='axes = [{ key = "machine.speed", from = ..., to = ..., points = 21 }]',
            )
        )
    if not problems:
        design = Design(
            axes=axes,
            sampling=sweep.sampling,
            points=STANDARD_POINTS if sweep.points is None else sweep.points,
            seed=STANDARD_SEED if sweep.seed is None else sweep.seed,
            indices=sweep.indices,
        )
        problems += _size_problems(design)
    if problems:
        raise CaseError(problems)
    return design


def size_words(count: int) -> str:
    """Say a large number: 1500 is "1500", 1 200 000 "1.2 million"."""
    for size, name in (
        (10**18, "million million million"),
        (10**12, "million million"),
        (10**9, "thousand million"),
        (10**6, "million"),
    ):
        if count >= size:
            shown = f"{count / size:.4g}" if count < 10**6 * size else f"{count / size:.3e}"
            return f"{shown} {name}"
    return str(count)


def _sampling_problems(sweep: Sweep) -> list[Problem]:
    problems = []
    if sweep.sampling == "grid":
        problems = [
            Problem(
                path=("sweep", key),
                message=f"{key} belongs to a sampling, and this sweep is a grid",
                allowed='sampling = "sobol", "latin_hypercube" or "monte_carlo"',
            )
            for key in ("points", "seed")
            if getattr(sweep, key) is not None
        ]
    elif sweep.points is not None and sweep.points < 2:
        message = "a sampling needs two points or more"
        problems.append(Problem(path=("sweep", "points"), message=message, found=str(sweep.points)))
    if sweep.indices and sweep.sampling not in ("sobol", "monte_carlo"):
        problems.append(
            Problem(
                path=("sweep", "indices"),
                message="Sobol indices come from samples that do not depend on each other's axes",
                found=f"sampling = {sweep.sampling}",
                allowed='sampling = "sobol" or "monte_carlo"',
            )
        )
    return problems


def _size_problems(design: Design) -> list[Problem]:
    if design.count <= LARGEST:
        return []
    if design.sampling == "grid":
        path, factors = ("sweep", "axes"), " x ".join(str(size) for size in design.shape)
    else:
        path = ("sweep", "points")
        runs = f" x {len(design.axes) + 2} runs" if design.indices else ""
        factors = f"{design.points}{runs}"
    years = design.count / 1000.0 / 31_557_600.0
    return [
        Problem(
            path=path,
            message=f"the sweep would have {size_words(design.count)} points",
            found=factors,
            allowed=f"at most {size_words(LARGEST)}",
            hint=f"a thousand points a second would take {years:.2g} years"
            if years > 0.1
            else "fewer points on an axis, or a sampling",
        )
    ]
