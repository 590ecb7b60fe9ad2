"""A value with a bound of its error: arithmetic that carries the bound along, to first order."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.leading import product
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# The error of a result is what its operands' errors make of it, plus the rounding of the operation.
#
# Products of two errors are left out, and the bounds are not rounded upwards: they are estimates
# that hold where errors are small beside the values, not enclosures.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Bounded:
    """Real or complex values and an absolute error, real, of the same shape (or one that
    broadcasts to it) and unit. Arrays and numbers beside it in a formula count as exact.

    What is known about data: `Bounded(value, error)`; `rounded(value, n)` carries n roundings.
    """

    value: np.ndarray
    error: np.ndarray

    #: numpy leaves `array * bounded` to the methods here
    __array_ufunc__ = None

    def __iter__(self) -> Iterator[Any]:
        """Value and error, for `value, error = bounded`."""
        return iter((self.value, self.error))

    def __getitem__(self, index: Any) -> "Bounded":
        return Bounded(self.value[index], self.errors[index])

    def __neg__(self) -> "Bounded":
        return Bounded(-self.value, self.error)

    def __abs__(self) -> "Bounded":
        size = np.abs(self.value)
        lost = self.error + 2.0 * UNIT_ROUNDOFF * size if np.iscomplexobj(self.value) else None
        return Bounded(size, self.error if lost is None else lost)

    def __add__(self, other: "Operand") -> "Bounded":
        value, error = pair(other)
        total = self.value + value
        return Bounded(total, self.error + error + UNIT_ROUNDOFF * np.abs(total))

    def __sub__(self, other: "Operand") -> "Bounded":
        value, error = pair(other)
        rest = self.value - value
        return Bounded(rest, self.error + error + UNIT_ROUNDOFF * np.abs(rest))

    def __rsub__(self, other: ArrayLike) -> "Bounded":
        return -self + other

    def __mul__(self, other: "Operand") -> "Bounded":
        value, error = pair(other)
        product, carried = self.value * value, np.abs(value) * self.error
        if isinstance(other, Bounded):
            carried = carried + np.abs(self.value) * error
        return Bounded(product, carried + _roundings(product) * np.abs(product))

    def __truediv__(self, other: "Operand") -> "Bounded":
        value, error = pair(other)
        quotient = self.value / value
        size = np.abs(quotient)
        carried = (self.error + size * error) / np.abs(value)
        return Bounded(quotient, carried + 2.0 * _roundings(quotient) * size)

    def __rtruediv__(self, other: ArrayLike) -> "Bounded":
        return bounded(other) / self

    def __matmul__(self, other: "Operand") -> "Bounded":
        value, error = pair(other)
        return _matrix_product(self.value, self.error, value, error)

    def __rmatmul__(self, other: ArrayLike) -> "Bounded":
        return _matrix_product(np.asarray(other), 0.0, self.value, self.error)

    __radd__ = __add__
    __rmul__ = __mul__

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values."""
        return np.shape(self.value)

    @property
    def errors(self) -> np.ndarray:
        """An error for each value."""
        return np.asarray(_of_shape(self.error, np.shape(self.value)))

    @property
    def real(self) -> "Bounded":
        """Real parts, which may be off by all of the error."""
        return Bounded(np.real(self.value), self.error)

    @property
    def imag(self) -> "Bounded":
        """Imaginary parts, which may be off by all of the error."""
        return Bounded(np.imag(self.value), self.error)

    @property
    def T(self) -> "Bounded":
        """Axes in reverse."""
        return Bounded(np.transpose(self.value), self.errors.T)

    def sum(self, axis: int | tuple[int, ...] = -1) -> "Bounded":
        """Sum over axes: errors add, and a rounding for each doubling of the number of terms."""
        total = np.sum(self.value, axis=axis)
        terms = np.abs(self.value)
        depth = np.log2(max(terms.size / max(np.size(total), 1), 1.0)) + 1.0
        lost = self.error + depth * UNIT_ROUNDOFF * terms
        return Bounded(total, np.sum(_of_shape(lost, self.shape), axis=axis))

    def norm(self, axis: int = -1) -> "Bounded":
        """Root of the sum of squared magnitudes over one axis: it is off by no more than they."""
        length = np.linalg.norm(self.value, axis=axis)
        off = np.linalg.norm(self.errors, axis=axis)
        return Bounded(length, off + (self.shape[axis] + 2.0) * UNIT_ROUNDOFF * length)

    def max(self, axis: int = -1) -> "Bounded":
        """Largest value over one axis; the error is of those that may be the largest."""
        error = self.errors
        top = np.max(self.value, axis=axis)
        with np.errstate(invalid="ignore"):
            above = np.max(error - (np.expand_dims(top, axis) - self.value), axis=axis)
        return Bounded(top, np.where(np.isfinite(top), above, np.max(error, axis=axis)))


