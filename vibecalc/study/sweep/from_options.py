"""What the command line says of a sweep, as overrides of the table `[sweep]` of a case."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from vibecalc.study.sweep.specs import axis_tables, sampling_table


def sweep_settings(
    grid: Sequence[str], zipped: Sequence[str], sample: str | None, keep: Sequence[str]
) -> list[str]:
    """Texts `key=value`, as `--set` takes them; UsageError for one that cannot be read.

    Axes on the command line take the place of those of the case, and so do kept quantities.
    """
    settings = []
    tables = axis_tables(grid, zipped)
    if tables:
        # one by one, since each text of an override has its longest length
        settings.append(f"sweep.axes=[{', '.join(['{}'] * len(tables))}]")
        settings += [f"sweep.axes[{i}]={_toml(table)}" for i, table in enumerate(tables)]
    if sample is not None:
        settings += [f"sweep.{key}={_toml(value)}" for key, value in sampling_table(sample).items()]
    if keep:
        settings.append(f"sweep.keep={_toml(list(keep))}")
    return settings


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_toml(one)}' for key, one in value.items())} }}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)
