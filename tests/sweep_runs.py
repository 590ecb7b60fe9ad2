"""Real runs of `vibecalc sweep`, and the objects of their files."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py

from vibecalc.core.study.sweep.journal import records

CASES = Path(__file__).resolve().parents[1] / "cases"
GENERATOR = CASES / "generator.toml"
#: 96 points of some 10 ms, in 16 chunks
GRID = (
    "--grid", "machine.mounts.each.stiffness=5 N/mm:50 N/mm:16log",
    "--grid", "isolation.run_up.to=2000 rpm:5000 rpm:6",
    "--keep", "isolation/couple_over_lever/run_up_peak",
    "--keep", "isolation/support_force/steady_peak",
    "--keep", "isolation/couple_over_lever/blocked_harmonics",
)  # fmt: skip


def started(*arguments: object, **options: Any) -> "subprocess.Popen[str]":
    """`vibecalc sweep` in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "vibecalc", "sweep", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options,
    )  # fmt: skip


def killed(sweep: "subprocess.Popen[str]", how: signal.Signals = signal.SIGKILL) -> str:
    """End a sweep, and return what it said on stderr."""
    sweep.send_signal(how)
    return sweep.communicate(timeout=60)[1]


def finished_chunks(output: Path) -> dict[int, tuple[int, int]]:
    """Finished chunks in the journal next to an output: where each stands, and its length."""
    try:
        found = list(records(output.with_name(f"{output.name}.chunks")))
    except FileNotFoundError:
        return {}
    return {number: (place, length) for number, place, length in found}


def objects(path: Path) -> dict[str, Any]:
    """Everything in a file outside `/provenance`, bit by bit; links to objects by their names."""
    found: dict[str, Any] = {}
    with h5py.File(path) as file:

        def content(value: Any) -> Any:
            if isinstance(value, h5py.Reference):
                return file[value].name
            if getattr(value, "dtype", None) is not None and value.dtype.kind in "OV":
                if value.dtype.names:
                    return [[content(part) for part in row] for row in value]
                return [content(part) for part in value.ravel()]
            if hasattr(value, "tobytes"):
                return value.dtype.str, value.shape, value.tobytes()
            return [content(one) for one in value] if isinstance(value, list) else value

        def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
            if name.split("/")[0] == "provenance":
                return
            found[name] = type(item).__name__
            if isinstance(item, h5py.Dataset):
                found[f"{name}:"] = (item.dtype.str, item.shape, item.chunks, content(item[()]))
            for key in item.attrs:
                found[f"{name}@{key}"] = content(item.attrs[key])

        file.visititems(visit)
        found |= {f"@{key}": content(file.attrs[key]) for key in file.attrs}
    return found
