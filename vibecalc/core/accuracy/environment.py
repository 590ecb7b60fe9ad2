"""Where times were measured: threads of the linear algebra, processor, versions."""

import os
import platform
import sys
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
    for name in THREADS:
        os.environ[name] = "1"
    return f"1 (found {found})"


def machine() -> str:
    """Model of the processor and how many of them the system shows."""
    return f"{_model()}, {os.cpu_count() or 1} cores"


def versions() -> str:
    """Of Python, numpy, scipy, mpmath and vibecalc."""
    import mpmath
    import numpy
    import scipy

    from vibecalc import __version__

    parts = {
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "mpmath": mpmath.__version__,
        "vibecalc": __version__,
    }
    return ", ".join(f"{name} {version}" for name, version in parts.items())


def _model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    for line in lines:
        name, _, value = line.partition(":")
        if name.strip() in ("model name", "Model", "cpu model") and value.strip():
            return " ".join(value.split())
    return platform.processor() or platform.machine()
