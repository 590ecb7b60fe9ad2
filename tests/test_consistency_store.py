"""Claim: other programs read our files: dimension scales of h5py, h5dump, trees of xarray."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from h5py import h5ds
from long_but import long_but
from sample_results import DIRECTION, MODE, MOUNT, ORDER, SPEED, quantity, result_of
from shipped_cases import ROOT

import vibecalc
from vibecalc.core.results.dimensions import dimension_names
from vibecalc.core.results.store import write_result
from vibecalc.core.results.store_read import _is_as_written
from vibecalc.core.results.sweep_file import is_sweep


@pytest.fixture
def written(tmp_path: Path) -> Path:
    made = result_of(
        quantity("isolation/support_force/steady", (MOUNT, DIRECTION, ORDER), is_complex=True),
        quantity("isolation/run_up", (MOUNT, SPEED), amplitude="0-pk", standard_error=0.5),
        quantity("isolation/lever", ()),
    )
    return write_result(made, tmp_path / "r.h5")


def test_attributes_are_plain_text_and_numbers(written: Path) -> None:
    with h5py.File(written) as file:
        attributes = dict(file["isolation/run_up"].attrs)
        assert attributes["units"] == "N"
        assert attributes["long_name"] == "isolation/run_up in words"
        assert attributes["amplitude"] == "0-pk"
        assert attributes["error_estimate"] == 1e-13
        assert attributes["standard_error"] == 0.5
        assert file.attrs["vibecalc_version"] == "0.1.0"
        assert file.attrs["schema_version"] == 1
        assert file.attrs["case_toml"].endswith('speed = "513 rad/s"\n')
        assert file["provenance"].attrs["host"] == "here"
        assert file["provenance/timings"].attrs["excitation"] == 0.5


def test_dimension_scales_are_attached_and_named(written: Path) -> None:
    with h5py.File(written) as file:
        dataset = file["isolation/support_force/steady"]
        assert [dimension.label for dimension in dataset.dims] == ["mount", "direction", "order"]
        for position, name in enumerate(("mount", "direction", "order")):
            scale = file[f"isolation/support_force/{name}"]
            assert h5ds.is_scale(scale.id)
            assert h5ds.get_scale_name(scale.id) == name.encode()
            assert h5ds.is_attached(dataset.id, scale.id, position)
        assert file["isolation/speed"].attrs["units"] == "rad/s"
        assert file["isolation/mount"].asstr()[()].tolist() == MOUNT.values.tolist()
        assert dataset.dtype == np.complex128


@pytest.mark.skipif(shutil.which("h5dump") is None, reason="h5dump is not installed")
def test_h5dump_reads_it(written: Path) -> None:
    done = subprocess.run(
        ["h5dump", "-A", "-d", "/isolation/support_force/steady", str(written)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for words in ("DIMENSION_LIST", "H5T_COMPOUND", '"units"', '"error_estimate"'):
        assert words in done.stdout


def test_the_bytes_are_a_closed_file_of_hdf5_1_8(written: Path) -> None:
    """Some versions hand out an image of an open file whose first block fails its own checksum.

    `make matrix` tries the versions that vibecalc supports.
    """
    image = written.read_bytes()
    assert image[:8] == b"\x89HDF\r\n\x1a\n"
    assert image[8] == 2  # superblock of HDF5 1.8, the one with a checksum
    assert image[11] == 0  # flags of a file that somebody has open
    end_of_file = int.from_bytes(image[28:36], "little")
    assert end_of_file == len(image)  # nothing is missing at the end, nothing hangs over it
    with h5py.File(written) as file:
        # the checksum of the texts is that of the finished file
        assert _is_as_written(file, written)


# ----------------------------------------------------------------------------
# Trees of xarray.
# ----------------------------------------------------------------------------

GOLDEN = {path.name: path for path in sorted((ROOT / "tests" / "golden").glob("*.h5"))}
#: an axis with the name of a group, of a quantity in its group and below it, and all three
KEPT = ("absorber_two.h5", "generator_mount_fit.h5", "roll.h5")


def same(tree: Any, result: vibecalc.Result) -> None:
    for path, one in result.items():
        array = tree[path]
        assert type(array).__name__ == "DataArray" and array.attrs["units"] == one.unit, path
        assert array.shape == one.values.shape, path
        if one.values.dtype.kind in "OTU":
            assert array.values.ravel().tolist() == one.values.ravel().tolist(), path
        else:
            assert np.array_equal(array.values, one.values, equal_nan=True), path
        for name, axis in zip(array.dims, one.axes, strict=True):
            assert name == axis.name or str(name).startswith(f"{axis.name}_"), path
            labels = array.coords[name].values
            assert list(map(str, labels)) == list(map(str, axis.values)), (path, name)


@pytest.mark.parametrize("name", long_but(GOLDEN, *KEPT))
def test_every_shipped_result_is_a_tree(name: str, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
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
