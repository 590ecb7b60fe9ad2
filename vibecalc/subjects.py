"""Every subject, by the name of its folder, in the order of a run: a new one is entered here."""

SUBJECTS = (
    "body",
    "kinematics",
    "excitation",
    "balance",
    "response",
    "impact",
    "torsion",
    "roll",
    "isolation",
    "foundation",
    "points",
    "base_motion",
    "bearings",
    "measurement",
    "absorber",
)
