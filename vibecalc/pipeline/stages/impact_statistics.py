"""Statistics of the impact forces under the names of their results, and how exact they are."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.impact.added_force import added_force
from vibecalc.response.impact.ensemble import Statistic, mean_over_runs, quantiles
from vibecalc.response.impact.linkage import Linkage
from vibecalc.response.impact.runs import Ensemble, Forces
from vibecalc.response.impact.spectra import HIGH, LOW, spectra


def statistics(forces: Forces, linkage: Linkage) -> dict[str, Statistic]:
    """Statistics of the forces by what their paths have behind `response/impact/`."""
    turn = 2.0 * np.pi / linkage.drive.speed
    pin = forces.wrist_pin
    low, high = quantiles(pin.force, (LOW, HIGH))
    (peak_high,) = quantiles(pin.peak, (HIGH,))
    bands = spectra(pin.harmonics)
    added = np.abs(added_force(linkage, forces)[..., 1:])
    found = {
        "mean_force": mean_over_runs(pin.force),
        "mean_force_low": low,
        "mean_force_high": high,
        "spectrum": bands.mean,
        "spectrum_low": bands.low,
        "spectrum_high": bands.high,
        "average_amplitude": bands.average,
        "added_force": mean_over_runs(added),
        "peak_force": mean_over_runs(pin.peak),
        "peak_force_high": peak_high,
        "impacts": mean_over_runs(pin.contacts),
        "contact_share": mean_over_runs(pin.contact_time / turn),
    }
    for name, gap in (("crank_pin", forces.crank_pin), ("bore", forces.bore)):
        if gap is not None:
            found[f"{name}/mean_force"] = mean_over_runs(gap.force)
            found[f"{name}/impacts"] = mean_over_runs(gap.contacts)
    return found


def numerical_errors(
    found: dict[str, Statistic], exact: Ensemble, linkage: Linkage
) -> dict[str, np.ndarray]:
    """What imbalance of energy and rounding make of each statistic: absolute, at most."""
    relative = np.max(exact.residual, axis=(1, 2)) + 32.0 * EPSILON
    # a harmonic is twice a mean
    force = 2.0 * relative * np.max(exact.forces.wrist_pin.force, axis=(1, 2))
    # energy of a contact spring: dF = K dE / F
    peak = exact.forces.wrist_pin.peak
    energy = relative * np.max(exact.exchanged, axis=(1, 2))
    stiffness = float(linkage.wrist_pin.stiffness)
    smallest = np.maximum(np.min(peak, axis=(1, 2)), np.sqrt(stiffness * energy))
    of_peak = stiffness * energy / np.where(smallest > 0.0, smallest, 1.0)
    errors = {}
    for name, statistic in found.items():
        own = 2.0 * relative * np.max(np.abs(statistic.value), axis=0) if "/" in name else force
        errors[name] = np.asarray(own)
    errors["peak_force"] = errors["peak_force_high"] = of_peak
    errors["contact_share"] = np.asarray(64.0 * EPSILON)
    for name in found:
        if name.endswith("impacts"):
            errors[name] = np.asarray(64.0 * EPSILON * np.max(found[name].value))
    return errors


def differences(found: dict[str, Statistic], exact: dict[str, Statistic]) -> dict[str, np.ndarray]:
    """How far a fixed-step method is off: the event-exact statistics, and two standard errors."""
    return {
        name: np.abs(statistic.value - exact[name].value)
        + 2.0 * np.hypot(statistic.standard_error, exact[name].standard_error)
        for name, statistic in found.items()
    }
