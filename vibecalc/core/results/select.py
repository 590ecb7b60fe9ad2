"""Picks entries of a quantity along its named axes, as `where` in references and limits does."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from vibecalc.core.results.record import Axis, Quantity
from vibecalc.errors import ResultError, UnitError
from vibecalc.numerics.rounding import first_of_largest

Key = int | float | str
Where = Mapping[str, Key]
Side = Literal["max", "min"]

#: two labels closer than this, relative to the larger one, are the same label
LABEL_RTOL = 1e-9
#: axes along which a curve is sampled: between two samples lies a straight line
SAMPLED = ("speed", "variable_speed")

#: of a statistic that still tell nothing apart
STANDARD_ERRORS = 4.0

_SHOWN = 12


class Selection(NamedTuple):
    """What `where` leaves of a quantity.

    `values` has one dimension for each axis that `where` does not name, in the quantity's order;
    `axes` are all of them, those that it names with the one entry, and `errors` what each of the
    values may be off by. `curving` is what they may
    be off on top where they lie between two samples of a curve, in the unit of the quantity: how
    far a polynomial through one more sample on each side leaves the straight line, and all of a
    value that stands next to one without bound; 0 at a sample.
    """

    values: np.ndarray
    axes: tuple[Axis, ...]
    errors: np.ndarray
    curving: float

    @property
    def labels(self) -> tuple[str, ...]:
        """One text per entry of `values`, in C order, naming all axes: "mount=2, order=1"."""
        return tuple(map(label_of(self.axes), range(self.values.size)))

    def label(self, place: int) -> str:
        """That of one entry, by its place in C order."""
        return label_of(self.axes)(place)


def select(quantity: Quantity, where: Where) -> Selection:
    """Pick the entries of `quantity` that `where` names.

    Parameters
    ----------
    quantity
        Any result.
    where
        Axis name to entry. A number is compared with the axis values within 1e-9 relative, a
        text with a unit is converted to the unit of the axis first; names have to match exactly.
        A crank speed between two samples of a curve picks the straight line between these.

    Returns
    -------
    Selection
        The remaining array, whose entries have labels; a scalar has one entry labelled "".

    Raises
    ------
    ResultError
        An axis or entry does not exist; the message lists what does.
    """
    unknown = [name for name in where if name not in {axis.name for axis in quantity.axes}]
    if unknown:
        raise ResultError(_no_axis(quantity, unknown[0]))
    index: list[int | slice] = []
    left: list[Axis] = []
    crossed: tuple[int, Axis, float] | None = None
    for axis in quantity.axes:
        place: int | slice = slice(None)
        between = _between(quantity, axis, where.get(axis.name))
        if between is not None:
            crossed = sum(isinstance(one, slice) for one in index), axis, between
            axis = replace(axis, values=np.array([between]))
        elif axis.name in where:
            place = _position(quantity, axis, where[axis.name])
            axis = replace(axis, values=np.asarray(axis.values)[[place]])
        index.append(place)
        left.append(axis)
    values, off = np.asarray(quantity.values)[tuple(index)], 0.0
    errors = np.broadcast_to(float(quantity.error_estimate), values.shape)
    if quantity.errors is not None and crossed is None:
        errors = np.asarray(quantity.errors[tuple(index)])
    if crossed is not None:
        along, axis, between = crossed
        values, off = _on_the_line(np.moveaxis(values, along, 0), axis, between)
        errors = np.broadcast_to(float(quantity.error_estimate), values.shape)
    return Selection(values, tuple(left), errors, off)


def _between(quantity: Quantity, axis: Axis, key: Key | None) -> float | None:
    """The place between two samples of a curve that is asked for, None where it is not."""
    if key is None or axis.name not in SAMPLED or len(axis.values) < 2:
        return None
    samples, wanted = np.asarray(axis.values, dtype=float), _number(quantity, axis, key)
    near = float(np.min(np.abs(samples - wanted)))
    # a whole number, as that of an order, has nothing in between
    real = np.asarray(quantity.values).dtype.kind in "fc"
    inside = real and samples[0] < wanted < samples[-1] and near > LABEL_RTOL * wanted
    return wanted if inside else None


def _on_the_line(rows: np.ndarray, axis: Axis, wanted: float) -> tuple[np.ndarray, float]:
    """Values between the two of the samples (k, ...) about `wanted`, and what they may be off."""
    at = np.asarray(axis.values, dtype=float)
    right = int(np.searchsorted(at, wanted))
    share = (wanted - at[right - 1]) / (at[right] - at[right - 1])
    near = np.arange(max(right - 2, 0), min(right + 2, len(at)))
    weights = [
        np.prod((wanted - at[near[near != k]]) / (at[k] - at[near[near != k]])) for k in near
    ]
    with np.errstate(invalid="ignore"):
        line = (1.0 - share) * rows[right - 1] + share * rows[right]
        off = np.abs(np.tensordot(weights, rows[near], 1) - line)
        off = np.where(np.isfinite(off), off, np.where(np.isfinite(line), np.abs(line), 0.0))
    return line, float(np.max(off, initial=0.0))


def numbers(quantity: Quantity, where: Where) -> Selection:
    """The entries that `where` leaves, (n,) real ones, complex ones by their magnitude."""
    picked = select(quantity, where)
    if picked.values.size == 0:
        raise ResultError(f"{quantity.path} has no entries to pick the worst of")
    if picked.values.dtype.kind not in "biufc":
        raise ResultError(f"{quantity.path} holds names, there is no worst of them")
    size = np.abs(picked.values) if np.iscomplexobj(picked.values) else picked.values
    return picked._replace(values=size.astype(float).ravel(), errors=picked.errors.ravel())


def worst(quantity: Quantity, where: Where, sense: Side) -> tuple[float, str]:
    """Largest ("max") or smallest ("min") entry that `where` leaves, with its label.

    Complex entries count by magnitude, and NaN is worse than any number.
    """
    picked = numbers(quantity, where)
    flat = picked.values
    missing = np.isnan(flat)
    if missing.any():
        return float("nan"), picked.label(int(np.argmax(missing)))
    size = flat if sense == "max" else -flat
    return float(flat[np.argmax(size)]), picked.label(first_of_largest(size))


#: axes along which every candidate of a search has the same entries, parts of its machine
PARTS = frozenset({"mount", "direction", "cylinder", "station", "section", "damper", "gear",
                   "coupling", "main_bearing", "sensor"})  # fmt: skip


def parts_of(quantity: Quantity, where: Where, sense: Side) -> tuple[np.ndarray, np.ndarray]:
    """Entries (n,) that `where` leaves, and how far the truth may lie beyond each.

    Of entries along axes that are no parts of the machine, as of a curve, the worst counts.
    """
    flat, _, errors, _ = numbers(quantity, where)
    free = [axis for axis in quantity.axes if axis.name not in where]
    shape = tuple(len(axis.values) for axis in free)
    along = tuple(place for place, axis in enumerate(free) if axis.name not in PARTS)
    exact = quantity.zeros(flat, errors) | ~np.isfinite(flat)
    reach = np.where(exact, 0.0, errors + beside_error(quantity, where))
    largest = np.max if sense == "max" else np.min
    return (
        np.ravel(largest(flat.reshape(shape), axis=along)),
        np.ravel(np.max(reach.reshape(shape), axis=along)),
    )


def uncertainty(quantity: Quantity, where: Where) -> float:
    """How far the truth may be off any of what `where` picks, in the unit of the quantity.

    The error estimate, and what `beside_error` says.
    """
    return float(quantity.error_estimate) + beside_error(quantity, where)


def beside_error(quantity: Quantity, where: Where) -> float:
    """What a place between two samples adds, and of a statistic as many standard errors as a
    comparison of two results grants, in the unit of the quantity."""
    spread = 0.0 if quantity.standard_error is None else STANDARD_ERRORS * quantity.standard_error
    return select(quantity, where).curving + spread


def scalar(quantity: Quantity, where: Where) -> float | complex:
    """The one entry that `where` picks; ResultError where it leaves several, or none."""
    values = select(quantity, where).values
    if values.size != 1:
        free = [
            f"{axis.name} ({_entries(axis)})" for axis in quantity.axes if axis.name not in where
        ]
        raise ResultError(
            f"{quantity.path} has {values.size} entries here, one is needed: "
            f"name also {', '.join(free)}"
        )
    if values.dtype.kind not in "biufc":
        raise ResultError(f"{quantity.path} holds names, a number is needed")
    only = values.ravel()[0]
    return complex(only) if np.iscomplexobj(values) else float(only)


def label_of(axes: Sequence[Axis], prefix: str = "") -> Callable[[int], str]:
    """What labels each entry of an array over `axes`, in C order: `mount=2, order=1`."""
    shape = tuple(len(axis.values) for axis in axes)

    def label(place: int) -> str:
        positions = np.unravel_index(place, shape)
        texts = [
            f"{axis.name}={entry_text(axis, int(position))}"
            for axis, position in zip(axes, positions, strict=True)
        ]
        return ", ".join([prefix, *texts] if prefix else texts)

    return label


def entry_text(axis: Axis, position: int) -> str:
    """How one entry of an axis is written in labels: `2`, `left front`, `513.127 rad/s`."""
    value = axis.values[position]
    if axis.values.dtype.kind not in "biuf":
        return str(value)
    text = str(int(value)) if axis.values.dtype.kind in "biu" else format(float(value), ".9g")
    return f"{text} {axis.unit}" if axis.unit else text


def nearest(word: str, known: Sequence[str]) -> list[str]:
    """Known words, those that look like `word` first."""
    from difflib import get_close_matches

    close = get_close_matches(word, known, n=3, cutoff=0.5)
    return close + [other for other in known if other not in close]


def _position(quantity: Quantity, axis: Axis, key: Key) -> int:
    if axis.values.dtype.kind not in "biuf":
        names = [str(name) for name in axis.values]
        if isinstance(key, bool) or str(key) not in names:
            raise ResultError(_no_entry(quantity, axis, key))
        return names.index(str(key))
    wanted = _number(quantity, axis, key)
    values = np.asarray(axis.values, dtype=float)
    distance = np.abs(values - wanted)
    position = int(np.argmin(distance)) if distance.size else 0
    if not distance.size or not (
        distance[position] <= LABEL_RTOL * max(abs(wanted), abs(values[position]))
    ):
        raise ResultError(_no_entry(quantity, axis, key, wanted))
    return position


def _number(quantity: Quantity, axis: Axis, key: Key) -> float:
    if isinstance(key, bool):
        raise ResultError(_no_entry(quantity, axis, key))
    if isinstance(key, str):
        from vibecalc.units import parse_quantity

        try:
            return float(parse_quantity(key, axis.unit))
        except UnitError as error:
            raise ResultError(
                f"{quantity.path}: {axis.name} = {key!r} cannot be read: {error}"
            ) from error
    return float(key)


def _no_axis(quantity: Quantity, name: str) -> str:
    known = [axis.name for axis in quantity.axes]
    if not known:
        return f"{quantity.path} is one number, it has no axis {name!r}: leave `where` out"
    return f"{quantity.path} has no axis {name!r}; it has {', '.join(nearest(name, known))}"


def _no_entry(quantity: Quantity, axis: Axis, key: Key, wanted: float | None = None) -> str:
    near = _entries(axis, key if wanted is None else wanted)
    return f"{quantity.path} has no entry {axis.name} = {key!r}; there is {near}"


def _entries(axis: Axis, key: Key | None = None) -> str:
    """Entries of an axis for a message: the nearest ones to `key`, or the first ones."""
    texts = [entry_text(axis, position) for position in range(len(axis.values))]
    if isinstance(key, str) and axis.values.dtype.kind not in "biuf":
        texts = nearest(key, texts)
    elif isinstance(key, int | float) and axis.values.dtype.kind in "biuf":
        near = np.argsort(np.abs(np.asarray(axis.values, dtype=float) - key), kind="stable")
        texts = [texts[position] for position in near[:_SHOWN]] + texts[_SHOWN:]
    if len(texts) > _SHOWN:
        return f"{', '.join(texts[:_SHOWN])} ... ({len(texts)} in all)"
    return ", ".join(texts) or "no entry at all"
