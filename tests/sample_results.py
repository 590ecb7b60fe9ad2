"""Made-up results for the tests of the store and the comparison."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.record import Axis, Method, Quantity, Record, Result

ORDER = Axis(name="order", values=np.arange(1, 11), long_name="multiple of the running speed")
MOUNT = Axis(name="mount", values=np.array(["left front", "höger", "3"]), long_name="mount")
DIRECTION = Axis(name="direction", values=np.array(["x", "y", "z"]))
MODE = Axis(name="mode", values=np.arange(1, 7))
COORDINATE = Axis(name="coordinate", values=np.array(["x", "y", "z", "rx", "ry", "rz"]))
CASE = {"title": "a sample", "machine": {"speed": 513.0, "positions": [[0.1, 0.2]]}}
SPEED = Axis(name="speed", values=np.linspace(0.0, 513.0, 40), unit="rad/s", long_name="speed")


def quantity(path: str, axes: tuple[Axis, ...] = (), seed: int = 0, **more: Any) -> Quantity:
    """A quantity with random values; `more` replaces any of its fields."""
    generator = np.random.default_rng([seed, *path.encode()])
    values = np.asarray(generator.normal(size=tuple(len(axis.values) for axis in axes)))
    if more.pop("is_complex", False):
        values = values + 1j * generator.normal(size=values.shape)
    made = Quantity(path=path, values=values, unit="N", long_name=f"{path} in words", axes=axes)
    return replace(made, **{"error_estimate": 1e-13, **more})


def result_of(*quantities: Quantity, **more: Any) -> Result:
    """A result with these quantities; `more` replaces any field of the result."""
    record = Record(
        warnings=["a resonance whose modal force is zero: order 3, mode 2"],
        methods=[Method(name="sums", purpose="forces", citation="A. N. Author, A Book, 1999")],
    )
    for one in quantities:
        record.add(one)
    made = Result(
        name="sample",
        case=CASE,
        case_toml='title = "a sample" # as written\n[machine]\nspeed = "513 rad/s"\n',
        case_toml_resolved=(
            'title = "a sample"\n[machine]\nspeed = 513.0\npositions = [[0.1, 0.2]]\n'
        ),
        case_sha256=case_hash(CASE, "0.1.0"),
        record=record,
        version="0.1.0",
        plan=({"stage": "excitation", "why": "the case has [excitation]"},),
        provenance={"host": "here", "cores": 2, "load": 0.25},
        timings={"excitation": 0.5, "another": 0.25},
    )
    return replace(made, **more)


def typical() -> Result:
    """Sixty quantities in three stages over shared axes, like a run of a generator set."""
    shapes: list[tuple[Axis, ...]] = [(), (ORDER,), (MOUNT,), (MOUNT, DIRECTION, ORDER)]
    stages = ("kinematics", "excitation", "isolation/support")
    return result_of(
        *(
            quantity(
                f"{stages[number % 3]}/quantity_{number}",
                shapes[number % 4],
                seed=number,
                is_complex=number % 2 == 1,
                amplitude="0-pk" if number % 2 else None,
            )
            for number in range(59)
        ),
        quantity("isolation/run_up", (MOUNT, SPEED)),
    )


def changed(result: Result, path: str, **fields: Any) -> Result:
    """`result` with some fields of one quantity replaced."""
    return with_quantities(result, {path: replace(result.record[path], **fields)})


def with_quantities(result: Result, others: Mapping[str, Quantity | None]) -> Result:
    """`result` with quantities replaced or added, or left out where they are None."""
    kept = {**result.record.quantities, **others}
    quantities = {path: one for path, one in kept.items() if one is not None}
    return replace(result, record=replace(result.record, quantities=quantities))
