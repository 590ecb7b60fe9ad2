"""A quantity: what is known of it before it is computed, and the array with its error after it."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from vibecalc.core.results.named import named

if TYPE_CHECKING:
    from pandas import DataFrame, Series
    from xarray import DataArray, DataTree

# ----------------------------------------------------------------------------
# What is known of a quantity before it is computed.
# ----------------------------------------------------------------------------

#: what turns quantities into arrays and tables of other libraries
_LABELLED = "vibecalc.core.results.labelled"

PEAK = "0-pk"
RMS = "rms"
#: results of a case as written, where a search has changed it
AT_START = "optimisation/start/"
#: objectives of a front, in their order
FRONT_NAMES = ("objective", *map("{}_objective".format, ("second", "third", "fourth", "fifth")))


class Headline(NamedTuple):
    """How a result stands in the first table of a report: its name, in the unit that people read.

    Of an array `pick` says which entries: that of `largest` magnitude, the `least`, `each` one,
    the `first` one, the first and the last of many (`ends`), or the lowest three above zero
    (`elastic`), or those of values that are not all zero (`present`). Where there is a result at
    `by`, of the same entries, the entry is that where this is largest. `at` is the path of the
    speeds, or ratios of frequencies, at which the entries are met. Where there is a quantity at
    `unless`, that says it better. `words` names a function (record, place among the entries, path),
    as `package.module:function`, whose words stand for the entry; None for it itself. `reference`
    names one (case) that says what a level refers to, where that is a key of the case.
    """

    name: str
    unit: str = ""
    pick: str = "largest"
    at: str = ""
    unless: str = ""
    words: str = ""
    by: str = ""
    reference: str = ""


#: what an SI unit is read in, if not in itself
READ = {"m": "mm", "rad": "deg", "rad/s": "Hz", "m^2/s": "cSt", "W": "kW", "Pa": "MPa",
        "N/m": "N/mm"}  # fmt: skip

#: what an angle may be off by and mean the same: a turn, or a whole cycle of the machine
TURN = "turn"
CYCLE = "cycle"

#: why a result is not held to `[accuracy] rtol`
CANCELLING = "sums that show cancellation"
CHECK = "checks (zero for the exact solution)"
DIFFERENCE = "differences of nearly equal results"
EXAMINED = "maxima of a sample"
MARCHED = "values read off a time integration, limited by its steps"
PLACE = "locations of flat peaks"
SEARCHED = "search results at flat minima"
SPECTRUM = "levels and phases (their harmonics are judged instead)"
STATISTIC = "statistics (their standard error is far larger)"
UNCERTAINTY = "uncertainties (two digits are enough)"

#: what lets more results meet `[accuracy] rtol`
ORDERS = "if the series is truncated, add orders ([excitation] orders)"
RESONANCE = "near an undamped resonance add damping"
CANCELS = "limited by cancellation"
MARCH = "a time integration meets the tolerance per step, not over all steps"


class Entry(NamedTuple):
    """All that is known of one quantity before it is computed.

    Path, axes, unit, long name, kind of amplitude; how it stands in the first table of a report,
    if it does; why it is not held to the tolerance, if it is not; of which result it is a part, by
    which its error then is measured; its name in tables, where the words of its path are none;
    the picture that shows it over its last axis, with all results of the same `curve`. A
    `diagnostic` hangs on rounding and on the path of a search, so that `diff` does not compare it;
    an angle that means the same after a `circle` is compared modulo that. A `share` is read in
    percent, a `flag`, 1 or 0, as yes or no.
    """

    path: str
    axes: tuple[str, ...]
    unit: str
    long_name: str
    amplitude: str | None = None
    headline: Headline | None = None
    exempt: str = ""
    part_of: str = ""
    name: str = ""
    curve: str = ""
    diagnostic: bool = False
    circle: str = ""
    share: bool = False
    flag: bool = False

    def quantity(
        self, values: Any, error: float = 0.0, axes: "Mapping[str, Any] | tuple[Axis, ...]" = (),
        **more: Any,
    ) -> "Quantity":  # fmt: skip
        """A result of this entry; `axes` are its own, or the entries of axes by name."""
        if not isinstance(axes, tuple):
            axes = tuple(Axis(name=name, values=axes[name]) for name in self.axes)
        return Quantity(
            path=self.path,
            values=np.asarray(values),
            unit=self.unit,
            long_name=self.long_name,
            axes=axes,
            amplitude=self.amplitude,
            error_estimate=error,
            **more,
        )


def entry(
    path: str,
    axes: str,
    unit: str,
    long_name: str,
    amplitude: str | None = None,
    **more: Any,
) -> Entry:
    """An entry whose axes are written as one text with blanks between."""
    return Entry(path, tuple(axes.split()), unit, long_name, amplitude, **more)


def under(root: str, *entries: Entry) -> tuple[Entry, ...]:
    """Entries whose paths are written below a root, with their whole paths."""
    return tuple(one._replace(path=f"{root}/{one.path}") for one in entries)


def exempt(reason: str, entries: Iterable[Entry]) -> Iterator[Entry]:
    """Entries that share the `reason` for which they are not held to the tolerance."""
    return (one._replace(exempt=one.exempt or reason) for one in entries)


# ----------------------------------------------------------------------------
# What a run holds in memory: named arrays with unit, axes, amplitude kind and error estimate.
# ----------------------------------------------------------------------------

AMPLITUDES = ("0-pk", "pk-pk", "rms")

#: an error of no more than this share of the terms that a value is summed from is rounding
ROUNDING = 1e-10


class Estimate(float):
    """An absolute error that knows the size of the terms behind the value; a factor scales both.

    `whole` says that nothing but the terms tells whether a value of exactly 0 is a zero: all
    entries of its quantity are 0. Else such an entry has no terms. `own` says that the error is
    that of a single value, and not the largest of many.
    """

    terms: float
    whole: bool
    own: bool

    def __new__(
        cls, error: float, terms: float, whole: bool = False, own: bool = False
    ) -> "Estimate":
        """`error` and `terms` in one unit."""
        made = super().__new__(cls, error)
        made.terms, made.whole, made.own = terms, whole, own
        return made

    def __getnewargs__(self) -> tuple[float, float, bool, bool]:  # type: ignore[override]
        return float(self), self.terms, self.whole, self.own

    def __mul__(self, factor: Any) -> Any:
        """The same in another unit; a plain product with what is not a plain number."""
        if not isinstance(factor, int | float):
            return float(self) * factor
        terms = self.terms * abs(factor)
        return Estimate(float(self) * factor, terms, self.whole, self.own)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Any) -> Any:
        """The same in another unit."""
        return self * (1.0 / divisor)

    def is_zero(self, value: float) -> bool:
        """Whether a value is zero to rounding of its own terms, so that it is written as 0."""
        if value == 0.0 and not self.whole:
            return True
        return abs(value) <= self <= ROUNDING * self.terms

    def unresolved(self, value: float) -> bool:
        """Whether a value is no larger than its error and yet not known to be zero."""
        known = math.isfinite(value) and math.isfinite(self)
        return known and abs(value) <= self and not self.is_zero(value)


def _alike(one: Any, other: Any) -> bool:
    """Whether two objects of a class have the same in all their fields, arrays as a whole."""
    pairs = ((getattr(one, each.name), getattr(other, each.name)) for each in fields(one))
    return all(
        a is b or (_same_arrays(a, b) if isinstance(a, np.ndarray) else bool(a == b))
        for a, b in pairs
    )


def _same_arrays(one: np.ndarray, other: np.ndarray) -> bool:
    numbers = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return np.array_equal(one, other, equal_nan=numbers)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Axis:
    """One labelled axis: numbers with a unit, or names (`unit` is then empty).

    In a golden file it may hold a part of the samples that the run had; `run_samples` is how many
    these were, zero where all are there.
    """

    name: str
    values: np.ndarray
    unit: str = ""
    long_name: str = ""
    run_samples: int = 0

    def __eq__(self, other: object) -> bool:
        return _alike(self, other) if isinstance(other, Axis) else NotImplemented

    def __repr__(self) -> str:
        return f"<vibecalc axis {self.name!r}: {_brief(self.values, self.unit)}>"


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Quantity(np.lib.mixins.NDArrayOperatorsMixin):
    """One result. `path` is its name everywhere: in the file, in references, limits and `diff`.

    `values` has one dimension per axis, real or complex; `error_estimate` is absolute, in `unit`,
    and bounds the error of every entry that the method expects of itself (round-off and
    truncation, for the case as stored in double precision). `errors`, of the shape of `values`, are
    those of single entries where they are known and differ: `error_estimate` is the largest. A
    statistic carries its `standard_error`, in `unit` too. `terms` is the size of the terms, in
    `unit`, that an entry is the sum of, where these may cancel: what is left then has no scale of
    its own; zero elsewhere.
    """

    path: str
    values: np.ndarray
    unit: str
    long_name: str
    axes: tuple[Axis, ...] = ()
    amplitude: str | None = None
    error_estimate: float = 0.0
    standard_error: float | None = None
    terms: float = 0.0
    errors: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Let the error know the size of the terms, which tells a zero from an unknown."""
        if self.errors is not None and self.errors.shape != self.values.shape:
            object.__setattr__(self, "errors", None)  # of other entries than these
        size = np.abs(self.values) if self.values.dtype.kind in "biufc" else np.zeros(1)
        largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
        whole = self.terms > 0.0 and largest == 0.0
        error = Estimate(
            self.error_estimate, max(largest, self.terms), whole, self.values.size == 1
        )
        object.__setattr__(self, "error_estimate", error)

    def __eq__(self, other: object) -> bool:
        return _alike(self, other) if isinstance(other, Quantity) else NotImplemented

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __repr__(self) -> str:
        over = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in self.axes)
        return (
            f"<vibecalc quantity {self.path!r}: {_brief(self.values, self.unit)}"
            f"{' over ' * bool(over)}{over}>"
        )

    # A quantity is an array of its values, in SI.

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        """The values, as numpy asks for them; they are copied where `copy` or the type asks so."""
        found = np.asarray(self.values, dtype=dtype)
        if copy is False and dtype is not None and found.dtype != self.values.dtype:
            raise ValueError(f"{self.path} cannot be of type {found.dtype} without a copy")
        return np.array(found) if copy else found

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Arithmetic of the values: what comes out is an array without a unit."""
        plain = [np.asarray(one) if isinstance(one, Quantity) else one for one in inputs]
        return getattr(function, method)(*plain, **options)

    def __len__(self) -> int:
        """Entries along the first axis; TypeError of a single number."""
        if not np.ndim(self.values):
            raise TypeError(f"{self.path} is one number and has no length")
        return len(self.values)

    def __getitem__(self, place: Any) -> Any:
        """Entries as numpy picks them, in SI."""
        return np.asarray(self.values)[place]

    def __iter__(self) -> Iterator[Any]:
        """Entries along the first axis; TypeError of a single number."""
        return iter(np.asarray(self.values))

    def __bool__(self) -> bool:
        """A quantity is there, whatever its numbers are."""
        return True

    def __float__(self) -> float:
        """The one number that it is, in SI; TypeError for what is not one real number."""
        return float(self._one("iufb", "real number"))

    def __complex__(self) -> complex:
        """The same of what may be complex."""
        return complex(self._one("iufbc", "number"))

    def _one(self, kinds: str, what: str) -> Any:
        values = np.asarray(self.values)
        if values.size != 1 or values.dtype.kind not in kinds:
            over = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in self.axes)
            has = f"{values.size} entries over {over}" if over else f"{values.dtype} values"
            raise TypeError(f"{self.path} is not one {what}: it has {has}")
        return values.item()

    def _repr_html_(self) -> str:
        """Name, unit, axes and values in a notebook, in the unit that people read."""
        return str(named("vibecalc.core.report.notebook:quantity_html")(self))

    def to(self, unit: str) -> np.ndarray:
        """The values in another unit; UnitError if it has another dimension."""
        from vibecalc.units import convert

        return np.asarray(self.values * convert(1.0, self.unit, unit))

    def to_xarray(self) -> "DataArray":
        """The values with coordinates; unit, amplitude and error stand in `attrs`."""
        return cast("DataArray", named(f"{_LABELLED}:data_array")(self))

    def to_pandas(self) -> "Series[Any]":
        """The values as a column, its index the axes; of one number, a column of one."""
        return cast("Series[Any]", named(f"{_LABELLED}:series")(self))

    @property
    def attributes(self) -> dict[str, Any]:
        """What stands next to the values in a file, by its names there."""
        known = {
            "units": self.unit,
            "long_name": self.long_name,
            "amplitude": self.amplitude,
            "error_estimate": float(self.error_estimate),
            "errors": self.errors,
            "standard_error": self.standard_error,
            "terms": self.terms or None,
        }
        return {name: one for name, one in known.items() if one is not None}

    @property
    def estimate(self) -> Estimate:
        """`error_estimate` as what it is."""
        return cast(Estimate, self.error_estimate)

    @property
    def zero(self) -> np.ndarray:
        """Which entries are zero to rounding of their own terms, as `Estimate.is_zero` has it."""
        return self.zeros(self.values, self.error_estimate)

    def zeros(self, values: np.ndarray, errors: np.ndarray | float) -> np.ndarray:
        """The same of some of its values with these errors."""
        size, terms = np.abs(values), self.estimate.terms
        nothing = (size <= errors) & (np.asarray(errors) <= ROUNDING * terms)
        return np.asarray(nothing | ((size == 0.0) & (not self.estimate.whole)))


def _brief(values: np.ndarray, unit: str) -> str:
    """Values with four digits, of many the first and last, and their unit."""
    with np.printoptions(precision=4, threshold=8, edgeitems=2):
        return f"{' '.join(str(values).split())} {unit}".strip()


#: what became of a limit
KEPT, BARRED, BROKEN, UNDECIDED = "kept", "barred", "broken", "undecided"
WORST_FIRST = (BROKEN, UNDECIDED, BARRED, KEPT)


class Verdict(NamedTuple):
    """A limit and the worst entry it is held against; all numbers but `speed` in `unit`.

    `state` is KEPT where the whole interval of the value and its error lies inside, BROKEN where it
    lies outside, else UNDECIDED, and `decided_by` says what would decide it; BARRED is broken only
    in ranges of speeds that a rule lets be barred. `quantity` is the path of the deciding result,
    `where` what was picked of it, `label` the worst entry. A limit that is no `[[limit]]` has an
    `element` that bears something and the words of the `limit` on it; `status` says whose it is.
    `utilisation` is the share of the bound, NaN where there is none; `speed` is in rad/s, NaN
    without one.
    """

    quantity: str
    where: Mapping[str, int | float | str]
    source: str
    min: float | None
    max: float | None
    unit: str
    computed: float
    label: str
    error_estimate: float
    margin: float
    state: str
    decided_by: str = ""
    expect: str = KEPT
    at: str = "optimum"
    element: str = ""
    limit: str = ""
    condition: str = ""
    status: str = "case"
    utilisation: float = math.nan
    speed: float = math.nan

    @property
    def kept(self) -> bool | None:
        """None where that is undecided."""
        return None if self.state == UNDECIDED else self.state == KEPT

    @property
    def satisfied(self) -> bool:
        """Whether the limit does what the case expects of it; a barred one may be kept to."""
        return (KEPT if self.state == BARRED else self.state) == self.expect

    @property
    def borne(self) -> str:
        """What bears the limit and in which condition, empty for a `[[limit]]`."""
        return ", ".join(filter(None, (self.element, self.limit, self.condition)))


class Method(NamedTuple):
    """A method that took part in a run: what it did and where it is published."""

    name: str
    purpose: str
    citation: str


@dataclass(kw_only=True)
class Record(Mapping[str, Quantity]):
    """All results of one run, in the order they were made, with warnings and methods used.

    `failure` says, in a sentence, that what was asked for does not exist: the results then are of
    what comes nearest to it, and one of the warnings says by how much. It is not kept in a file.
    """

    quantities: dict[str, Quantity] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    methods: list[Method] = field(default_factory=list)
    failure: str = ""

    def add(self, quantity: Quantity) -> None:
        """Take one result; a second one under the same path is a mistake of ours."""
        if quantity.path in self.quantities:
            raise ValueError(f"two results under one path: {quantity.path}")
        self.quantities[quantity.path] = quantity

    def __getitem__(self, path: str) -> Quantity:
        return self.quantities[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)


@dataclass(frozen=True, kw_only=True)
class Result(Mapping[str, Quantity]):
    """A finished run, as it is written to a file and read back: its quantities by their paths.

    `case` is the resolved case (plain dict in SI, as in the TOML of `case_toml_resolved`);
    `plan` has one dict of short texts per stage (`stage`, `why`, ...). What changes from run to
    run is in `provenance` (texts and numbers) and `timings` (seconds per stage). `swept` is the
    file of the sweep that it was read from, which has more: what became of each point. `verdicts`
    are the limits as they were judged after the run, None in what was made before they were stored.
    """

    name: str
    case: Mapping[str, object]
    case_toml: str
    case_toml_resolved: str
    case_sha256: str
    record: Record
    version: str
    plan: tuple[Mapping[str, str], ...] = ()
    provenance: Mapping[str, str | int | float] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    swept: Path | None = field(default=None, compare=False)
    verdicts: tuple[Verdict, ...] | None = field(default=None, compare=False)

    def __getitem__(self, path: str) -> Quantity:
        if path not in self.record:
            raise named("vibecalc.core.results.plain:missing")(self, path)
        return self.record[path]

    def __contains__(self, path: object) -> bool:
        return path in self.record

    def __iter__(self) -> Iterator[str]:
        return iter(self.record)

    def __len__(self) -> int:
        return len(self.record)

    def __repr__(self) -> str:
        return f"<vibecalc result {self.name!r}: {len(self)} quantities>"

    def to_xarray(self) -> "DataTree":
        """All quantities as a tree of their paths, with coordinates."""
        return cast("DataTree", named(f"{_LABELLED}:data_tree")(self))

    def to_pandas(self) -> "DataFrame":
        """A row for each quantity: unit, axes, value of one number, largest magnitude, error."""
        return cast("DataFrame", named(f"{_LABELLED}:data_frame")(self))
