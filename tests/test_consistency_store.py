"""Claim: other programs read our files: h5py's dimension scales, netCDF rules, h5dump."""

import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from h5py import h5ds
from sample_results import DIRECTION, MOUNT, ORDER, SPEED, quantity, result_of

from vibecalc.core.results.store import write_result


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


def test_readers_of_hdf5_1_8_have_the_format(written: Path) -> None:
    content = written.read_bytes()
    assert content[:8] == b"\x89HDF\r\n\x1a\n"
    assert content[8] == 2  # superblock of HDF5 1.8, the one with a checksum
