"""Where times were measured: threads of the linear algebra, processor, versions."""

import os
import platform
import re
import sys
from importlib.metadata import version
from pathlib import Path

#: what OpenBLAS, OpenMP and MKL read when numpy is imported
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def pin_threads() -> str:
    """One thread for linear algebra, asked for before numpy is imported; what was found, in words.

    The libraries read these variables once. Where numpy is there already, they are left alone.
    """
    found = ", ".join(f"{name}={os.environ.get(name, 'not set')}" for name in THREADS)
    if "numpy" in sys.modules:
        return f"numpy was there already, with {found}"
    os.environ.update(dict.fromkeys(THREADS, "1"))
    return f"1 (found {found})"


def machine() -> str:
    """Model of the processor and how many of them the system shows."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    model = re.search(r"^(?:model name|Model|cpu model)\s*:\s*(\S.*)$", text, re.MULTILINE)
    name = " ".join(model[1].split()) if model else platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count() or 1} cores"


def versions() -> str:
    """Of Python, numpy, scipy, mpmath and vibecalc."""
    from vibecalc import __version__

    packages = [f"{name} {version(name)}" for name in ("numpy", "scipy", "mpmath")]
    return ", ".join((f"python {platform.python_version()}", *packages, f"vibecalc {__version__}"))