def _of_shape(error: Any, shape: tuple[int, ...]) -> Any:
    """An error of that shape; broadcasting costs more than most operations on small arrays."""
    return error if np.shape(error) == shape else np.broadcast_to(error, shape)


class Summed(NamedTuple):
    """A value with its absolute error, and the size of the terms that it is the sum of.

    Where the terms cancel, what is left has no scale of its own.
    """

    value: Any
    error: Any
    terms: float


#: what may stand beside a bounded value in a formula; what is not bounded counts as exact
Operand: TypeAlias = Bounded | ArrayLike


def bounded(value: Operand) -> Bounded:
    """As it is, or an exact number or array with an error of zero."""
    return value if isinstance(value, Bounded) else Bounded(np.asarray(value), np.zeros(()))


def rounded(value: ArrayLike, roundings: float) -> Bounded:
    """A value that carries that many roundings, relative to its size."""
    return Bounded(np.asarray(value), np.asarray(roundings * UNIT_ROUNDOFF * np.abs(value)))


def pair(value: Operand) -> tuple[Any, Any]:
    """Value and error of what stands in a formula."""
    return (value.value, value.error) if isinstance(value, Bounded) else (np.asarray(value), 0.0)


# ----------------------------------------------------------------------------
# Functions of bounded values.
# ----------------------------------------------------------------------------


def square(value: Bounded) -> Bounded:
    """Square of real values, or of complex ones as a product."""
    squared = value.value * value.value
    carried = 2.0 * np.abs(value.value) * value.error
    return Bounded(squared, carried + _roundings(squared) * np.abs(squared))


def sqrt(value: Bounded) -> Bounded:
    """Root of values that are not negative; of zero, that of the error."""
    root = np.sqrt(value.value)
    off = np.sqrt(value.error)
    carried = np.where(root > off, 0.5 * value.error / np.where(root > off, root, 1.0), off)
    return Bounded(root, carried + UNIT_ROUNDOFF * root)


def quadratic(state: Bounded, matrix: Bounded) -> Bounded:
    """x* A x (..., m), real, of states x (..., m, n) and symmetric matrices A (..., n, n).

    To second order in the errors of x, so that it holds of a state that is nothing but rounding.
    """
    moved, size = state.value @ matrix.value, np.abs(state.value)
    value = np.sum(state.value.conj() * moved, axis=-1).real
    spread = 2.0 * np.abs(moved) * state.error + state.error * (state.error @ np.abs(matrix.value))
    lost = matrix.error + 16.0 * UNIT_ROUNDOFF * np.abs(matrix.value)
    return Bounded(value, np.sum(spread + size * (size @ lost), axis=-1))


def where(chosen: Any, value: Operand, other: Operand) -> Bounded:
    """Values and errors of one or the other."""
    (first, its_error), (second, error) = pair(value), pair(other)
    return Bounded(np.where(chosen, first, second), np.where(chosen, its_error, error))


def maximum(value: Operand, other: Operand) -> Bounded:
    """The larger one of two; the error is of those that may be that."""
    (first, its_error), (second, error) = pair(value), pair(other)
    both = np.broadcast_arrays(first, its_error, second, error)
    return stack([Bounded(*both[:2]), Bounded(*both[2:])]).max()


def concatenate(parts: Sequence[Bounded], axis: int = -1) -> Bounded:
    """Parts after each other along an axis."""
    return _joined(np.concatenate, parts, axis)


def stack(parts: Sequence[Bounded], axis: int = -1) -> Bounded:
    """Parts of one shape beside each other along a new axis."""
    return _joined(np.stack, parts, axis)


def reshaped(value: Bounded, change: Callable[[Any], Any]) -> Bounded:
    """Both arrays after a function that only moves or repeats entries, such as `np.moveaxis`."""
    return Bounded(change(value.value), change(value.errors))


def _joined(join: Callable[..., Any], parts: Sequence[Bounded], axis: int) -> Bounded:
    errors = [one.errors for one in parts]
    return Bounded(join([one.value for one in parts], axis=axis), join(errors, axis=axis))


def _matrix_product(first: Any, first_error: Any, second: Any, second_error: Any) -> Bounded:
    """Sums of products; the terms, and not the sums, say how much is lost where they cancel."""
    found = product(first, second)
    sizes, other_sizes = np.abs(first), np.abs(second)
    lost = (np.shape(first)[-1] + 2.0) * UNIT_ROUNDOFF
    error = product(_of_shape(first_error, sizes.shape) + lost * sizes, other_sizes)
    if np.any(second_error):
        error = error + product(sizes, _of_shape(second_error, other_sizes.shape))
    return Bounded(found, error)


def _roundings(product: Any) -> float:
    """Of a product: one of real numbers; at most sqrt(5) of them of complex ones."""
    return 3.0 * UNIT_ROUNDOFF if np.iscomplexobj(product) else UNIT_ROUNDOFF
