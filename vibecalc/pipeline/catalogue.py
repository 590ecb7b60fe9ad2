"""Every result path with its unit, axes, amplitude kind and long name: said once, here.

Adapters hand over arrays and errors under these paths; the file, the report, references, limits
and `check` read the rest from this table. The entries stand in `entries/`, a file for each group.
"""

from vibecalc.pipeline.entries import (
    excitation,
    impact,
    isolation,
    kinematics,
    response,
    switching,
)
from vibecalc.pipeline.entries.entry import Entry

#: axis name -> (unit, long name)
AXES: dict[str, tuple[str, str]] = {
    "order": ("", "multiple of crank speed"),
    "direction": ("", "axis of the machine"),
    "cylinder": ("", "cylinder"),
    "counterweight": ("", "counterweight"),
    "mount": ("", "mount"),
    "speed": ("rad/s", "crank speed"),
    "mode": ("", "mode, lowest first"),
    "other_mode": ("", "mode it is held against"),
    "coordinate": ("", "coordinate of the rigid body"),
    "crank_angle": ("rad", "crank angle"),
    "frequency_ratio": ("", "excitation frequency over natural frequency"),
    "masked": ("", "interval of speeds left out"),
    "operation": ("", "cylinders that work"),
    "balance": ("", "throws that weights cancel"),
    "change": ("", "from one operation to the other"),
    "instant_time": ("s", "end of an interval of time"),
    "reversal_time": ("s", "end of an interval of time"),
    "passage": ("", "meeting of an order and a mode, the first is 1"),
    "clearance": ("m", "clearance of the joint"),
    "contact": ("", "contact, the first is 1"),
}

_GROUPS = (kinematics, excitation, response, switching, impact, isolation)
CATALOGUE: dict[str, Entry] = {entry.path: entry for group in _GROUPS for entry in group.ENTRIES}
