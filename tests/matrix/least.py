"""Runs a command as the least processor computes: `python tests/matrix/least.py make golden`."""

import subprocess
import sys
from pathlib import Path

from environments import LEAST, surroundings, versions

if __name__ == "__main__":
    own = Path(sys.executable)
    around = surroundings(LEAST, own)
    print(f"BLAS kernel {versions(own, around)['kernel']}, numpy without wider instructions")
    sys.exit(subprocess.run(sys.argv[1:], env=around, check=False).returncode)
