"""The environments that a result has to agree across, and how one is made."""

import hashlib
import json
import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: what the quick tests need next to vibecalc
TOOLS = ("pytest", "pytest-timeout", "hypothesis", "mpmath", "threadpoolctl")

_VERSIONS = """
import json, platform, h5py, numpy, scipy.linalg, threadpoolctl
from numpy._core._multiarray_umath import __cpu_dispatch__ as more, __cpu_features__ as has
kernels = {part["architecture"] for part in threadpoolctl.threadpool_info()}
wider = [name for name in more if has.get(name)]
print(json.dumps({"python": platform.python_version(), "numpy": numpy.__version__,
                  "scipy": scipy.__version__, "kernel": ", ".join(sorted(kernels)),
                  "wider": " ".join(wider),
                  "h5py": f"{h5py.__version__} ({h5py.version.hdf5_version})"}))
"""


@dataclass(frozen=True, kw_only=True)
class Environment:
    """A Python, a file of versions (None: the newest that the index has) and BLAS threads.

    `kernel` is the one that OpenBLAS shall take in place of the machine's own; a `narrow` numpy
    does without the instructions that it has beyond its baseline.
    """

    name: str
    python: str
    constraints: str | None
    threads: int = 1
    kernel: str = ""
    narrow: bool = False

    @property
    def folder(self) -> str:
        """Environments of the same versions are one."""
        return f"{self.python}_{Path(self.constraints or 'newest').stem}"


ENVIRONMENTS = (
    Environment(name="two threads", python="3.11", constraints="constraints.txt", threads=2),
    Environment(name="oldest", python="3.11", constraints="tests/matrix/oldest.txt"),
    Environment(name="python 3.12", python="3.12", constraints="constraints.txt"),
    Environment(name="newest", python="3.13", constraints=None),
    Environment(name="own kernel", python="3.11", constraints="constraints.txt"),
    *(
        Environment(name=kernel, python="3.11", constraints="constraints.txt", kernel=kernel)
        for kernel in ("Nehalem", "Haswell")
    ),
    Environment(name="narrow numpy", python="3.11", constraints="constraints.txt", narrow=True),
)
#: kernels of OpenBLAS for one processor or another, those that name themselves otherwise, and those
#: of processors that have no wider instructions for numpy
KERNELS = ("SkylakeX", "Sandybridge", "Prescott", "Haswell", "Zen", "Nehalem")
RUNS_AS = {"Prescott": "Katmai", "Zen": "Haswell"}
NARROW = ("Sandybridge", "Prescott", "Nehalem")


def runs_as(kernel: str, found: str) -> bool:
    """Whether the kernels that threadpoolctl found, "one, another", are all this one."""
    return set(found.split(", ")) <= {kernel, RUNS_AS.get(kernel, kernel)}


def find_python(version: str) -> Path | None:
    """An interpreter `version` (as in 3.12) on the path or of pyenv; None where there is none."""
    found = shutil.which(f"python{version}")
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    candidates = [Path(found)] if found else []
    candidates += sorted(pyenv.glob(f"{version}.*/bin/python"), reverse=True)
    return next((path for path in candidates if _is_version(path, version)), None)


def _is_version(python: Path, version: str) -> bool:
    """A launcher of pyenv is on the path for versions that it then refuses to start."""
    reported = subprocess.run([python, "--version"], capture_output=True, text=True, check=False)
    return reported.returncode == 0 and reported.stdout.startswith(f"Python {version}.")


def make(environment: Environment, interpreter: Path, folder: Path) -> Path:
    """A virtual environment in `folder` with vibecalc in it; returns its Python.

    One that is there already is brought to the versions asked for, if they have changed.
    CalledProcessError where pip cannot.
    """
    python, stamp = folder / "bin" / "python", folder / "matrix.stamp"
    asked = _asked(environment)
    if stamp.exists() and stamp.read_text(encoding="utf-8") == asked:
        return python
    if not python.exists():
        subprocess.run([interpreter, "-m", "venv", folder], check=True)
    chosen = ["-c", str(ROOT / environment.constraints)] if environment.constraints else ["-U"]
    quiet = ["--quiet", "--disable-pip-version-check"]
    install = [python, "-m", "pip", "install", *quiet]
    subprocess.run([*install, *chosen, "-e", f"{ROOT}[plot]", *TOOLS], check=True)
    stamp.write_text(asked, encoding="utf-8")
    return python


def _asked(environment: Environment) -> str:
    """What an environment is made from, in short; the newest versions are new every day."""
    pages = ["pyproject.toml", *([environment.constraints] if environment.constraints else [])]
    texts = [(ROOT / page).read_text(encoding="utf-8") for page in pages]
    day = "" if environment.constraints else time.strftime("%Y-%m-%d")
    return hashlib.sha256("\n".join([*texts, *TOOLS, day]).encode()).hexdigest()


def versions(python: Path, around: dict[str, str]) -> dict[str, str]:
    """What the numbers may hang on: versions, kernels of BLAS that run, wider instructions."""
    reported = subprocess.run(
        [python, "-c", _VERSIONS], env=around, capture_output=True, text=True, check=True
    )
    found: dict[str, str] = json.loads(reported.stdout)
    return found


def surroundings(environment: Environment, python: Path) -> dict[str, str]:
    """Environment variables of a run; RuntimeError where another kernel runs than was asked."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    fixed = {**dict.fromkeys(names, str(environment.threads)), "PYTHONPATH": str(ROOT)}
    around = {**os.environ, **fixed}
    if environment.kernel:
        around["OPENBLAS_CORETYPE"] = environment.kernel
    if environment.narrow:
        around["NPY_DISABLE_CPU_FEATURES"] = versions(python, around)["wider"]
    found = versions(python, around)
    other = environment.kernel and not runs_as(environment.kernel, found["kernel"])
    if other or (environment.narrow and found["wider"]):
        raise RuntimeError(
            f"{environment.name}: BLAS runs as {found['kernel']}, numpy with {found['wider']}"
        )
    return around
