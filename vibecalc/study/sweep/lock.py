"""One sweep for each output: a lock file that names who holds it."""

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from vibecalc.errors import UsageError
from vibecalc.results.files import temporary_name


def lock_path(output: Path) -> Path:
    """The lock file of an output."""
    return output.with_name(f"{output.name}.lock")


@contextmanager
def locked(output: Path) -> Iterator[str]:
    """Hold the lock of `output`, whose folder is there; the lock is removed on leaving.

    Gives a note to show if the lock of a dead process was taken over, otherwise "". UsageError if
    another sweep holds it, if nobody can tell (another host), or if it cannot be made.
    """
    path = lock_path(output)
    try:
        note, mine = _take(path, output)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot make the lock file {path}: {reason}") from error
    try:
        yield note
    finally:
        _release(path, mine)


def _take(path: Path, output: Path) -> tuple[str, int]:
    """Make the lock; returns a note and the inode of our lock file."""
    while True:
        # written first and linked then, so that no lock is ever seen without its content
        temporary = path.parent / temporary_name()
        temporary.write_text(json.dumps(_ourselves()), encoding="utf-8")
        try:
            inode = temporary.stat().st_ino
            try:
                os.link(temporary, path)
                return "", inode
            except FileExistsError:
                holder = _holder(path, output)
            if holder is not None and _take_over(path, temporary, holder):
                gone = f"process {holder['pid']} that was writing {output} is no more"
                return f"{gone}, its lock is taken over", inode
        finally:
            temporary.unlink(missing_ok=True)


def _holder(path: Path, output: Path) -> dict[str, Any] | None:
    """The dead process that left the lock, None if the lock is gone; UsageError if it is held."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return None
    try:
        holder = json.loads(text)
        pid, host, started = int(holder["pid"]), str(holder["host"]), str(holder["started"])
        if pid < 1:
            raise ValueError(pid)
    except (ValueError, KeyError, TypeError):
        raise UsageError(
            f"{path} does not say who holds it: remove it if no sweep writes {output}"
        ) from None
    if host != socket.gethostname():
        raise UsageError(
            f"{output} is locked by process {pid} on the host {host}, "
            f"from here nobody can tell if it still runs: remove {path} if it does not"
        )
    if _is_alive(pid, started):
        raise UsageError(f"another sweep, process {pid}, is writing {output}")
    return {"pid": pid, "text": text}


def _take_over(path: Path, temporary: Path, holder: dict[str, Any]) -> bool:
    """Put our lock in the place of a dead one; False if somebody else was faster."""
    import fcntl

    try:
        stream = open(path, encoding="utf-8", errors="replace")  # noqa: SIM115
    except FileNotFoundError:
        return False
    with stream:
        # of all who found the same dead lock, one at a time gets on
        fcntl.flock(stream, fcntl.LOCK_EX)
        try:
            same = os.fstat(stream.fileno()).st_ino == path.stat().st_ino
        except FileNotFoundError:
            return False
        if not same or stream.read() != holder["text"]:
            return False
        os.replace(temporary, path)
    return True


def _release(path: Path, inode: int) -> None:
    try:
        if path.stat().st_ino == inode:
            path.unlink()
    except OSError:
        return  # the folder is gone, and the lock with it


def _ourselves() -> dict[str, Any]:
    pid = os.getpid()
    return {"pid": pid, "host": socket.gethostname(), "started": _started(pid)}


def _is_alive(pid: int, started: str) -> bool:
    """Whether the process that made the lock still runs; its number may have been given again."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass  # it is there, and somebody else's
    now = _started(pid)
    return not (started and now and now != started)


def _started(pid: int) -> str:
    """When a process started, in the kernel's own count; "" where there is no telling."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        fields = Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:
        return ""
    return "ended" if fields[0] in "ZX" else f"{boot} {fields[19]}"
