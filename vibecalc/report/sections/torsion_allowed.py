"""What each section of a shaft line bears, and may bear, by each limit of the stress."""

import numpy as np

from vibecalc.report.lookup import having, labels, speed_of
from vibecalc.report.numbers import show
from vibecalc.report.sections.torsion_terms import MEGA, TORSION, short, turns, vector
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

_LIMIT = TORSION + "limit/"
_BASIS = (("diameter", "diameter\nmm", 1e3), ("tensile_strength", "sigma_B\nN/mm^2", MEGA),
          ("counted_strength", "as counted\nN/mm^2", MEGA), ("design_factor", "c_K", 1.0),
          ("size_factor", "c_D", 1.0))  # fmt: skip


def torsion_allowed(result: Result) -> list[str]:
    """Lines of both tables, none where the result does not have them."""
    lines: list[str] = []
    for block in (_basis(result.record), _uses(result)):
        lines += ["", *block] if lines and block else block
    return lines


def _matrix(record: Record, name: str) -> np.ndarray | None:
    quantity = having(record, _LIMIT + name, "limit", "section")
    return None if quantity is None else np.asarray(quantity.values, dtype=float)


def _sections(record: Record) -> list[str]:
    quantity = having(record, _LIMIT + "operating/use", "limit", "section") or having(
        record, _LIMIT + "each/use", "limit", "section"
    )
    return [] if quantity is None else labels(quantity.axes[1])


def _held(record: Record) -> np.ndarray | None:
    """Which sections a limit is for: those with a diameter in its basis."""
    wide = _matrix(record, "basis/diameter")
    return None if wide is None else wide > 0.0


def _basis(record: Record) -> list[str]:
    """Diameter, strength and factors behind the rule of each section."""
    held, rated = _held(record), vector(record, "limit/basis/rated_speed", "limit")
    if held is None or rated is None:
        return []
    parts = [_matrix(record, f"basis/{name}") for name, _, _ in _BASIS]
    named = _sections(record)
    columns = [number("limit", 5), Column("section", 20)]
    columns += [number(title, 10) for _, title, _ in _BASIS]
    columns += [number("rated speed\nrpm", 11)]
    rows = []
    for i, j in np.argwhere(held):
        if not rated[i] or j >= len(named):
            continue
        cells = [
            "" if part is None or not part[i, j] else short(factor * part[i, j])
            for part, (_, _, factor) in zip(parts, _BASIS, strict=True)
        ]
        rows.append([str(i + 1), named[j], *cells, turns(rated[i])])
    if not rows:
        return []
    words = (
        "Allowed stress by the rule: tau_C = (sigma_B + 160) / 18 c_K c_D (3 - 2 lambda^2), for "
        "lambda of 0.9 and more 1.38 in place of the bracket; tau_T = 1.7 tau_C / sqrt(c_K) for "
        "passing through; c_D = 0.35 + 0.93 d^-0.2; lambda: speed over the rated one, for which "
        "the operating speed is taken. Stresses in N/mm^2, d in mm."
    )
    return [*paragraph(words), *table(columns, rows)]


def _uses(result: Result) -> list[str]:
    """Stress, what is allowed, and use of each section: where the use is largest, and operating."""
    record = result.record
    held, named = _held(record), _sections(record)
    if held is None or not named:
        return []
    rated = vector(record, "limit/basis/rated_speed", "limit")
    running = speed_of(result)
    columns = [number("limit", 5), Column("section", 20), Column("", 9), number("rpm", 8),
               number("lambda", 6), number("stress", 8), number("lasting\nallowed", 8),
               number("passing\nallowed", 8), number("use\n%", 7),
               number("passing\nuse, %", 8)]  # fmt: skip
    rows = []
    for i, j in np.argwhere(held):
        if j >= len(named):
            continue
        for way, words in (("each", "any speed"), ("operating", "operating")):
            use = _matrix(record, f"{way}/use")
            if use is None:
                continue
            at = _matrix(record, "each/speed") if way == "each" else None
            speed = float(at[i, j]) if at is not None else running
            ratio = speed / rated[i] if speed and rated is not None and rated[i] else 0.0
            stress, allowed, passing = (
                _matrix(record, f"{way}/{name}") for name in ("stress", "allowed", "transient")
            )
            over = _matrix(record, "each/transient_use") if way == "each" else None
            rows.append([
                str(i + 1), named[j], words, turns(speed) if speed and use[i, j] else "",
                f"{ratio:.3f}" if ratio and use[i, j] else "", _stress(stress, i, j, "no bound"),
                _stress(allowed, i, j), _stress(passing, i, j), _percent(use[i, j]),
                _percent(over[i, j]) if over is not None and over[i, j] else "",
            ])  # fmt: skip
    words = (
        "Half range of the stress in each section, and what is allowed for lasting operation and "
        "for passing through, in N/mm^2. Use: over what is allowed for lasting, at the speed of "
        "largest use and at the operating one; passing use: the largest over what is allowed for "
        "passing, at any speed. -: the limit says nothing."
    )
    return [*paragraph(words), *table(columns, rows)] if rows else []


def _percent(use: float) -> str:
    return show(100.0 * use, digits=4) if np.isfinite(use) else "above"


def _stress(values: np.ndarray | None, i: int, j: int, endless: str = "-") -> str:
    if values is None:
        return ""
    value = float(values[i, j])
    if not np.isfinite(value):
        return endless
    return show(MEGA * value, digits=4) if value else "-"
