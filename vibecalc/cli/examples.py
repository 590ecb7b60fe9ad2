"""What the help page of a command shows of its use: one line to type, one to say what it does."""

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "run": (
        ("vibecalc run case.toml", "result and report into outputs/, a summary on the screen"),
        ("vibecalc run case.toml --set machine.speed='\"3000 rpm\"'", "with another speed"),
        ("vibecalc run case.toml --if-needed", "only where case, files or settings have changed"),
    ),
    "check": (("vibecalc check case.toml", "every mistake with its line, or what a run would do"),),
    "verify": (("vibecalc verify case.toml", "for CI: exit 1 if a limit is broken"),),
    "report": (
        ("vibecalc report outputs/case.h5 --full", "all orders, references, errors and methods"),
        ("vibecalc report outputs/case.h5 --html", "a page with pictures next to the file"),
    ),
    "diff": (("vibecalc diff golden.h5 outputs/case.h5", "the golden file first"),),
    "plot": (
        ("vibecalc plot outputs/case.h5 --only run_up --format svg", "one picture, as a drawing"),
    ),
    "new": (
        ("vibecalc new list", "the kinds of machine"),
        ("vibecalc new generator -o mine.toml", "a case with all possible keys"),
        ("vibecalc new engine -o engine.toml --schema", "and the schema for editors next to it"),
        ("vibecalc new --example generator", "a shipped case with its files, ready to run"),
        ("vibecalc new --example", "names and titles of the shipped cases"),
    ),
    "schema": (
        ("vibecalc schema -o cases/", "cases/vibecalc.schema.json, as named in starters"),
        ("vibecalc schema --kind engine -o cases/", "with the tables for engines only"),
    ),
    "sweep": (
        (
            "vibecalc sweep case.toml --grid 'machine.speed=2000 rpm:4000 rpm:3' -j 2",
            "three speeds, two processes",
        ),
        ("vibecalc sweep case.toml --grid machine.mounts.each.damping=40,60 --dry-run", "the time"),
    ),
    "merge": (("vibecalc merge part1.h5 part2.h5 -o whole.h5", "of sweep --shard 1/2 and 2/2"),),
    "accuracy": (("vibecalc accuracy case.toml --longest 2", "each method, in 2 seconds"),),
    "info": (("vibecalc info outputs/case.h5", "quantities with unit, axes and size"),),
    "get": (
        (
            "vibecalc get outputs/case.h5 isolation/support_force/steady_peak --where mount=1",
            "one number",
        ),
        (
            "vibecalc get outputs/case.h5 isolation/support_force/run_up --where mount=1",
            "rows for a spreadsheet",
        ),
    ),
    "export": (
        ("vibecalc export outputs/case.h5 isolation --mat -o tables", "a group, for MATLAB"),
        ("vibecalc export line.toml -o line.json", "a shaft line, for openTorsion"),
    ),
    "migrate": (
        ("vibecalc migrate case.toml", "rename keys and results of earlier versions"),
        ("vibecalc migrate case.toml -o new.toml", "keep the original case"),
    ),
    "completion": (
        ("vibecalc completion bash >> ~/.bashrc", "bash; zsh, fish, powershell likewise"),
    ),
    "help": (("vibecalc help run", "the same as vibecalc run --help"),),
}
