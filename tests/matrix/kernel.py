"""Runs a command with another BLAS kernel than this processor's: `kernel.py NAME COMMAND...`.

NAME is one of `KERNELS`, "commit" for one that the hash of the commit chooses, or "own".
"""

import subprocess
import sys
from pathlib import Path

from environments import (
    KERNELS,
    NARROW,
    ROOT,
    RUNS_AS,
    Environment,
    runs_as,
    surroundings,
    versions,
)

#: calls that reach the wider instructions of a kernel; a processor without them stops there
_PROBE = """
import numpy, scipy.linalg
for count in (3, 17, 130):
    a = numpy.arange(count * count * 1.0).reshape(count, count) % 7.0 + 9.0 * numpy.eye(count)
    for one in (a, a + 1j * a.T):
        numpy.linalg.svd(one @ one), numpy.linalg.eig(one), numpy.linalg.solve(one, one)
        scipy.linalg.eigh(one @ one.T.conj()), scipy.linalg.lu_factor(one)
"""


def environment_of(kernel: str) -> Environment:
    """A kernel with the numpy of the processors that it is made for."""
    return Environment(
        name=kernel, python="", constraints=None, kernel=kernel, narrow=kernel in NARROW
    )


def why_not(kernel: str, python: Path) -> str:
    """Why this processor cannot run a kernel; empty where it can."""
    try:
        around = surroundings(environment_of(kernel), python)
    except RuntimeError as error:
        return str(error)
    probe = subprocess.run([python, "-c", _PROBE], env=around, capture_output=True, check=False)
    return f"{kernel}: its instructions stop with {probe.returncode}" if probe.returncode else ""


def chosen_by(commit: str, own: str, python: Path) -> str:
    """A kernel that the processor can run, not its own; RuntimeError where there is none."""
    others = [kernel for kernel in KERNELS if not runs_as(kernel, own)]
    reasons = {kernel: why_not(kernel, python) for kernel in others}
    able = [kernel for kernel, reason in reasons.items() if not reason]
    for reason in filter(None, reasons.values()):
        print(f"left out: {reason}")
    if not able:
        raise RuntimeError(f"no other BLAS kernel than {own} runs on this processor")
    return able[int(commit, 16) % len(able)]


def main(name: str, command: list[str]) -> int:
    """Exit code of the command; 1 where the kernel cannot run."""
    python = Path(sys.executable)
    own = versions(python, surroundings(environment_of(""), python))["kernel"]
    try:
        if name == "commit":
            asked = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
            commit = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
            name = chosen_by(commit, own, python)
        kernel = "" if name == "own" else name
        if kernel and kernel not in KERNELS:
            raise RuntimeError(f"{kernel} is none of {', '.join(KERNELS)}")
        if kernel and (reason := why_not(kernel, python)):
            raise RuntimeError(reason)
        around = surroundings(environment_of(kernel), python)
    except RuntimeError as error:
        print(error)
        return 1
    found = versions(python, around)
    as_another = f" (for {kernel})" if kernel in RUNS_AS else ""
    wider = found["wider"] or "no wider instructions"
    print(f"BLAS kernel {found['kernel']}{as_another}, numpy with {wider}", flush=True)
    return subprocess.run(command, env=around, check=False).returncode if command else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
