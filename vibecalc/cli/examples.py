"""What the help page of a command shows of its use: one line to type, one to say what it does."""

_LINES = r"""
vibecalc run case.toml | result and report into outputs/, a summary on the screen
vibecalc run case.toml --set machine.speed='"3000 rpm"' | with another speed
vibecalc run case.toml --if-needed | only where case, files or settings have changed
vibecalc check case.toml | every mistake with its line, or what a run would do
vibecalc verify case.toml | for CI: exit 1 if a limit is broken
vibecalc report outputs/case.h5 --full | all orders, references, errors and methods
vibecalc report outputs/case.h5 --html | a page with pictures next to the file
vibecalc diff golden.h5 outputs/case.h5 | the golden file first
vibecalc plot outputs/case.h5 --only run_up --format svg | one picture, as a drawing
vibecalc new list | the kinds of machine
vibecalc new generator -o mine.toml | a case with all possible keys
vibecalc new engine -o engine.toml --schema | and the schema for editors next to it
vibecalc new --example generator | a shipped case with its files, ready to run
vibecalc new --example | names and titles of the shipped cases
vibecalc schema -o cases/ | cases/vibecalc.schema.json, as named in starters
vibecalc schema --kind engine -o cases/ | with the tables for engines only
vibecalc sweep case.toml --grid 'machine.speed=2000 rpm:4000 rpm:3' -j 2|three speeds, two processes
vibecalc sweep case.toml --grid machine.mounts.each.damping=40,60 --dry-run | the time
vibecalc merge part1.h5 part2.h5 -o whole.h5 | of sweep --shard 1/2 and 2/2
vibecalc accuracy case.toml --longest 2 | each method, in 2 seconds
vibecalc info outputs/case.h5 | quantities with unit, axes and size
vibecalc get outputs/case.h5 isolation/support_force/steady_peak --where mount=1 | one number
vibecalc get outputs/case.h5 isolation/support_force/run_up --where mount=1 | rows for a spreadsheet
vibecalc export outputs/case.h5 isolation --mat -o tables | a group, for MATLAB
vibecalc export line.toml -o line.json | a shaft line, for openTorsion
vibecalc migrate case.toml | rename keys and results of earlier versions
vibecalc migrate case.toml -o new.toml | keep the original case
vibecalc completion bash >> ~/.bashrc | bash; zsh, fish, powershell likewise
vibecalc help run | the same as vibecalc run --help
"""

#: command -> lines with words
EXAMPLES: dict[str, list[tuple[str, str]]] = {}
for _line in _LINES.strip().splitlines():
    _typed, _, _words = _line.partition("|")
    EXAMPLES.setdefault(_typed.split()[1], []).append((_typed.strip(), _words.strip()))
