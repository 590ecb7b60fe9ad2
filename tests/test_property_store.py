"""Claim: what is written is read back bit for bit, and equal results make equal files."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from sample_results import DIRECTION, MODE, ORDER, SPEED, quantity, result_of, typical

from vibecalc.core.results.compare import accept
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.core.results.store import file_image, read_result, write_result
from vibecalc.core.results.visible import visible

ANY = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=30)
#: what is not to be printed is spelled out where a file is read, but in the text of its case
TEXTS = ANY.map(visible)
NAMES = st.text("abcdefghij_", min_size=1, max_size=8)


@st.composite
def quantities(draw: Any, path: str) -> Quantity:
    """Any quantity: real, complex, whole or text, over up to three axes of any length."""
    lengths = draw(st.lists(st.integers(0, 4), max_size=3))
    axes = []
    for number, length in enumerate(lengths):
        kind = draw(st.sampled_from(["names", "floats", "integers"]))
        if kind == "names":
            values = np.array(
                draw(st.lists(TEXTS, min_size=length, max_size=length)), dtype=np.str_
            )
        elif kind == "floats":
            values = draw(arrays.arrays(float, length, elements=st.floats(-1e9, 1e9)))
        else:
            values = draw(arrays.arrays(np.int64, length))
        axes.append(
            Axis(name=f"axis{number}", values=values, unit=draw(TEXTS), long_name=draw(TEXTS))
        )
    dtype = draw(st.sampled_from([np.float64, np.complex128, np.int64, np.str_]))
    if dtype is np.str_:
        size = int(np.prod(lengths))
        texts = draw(st.lists(TEXTS, min_size=size, max_size=size))
        values = np.array(texts, dtype=np.str_).reshape(lengths)
    else:
        values = np.asarray(draw(arrays.arrays(dtype, tuple(lengths))))
    return Quantity(
        path=path,
        values=values,
        unit=draw(TEXTS),
        long_name=draw(TEXTS),
        axes=tuple(axes),
        amplitude=draw(st.sampled_from([None, "0-pk", "pk-pk", "rms"])),
        error_estimate=draw(st.floats(0.0, allow_nan=False)),
        standard_error=draw(st.none() | st.floats(0.0, 1e300)),
        terms=draw(st.floats(0.0, 1e300)),
    )


@st.composite
def results(draw: Any) -> Result:
    paths = [
        f"{stage}/{name}"
        for stage, name in draw(
            st.lists(st.tuples(st.sampled_from("abc"), NAMES), unique=True, max_size=4)
        )
    ]
    return result_of(
        *(draw(quantities(path)) for path in paths),
        name=draw(TEXTS),
        case_toml=draw(ANY),
        provenance=draw(st.dictionaries(NAMES, TEXTS | st.floats(allow_nan=False))),
        timings=draw(st.dictionaries(NAMES, st.floats(0, 1e6))),
    )


def assert_same(one: Result, other: Result) -> None:
    assert one == other and file_image(one) == file_image(other)


@settings(max_examples=10, deadline=None, suppress_health_check=list(HealthCheck))
@given(results())
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, made: Result
) -> None:
    path = write_result(made, tmp_path_factory.getbasetemp() / "any.h5")
    assert_same(made, read_result(path))


def test_a_long_case_fits(tmp_path: Path) -> None:
    text = "# a long comment\n" * 20_000
    made = result_of(quantity("a/b"), case_toml=text)
    assert read_result(write_result(made, tmp_path / "r.h5")).case_toml == text


def test_the_same_result_gives_the_same_bytes() -> None:
    made = typical()
    first = file_image(made)
    # creation times in HDF5 have a resolution of a second
    time.sleep(1.01 - time.time() % 1.0)
    assert file_image(made) == first


def test_accepted_bytes_do_not_depend_on_provenance(tmp_path: Path) -> None:
    made = typical()
    golden = []
    for number, host in enumerate(("here", "somewhere else")):
        path = write_result(replace(made, provenance={"host": host}), tmp_path / f"{number}.h5")
        golden.append(accept(path, tmp_path / f"golden{number}.h5"))
    assert golden[0].read_bytes() == golden[1].read_bytes()
    with h5py.File(golden[0]) as file:
        assert list(file["provenance"].attrs) == ["text_checksum"]
        assert not list(file["provenance"])
    again = accept(golden[0], tmp_path / "again.h5")
    assert again.read_bytes() == golden[0].read_bytes()


def test_axes_are_shared_or_numbered(tmp_path: Path) -> None:
    short = replace(ORDER, values=ORDER.values[:2])
    made = result_of(
        quantity("a/one", (ORDER, DIRECTION)),
        quantity("a/deep/two", (ORDER,)),
        quantity("a/three", (short,)),
        quantity("a/mode", (MODE,)),
        quantity("b/one", (ORDER,)),
        quantity("alone", (SPEED,)),
    )
    path = write_result(made, tmp_path / "r.h5")
    with h5py.File(path) as file:
        scales = sorted(name for name, item in visited(file) if item.is_scale)
        # each object once, the shared one by its first name
        assert scales == [
            "a/deep/order", "a/direction", "a/mode_2", "a/order_2", "b/order", "speed"
        ]  # fmt: skip
        assert file["a/deep/order"] == file["a/order"]
        assert file["a/deep/two"].dims[0][0] == file["a/order"]
        assert file["a/three"].dims[0].label == "order"
    assert_same(made, read_result(path))


def visited(file: h5py.File) -> list[tuple[str, h5py.Dataset]]:
    found: list[tuple[str, h5py.Dataset]] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found.append((name, item))

    file.visititems(visit)
    return found
