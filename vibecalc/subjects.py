"""Every subject, by the name of its folder, in the order of a run: a new one is entered here."""

SUBJECTS = (
    "kinematics",
    "excitation",
    "response",
    "impact",
    "torsion",
    "roll",
    "isolation",
    "foundation",
    "bearings",
    "measurement",
    "absorber",
)
