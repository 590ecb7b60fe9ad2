"""One environment as a row of the table in tests/matrix/ENVIRONMENTS.md."""

from dataclasses import dataclass

from environments import ROOT

PAGE = ROOT / "tests" / "matrix" / "ENVIRONMENTS.md"
START, END = "<!-- matrix: written by tests/matrix/run.py -->", "<!-- end of matrix -->"


@dataclass(frozen=True, kw_only=True)
class Line:
    """What one environment gave; the defaults are those of a Python that is not there."""

    name: str
    date: str
    python: str
    numpy: str = ""
    scipy: str = ""
    h5py: str = ""
    kernel: str = ""
    wider: str = ""
    threads: int = 0
    same: int = 0
    differ: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    worst: float = 0.0
    where: str = ""
    tests: str = ""

    @property
    def fine(self) -> bool:
        """Nothing differs, failed or was left out."""
        return self.same > 0 and not self.differ and not self.failed and "passed" in self.tests

    def as_row(self) -> str:
        """The row, in Markdown."""
        differ = f"{len(self.differ)}" + (f" ({', '.join(self.differ)})" if self.differ else "")
        failed = f"{len(self.failed)}" + (f" ({', '.join(self.failed)})" if self.failed else "")
        cells = (self.name, self.date, self.python, self.numpy, self.scipy, self.h5py)
        cells += (self.kernel, self.wider or "none")
        ran = self.same or self.differ or self.failed
        numbers = (self.threads, self.same, differ, failed, f"{self.worst:.2g}", self.where)
        shown = numbers if ran else ("", "", "", "", "", "")
        return "| " + " | ".join(str(cell) for cell in (*cells, *shown, self.tests)) + " |"


def record(line: Line) -> None:
    """Put the row where the environment has one, or behind the others."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(START)
    table, after = rest.split(END)
    rows = [row for row in table.strip().splitlines() if not row.startswith(f"| {line.name} |")]
    table = "\n".join([*rows, line.as_row()])
    PAGE.write_text(f"{before}{START}\n{table}\n{END}{after}", encoding="utf-8")
