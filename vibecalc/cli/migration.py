"""The command that rewrites cases of earlier versions."""

from pathlib import Path

import typer

from vibecalc.cli.saying import answer
from vibecalc.errors import UsageError


def migrate(
    cases: list[Path] = typer.Argument(metavar="CASE", help="Case files (TOML)."),
    output: Path | None = typer.Option(
        None, "--output", "-o", help="File to write; default: the case itself, in place."
    ),
) -> None:
    """Rewrite cases of earlier versions with the current names of keys and results."""
    from vibecalc.core.case.migrate import migrate as migrated
    from vibecalc.core.results.files import write_together

    if output is not None and len(cases) > 1:
        raise UsageError("-o names the file for one case")
    if output is None and Path("-") in cases:
        raise UsageError("a case from standard input needs -o")
    found = [(migrated(case), output or case) for case in cases]
    files: dict[Path, bytes] = {}
    for one, target in found:
        if one.renamings or output is not None:
            files[target] = one.text.encode("utf-8")
        for name, text in one.files.items():
            files[target.parent / name] = text.encode("utf-8")
    write_together(list(files.items()))

    def words() -> str:
        lines = []
        for one, _ in found:
            lines += [f"{row.file}:{row.line}: {row.old} -> {row.new}" for row in one.renamings]
            if not one.renamings:
                lines.append(f"{one.path} is up to date")
        return "\n".join([*lines, *(f"wrote {path}" for path in files)])

    answer(
        lambda: {
            "renamed": [row._asdict() for one, _ in found for row in one.renamings],
            "written": [str(path) for path in files],
        },
        words,
    )
