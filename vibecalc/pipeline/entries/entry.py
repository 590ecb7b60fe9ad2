"""What is known of a quantity before it is computed."""

from typing import NamedTuple

PEAK = "0-pk"
RMS = "rms"


class Entry(NamedTuple):
    """Path, axes, unit, long name and kind of amplitude of one quantity."""

    path: str
    axes: tuple[str, ...]
    unit: str
    long_name: str
    amplitude: str | None = None


def entry(path: str, axes: str, unit: str, long_name: str, amplitude: str | None = None) -> Entry:
    """An entry whose axes are written as one text with blanks between."""
    return Entry(path, tuple(axes.split()), unit, long_name, amplitude)
