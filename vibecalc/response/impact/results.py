"""What the runs of a batch give, revolution by revolution."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.impact.ledger import Ledger
from vibecalc.response.impact.setup import Setup
from vibecalc.response.impact.sweep import State
from vibecalc.response.impact.trace import Trace


class GapRecord(NamedTuple):
    """One gap of every run; arrays (B, revolutions) but for what is said otherwise.

    force_harmonics : complex (B, revolutions, N + 1), N
        One-sided 0-to-peak amplitudes over each revolution, F = Re sum F_n exp(i n theta);
        order 0 is the mean.
    mean_absolute_force, peak_force : N
        Mean and true maximum over time of |F|, film included.
    force_error : N
        Absolute error of each harmonic and of the mean, for the motion from the revolution's
        start: its energy residual and the rounding of the integrals.
    impact_count : contacts made. contact_time : s. impulse : N s, integral of |F| in contact.
    contact_dissipation, film_dissipation : J
    first_contacts : (B, 8), s
        When the first contacts of the run were made, infinity for those that were not.
    force, gap : (B, samples), N and m
        The last revolution at equal crank angles from 0.
    """

    force_harmonics: ComplexArray
    mean_absolute_force: FloatArray
    peak_force: FloatArray
    force_error: FloatArray
    impact_count: IntArray
    contact_time: FloatArray
    impulse: FloatArray
    contact_dissipation: FloatArray
    film_dissipation: FloatArray
    first_contacts: FloatArray
    force: FloatArray
    gap: FloatArray


class EnergyBalance(NamedTuple):
    """Energy of the axial or the lateral motion, J, arrays (B, revolutions).

    `stored` (B, revolutions + 1): kinetic and spring energy at the start and at each
    revolution's end. `work` of all forces from outside, `dissipated` in contacts and films,
    `residual` = change of stored - work + dissipated, zero but for errors; `exchanged` the sum of
    the sizes of what each piece of motion took and gave. `relative_error`: the larger of the
    residual and the rounding of the stored energy, over the larger of exchanged and stored.
    """

    stored: FloatArray
    work: FloatArray
    dissipated: FloatArray
    residual: FloatArray
    exchanged: FloatArray
    relative_error: FloatArray


class Revolutions(NamedTuple):
    """Runs of a batch; `crank_pin`, `wall` and `lateral` are None where there is no such gap.

    `end_gap`, `end_velocity` (B, revolutions, G) at the end of each revolution, m and m/s, gaps
    in the order wrist pin, crank pin, bore. `pin_work`, `gas_work` (B, revolutions) in J are done
    on the masses. `angle` (samples,) rad of the samples.
    """

    wrist_pin: GapRecord
    crank_pin: GapRecord | None
    wall: GapRecord | None
    axial: EnergyBalance
    lateral: EnergyBalance | None
    pin_work: FloatArray
    gas_work: FloatArray
    end_gap: FloatArray
    end_velocity: FloatArray
    angle: FloatArray


def collect(setup: Setup, state: State, ledger: Ledger, trace: Trace) -> Revolutions:
    """The books of a finished batch as results."""
    book, train = ledger.book, setup.train
    loss = book["contact_loss"] + book["film_loss"]
    work = book["pin_work"] + book["gas_work"]
    stored, exchanged = book["axial_energy"], book["axial_exchanged"]
    axial_loss = np.sum(loss[: train.bore], axis=0)
    axial = _balance(stored, work, axial_loss, exchanged)
    error, lateral, wall = axial.relative_error, None, None
    if train.bore is not None:
        bore_loss, exchanged = loss[train.bore], book["lateral_exchanged"]
        lateral = _balance(book["lateral_energy"], book["side_work"], bore_loss, exchanged)
        total_error = error + lateral.relative_error
        wall = _gap_record(setup, ledger, trace, train.bore, total_error)
    return Revolutions(
        _gap_record(setup, ledger, trace, 0, error),
        _gap_record(setup, ledger, trace, 1, error) if train.pin == 1 else None,
        wall,
        axial,
        lateral,
        book["pin_work"],
        book["gas_work"],
        np.moveaxis(book["gap"], 0, -1),
        np.moveaxis(book["velocity"], 0, -1),
        trace.angle,
    )


def _balance(
    stored: FloatArray, work: FloatArray, dissipated: FloatArray, exchanged: FloatArray
) -> EnergyBalance:
    residual = np.diff(stored, axis=-1) - work + dissipated
    largest = np.maximum(stored[:, 1:], stored[:, :-1])
    scale = np.maximum(exchanged, largest)
    doubt = np.maximum(np.abs(residual), 8.0 * EPSILON * scale)
    relative = doubt / np.where(scale > 0.0, scale, 1.0)
    return EnergyBalance(stored, work, dissipated, residual, exchanged, relative)


def _gap_record(
    setup: Setup, ledger: Ledger, trace: Trace, gap: int, relative: FloatArray
) -> GapRecord:
    book = {name: values[gap] for name, values in ledger.book.items() if values.ndim == 3}
    absolute = book["absolute"] * setup.speed / (2.0 * np.pi)
    return GapRecord(
        ledger.spectra[gap],
        absolute,
        book["peak"],
        # twice: a harmonic is twice a mean
        2.0 * absolute * (relative + 32.0 * EPSILON),
        book["count"].astype(np.int64),
        book["contact_time"],
        book["contact_absolute"],
        book["contact_loss"],
        book["film_loss"],
        ledger.first_contacts[gap],
        trace.force[gap],
        trace.gap[gap],
    )
