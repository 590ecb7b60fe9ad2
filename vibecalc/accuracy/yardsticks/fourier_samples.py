"""Harmonics from samples of a cycle and samples from harmonics, by the plain Fourier transform."""

import numpy as np

from vibecalc.errors import NumericalFailure


def harmonics_of_samples(samples: np.ndarray, highest_order: int) -> np.ndarray:
    """Complex 0-to-peak amplitudes of x(t) = Re sum X_n exp(i n w t), orders 0 to highest.

    Parameters
    ----------
    samples : real array (..., count)
        One cycle, evenly spaced, its first point once.
    highest_order : int

    Returns
    -------
    complex array (..., highest_order + 1)
        Order 0 is the mean.

    Raises
    ------
    NumericalFailure
        There are not more samples than twice the highest order: it folds onto lower ones.
    """
    count = samples.shape[-1]
    if count <= 2 * highest_order:
        raise NumericalFailure(
            f"{count} samples cannot tell order {highest_order} from lower ones: more than "
            f"{2 * highest_order} are needed"
        )
    found: np.ndarray = np.fft.rfft(samples, axis=-1)[..., : highest_order + 1] * (2.0 / count)
    found[..., 0] *= 0.5
    return found


def samples_of_harmonics(harmonics: np.ndarray, orders: np.ndarray, count: int) -> np.ndarray:
    """One cycle (..., count) of the sum of harmonics (..., orders) at evenly spaced angles.

    Any count will do: orders beyond half of it fold down, as samples of the true sum do.
    """
    spectrum = np.zeros((*harmonics.shape[:-1], count), dtype=complex)
    for place, order in enumerate(orders.tolist()):
        spectrum[..., order % count] += harmonics[..., place]
    return np.asarray(np.fft.ifft(spectrum, axis=-1).real * count)


def transform_work(count: int) -> float:
    """Complex multiplications of a fast transform of `count` samples, count/2 log2(count)."""
    return 0.5 * count * max(float(np.log2(count)), 1.0)
