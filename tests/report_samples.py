"""Results for the tests of the report: golden ones with other tables, and small ones made here."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.core.results.store import read_result

ORDERS = Axis(name="order", values=np.array([1, 2]), long_name="multiple of crank speed")
DIRECTIONS = Axis(name="direction", values=np.array(["x", "y", "z"], dtype=object))
MOUNTS = Axis(name="mount", values=np.array(["1", "2", "3", "4"], dtype=object))


@cache
def _read(name: str) -> Result:
    return read_result(Path(__file__).resolve().parent / "golden" / f"{name}.h5")


def golden(name: str, **tables: Any) -> Result:
    """A golden result, its record free to be changed, with some tables of its case replaced."""
    kept = _read(name)
    record = Record(
        quantities=dict(kept.record.quantities), warnings=list(kept.record.warnings),
        methods=list(kept.record.methods),
    )  # fmt: skip
    verdicts = None if "limit" in tables else kept.verdicts
    return replace(kept, record=record, case={**kept.case, **tables}, verdicts=verdicts)


def generator(**tables: Any) -> Result:
    """The generator as the source publishes it, with its references and limits unless replaced."""
    return golden("generator", **tables)


def optimised() -> Result:
    """The generator after a search over mounts and block, limits held at both ends."""
    return golden("generator_mount_design")


def quantity(
    path: str, values: Any, unit: str, *axes: Axis, error: float | None = None, **more: Any
) -> Quantity:
    """A quantity with an error estimate of 1e-14 of its largest entry, unless given."""
    array = np.asarray(values)
    if error is None:
        finite = array[np.isfinite(array)] if array.dtype.kind in "fc" else np.array([])
        error = 1e-14 * float(np.max(np.abs(finite), initial=0.0))
    return Quantity(
        path=path,
        values=array,
        unit=unit,
        long_name=path.rsplit("/", 1)[-1].replace("_", " "),
        axes=axes,
        error_estimate=error,
        **more,
    )


def generator_case(**more: Any) -> dict[str, Any]:
    """The resolved case of the generator without references and limits, some tables added."""
    whole = _read("generator").case
    return {key: whole[key] for key in whole if key not in ("reference", "limit")} | more


def result_of(record: Record, case: dict[str, Any], **more: Any) -> Result:
    """A finished run around a record."""
    fixed: dict[str, Any] = {
        "name": "generator",
        "case": case,
        "case_toml": "schema = 1\n",
        "case_toml_resolved": "schema = 1\n",
        "case_sha256": case_hash({"schema": 1}, "0.1.0"),
        "record": record,
        "version": "0.1.0",
        "plan": ({"stage": "excitation", "why": "[isolation] needs it", "orders": "1 to 2"},),
        "provenance": {"command": "vibecalc run cases/generator.toml", "host": "here"},
        "timings": {"excitation": 0.0012, "isolation": 0.0101},
    }
    return Result(**{**fixed, **more})


def rigid_body() -> Result:
    """A body with six modes, without references or limits."""
    modes = Axis(name="mode", values=np.arange(1, 7))
    names = np.array(["x", "y", "z", "rx", "ry", "rz"], dtype=object)
    coordinates = Axis(name="coordinate", values=names)
    fraction = np.eye(6)
    fraction[:2, :2] = [[0.8, 0.2], [0.2, 0.8]]
    record = Record()
    natural = [12.0, 18.0, 20.0, 31.7, 44.0, 51.0]
    record.add(quantity("isolation/modes/natural_frequency", natural, "rad/s", modes))
    record.add(quantity("isolation/modes/energy_fraction", fraction, "", modes, coordinates))
    record.warnings.append("mode 3 is at order 2, its modal force is zero")
    return result_of(record, generator_case(title="A rigid body"), name="body")
