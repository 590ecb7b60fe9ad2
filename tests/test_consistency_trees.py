"""Claim: every result is a tree of xarray, made in Python or read from the file by xarray alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from long_but import long_but
from sample_results import MODE, MOUNT, ORDER, SPEED
from shipped_cases import ROOT

import vibecalc
from vibecalc.core.results.dimensions import dimension_names
from vibecalc.core.results.store import write_result
from vibecalc.core.results.sweep_file import is_sweep

GOLDEN = {path.name: path for path in sorted((ROOT / "tests" / "golden").glob("*.h5"))}
#: an axis with the name of a group, of a quantity in its group and below it, and all three
KEPT = ("absorber_two.h5", "generator_mount_fit.h5", "roll.h5")


def same(tree: Any, result: vibecalc.Result) -> None:
    for path, quantity in result.items():
        array = tree[path]
        assert type(array).__name__ == "DataArray" and array.attrs["units"] == quantity.unit, path
        assert array.shape == quantity.values.shape, path
        if quantity.values.dtype.kind in "OTU":
            assert array.values.ravel().tolist() == quantity.values.ravel().tolist(), path
        else:
            assert np.array_equal(array.values, quantity.values, equal_nan=True), path
        for name, axis in zip(array.dims, quantity.axes, strict=True):
            assert name == axis.name or str(name).startswith(f"{axis.name}_"), path
            labels = array.coords[name].values
            assert list(map(str, labels)) == list(map(str, axis.values)), (path, name)


@pytest.mark.parametrize("name", long_but(GOLDEN, *KEPT))
def test_every_shipped_result_is_a_tree(name: str, tmp_path: Path) -> None:
    import xarray

    result = vibecalc.read(GOLDEN[name])
    same(result.to_xarray(), result)
    path = GOLDEN[name]
    if not is_sweep(path):  # as it would be written now
        path = write_result(result, tmp_path / name)
        assert vibecalc.diff(GOLDEN[name], path).same
    with xarray.open_datatree(path, engine="h5netcdf") as tree:
        same(tree, result)


def test_an_axis_gives_way_to_what_shares_its_name() -> None:
    short = vibecalc.Axis(name="order", values=ORDER.values[:2])
    names = dimension_names({
        "a/one": (ORDER, MODE),
        "a/deep/two": (ORDER, short),
        "a/deep/mode": (),  # below a place where `mode` stands
        "b/mount/three": (MOUNT, SPEED),  # `mount` stands in the group of its name, not around it
        "c/mount/three": (),
        "c/four": (MOUNT, SPEED),
    }, outer=["speed"])  # fmt: skip
    assert names == {
        "a/one": ("order", "mode_2"),
        "a/deep/two": ("order", "order_2"),
        "a/deep/mode": (),
        "b/mount/three": ("mount", "speed_2"),
        "c/mount/three": (),
        "c/four": ("mount_2", "speed_2"),
    }
