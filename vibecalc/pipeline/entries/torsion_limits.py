"""Results of a shaft line against limits, section by section, and barred ranges by formula.

The section axis holds the shafts that some limit is for; a value is 0 where a limit is not for the
section, or has no such number.
"""

from vibecalc.pipeline.entries.entry import entry

ROOT = "response/torsion"
_EACH = "limit section"
_HERE = "at the operating speed"

ENTRIES = (
    entry(f"{ROOT}/limit/basis/rated_speed", "limit", "rad/s", "that a rule counts from"),
    entry(f"{ROOT}/limit/basis/diameter", _EACH, "m", "outer, of the stressed section"),
    entry(f"{ROOT}/limit/basis/tensile_strength", _EACH, "Pa", "of the material, as given"),
    entry(f"{ROOT}/limit/basis/counted_strength", _EACH, "Pa", "as a rule counts it"),
    entry(f"{ROOT}/limit/basis/size_factor", _EACH, "", "c_D of a rule"),
    entry(f"{ROOT}/limit/basis/design_factor", _EACH, "", "c_K of a rule"),
    entry(f"{ROOT}/limit/operating/stress", _EACH, "Pa", f"half range of all orders, {_HERE}"),
    entry(f"{ROOT}/limit/operating/allowed", _EACH, "Pa",
          f"for lasting, {_HERE}; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/operating/transient", _EACH, "Pa",
          f"for passing through, {_HERE}; infinite where the limit has none"),
    entry(f"{ROOT}/limit/operating/use", _EACH, "", f"stress over allowed for lasting, {_HERE}"),
    entry(f"{ROOT}/limit/each/use", _EACH, "", "largest stress over allowed, at any speed"),
    entry(f"{ROOT}/limit/each/speed", _EACH, "rad/s", "where that is"),
    entry(f"{ROOT}/limit/each/speed_ratio", _EACH, "", "lambda: that speed over the rated one"),
    entry(f"{ROOT}/limit/each/stress", _EACH, "Pa", "there"),
    entry(f"{ROOT}/limit/each/allowed", _EACH, "Pa",
          "for lasting, there; infinite where the limit says nothing"),
    entry(f"{ROOT}/limit/each/transient", _EACH, "Pa",
          "for passing through, there; infinite where the limit has none"),
    entry(f"{ROOT}/limit/each/transient_use", _EACH, "",
          "largest stress over the one for passing through, at any speed; 0: the limit has none"),
    entry(f"{ROOT}/exceeded/peak_speed", "exceeded", "rad/s",
          "of the largest use inside the range"),
    entry(f"{ROOT}/exceeded/formula_from", "exceeded", "rad/s",
          "16 n_c / (18 - lambda) of the rule, n_c the peak; 0: a limit without such a formula"),
    entry(f"{ROOT}/exceeded/formula_to", "exceeded", "rad/s",
          "(18 - lambda) n_c / 16 of the rule"),
    entry(f"{ROOT}/exceeded/permitted", "exceeded", "",
          "0: the rule lets no range be barred there, from lambda = 0.8 on; 1: it does"),
)  # fmt: skip
