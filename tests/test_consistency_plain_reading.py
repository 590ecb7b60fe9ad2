"""Claim: the bytes of a result are a closed HDF5 file that plain h5py opens and finds whole.

Some versions of HDF5 hand out an image of an open file whose first block fails its own checksum;
the versions that vibecalc supports are tried by `make matrix`, which runs this test in each.
"""

from pathlib import Path

import h5py
import numpy as np
from sample_results import MOUNT, SPEED, quantity, result_of

from vibecalc.core.results.store import file_image, read_result, write_result
from vibecalc.core.results.store_read import _is_as_written

#: first block of the format of HDF5 1.8: flags of a file that somebody has open
_FLAGS = 11


def test_a_result_opens_in_plain_h5py(tmp_path: Path) -> None:
    made = result_of(quantity("isolation/run_up", (MOUNT, SPEED), amplitude="0-pk"))
    path = write_result(made, tmp_path / "r.h5")
    with h5py.File(path, "r") as file:
        assert np.array_equal(file["isolation/run_up"][()], made.record["isolation/run_up"].values)
        assert file["isolation/speed"].attrs["units"] == "rad/s"
        # the checksum of the texts is that of the finished file
        assert _is_as_written(file, path)
    assert set(read_result(path).record) == set(made.record)


def test_the_image_is_that_of_a_closed_file() -> None:
    made = result_of(quantity("isolation/run_up", (MOUNT, SPEED)))
    image = file_image(made)
    assert image[_FLAGS] == 0
    end_of_file = int.from_bytes(image[28:36], "little")
    assert end_of_file == len(image)  # nothing is missing at the end, nothing hangs over it
    assert file_image(made) == image
