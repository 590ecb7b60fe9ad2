"""Results of what a tuning is built of: rod, springs, ring, gap, oils, stock, bending."""

from vibecalc.pipeline.entries.entry import entry

ROOT = "hardware"
_ON_PAIR = "stock_spring stock_oil"
_WITH_DAMPER = "stock_spring stock_damper"

ENTRIES = (
    entry(f"{ROOT}/rod_stiffness", "", "N*m/rad", "torsional stiffness of the rod"),
    entry(f"{ROOT}/ring_mass", "", "kg", "mass of the seismic ring"),
    entry(f"{ROOT}/ring_inertia", "", "kg*m^2", "inertia of the seismic ring about its axis"),
    entry(f"{ROOT}/primary_frequency", "", "rad/s", "natural frequency of the primary alone"),
    entry(f"{ROOT}/built/stiffness_ratio", "", "", "of the springs that are in, over the primary"),
    entry(f"{ROOT}/built/secondary_damping", "", "", "of the oil that is in, c2 / (2 sqrt(K1 J1))"),
    entry(f"{ROOT}/built/spring_rate", "", "N/m", "rate of each spring that is in"),
    entry(f"{ROOT}/built/peak", "", "", "largest response of the primary as built"),
    entry(f"{ROOT}/built/peak_frequency", "", "rad/s", "where that is"),
    entry(f"{ROOT}/spring_rate", "", "N/m", "rate of each spring that the tuning wants"),
    entry(f"{ROOT}/clearance", "", "m", "clearance of the gap at the rim"),
    entry(f"{ROOT}/gap/rim", "", "m^3", "damping over dynamic viscosity: at the rim"),
    entry(f"{ROOT}/gap/sides", "", "m^3", "at the sides"),
    entry(f"{ROOT}/gap/bore", "", "m^3", "in the bore"),
    entry(f"{ROOT}/dynamic_viscosity", "", "Pa*s", "viscosity that the tuning wants in the gap"),
    entry(f"{ROOT}/spring/rate", "stock_spring", "N/m", "rate of each spring"),
    entry(f"{ROOT}/spring/stiffness_ratio", "stock_spring", "", "what such springs give"),
    entry(f"{ROOT}/oil/kinematic_viscosity", "stock_oil", "m^2/s", "at the temperature of the gap"),
    entry(f"{ROOT}/oil/damping", "stock_oil", "N*m*s/rad", "what such an oil gives in the gap"),
    entry(f"{ROOT}/oil/secondary_damping", "stock_oil", "", "the same, c2 / (2 sqrt(K1 J1))"),
    entry(f"{ROOT}/oil/right_temperature", "stock_oil", "K",
          "at which it is as thick as the tuning wants; 0: never"),
    entry(f"{ROOT}/pair/peak", _ON_PAIR, "", "largest response with these springs and this oil"),
    entry(f"{ROOT}/pair/penalty", _ON_PAIR, "", "that peak over the one of the tuning, less 1"),
    entry(f"{ROOT}/pair/travel", _ON_PAIR, "", "largest relative motion of the absorber"),
    entry(f"{ROOT}/pair/allowed", _ON_PAIR, "", "1: it keeps the bounds of the case"),
    entry(f"{ROOT}/damper/damping", "stock_damper", "N*s/m", "of all such dampers together"),
    entry(f"{ROOT}/damper/secondary_damping", "stock_damper", "", "the same, c2 / (2 sqrt(K1 M1))"),
    *(
        entry(f"{ROOT}/damper_pair/{name}", _WITH_DAMPER, "", words)
        for name, words in (
            ("peak", "largest response with these springs and this damper"),
            ("penalty", "that peak over the one of the tuning, less 1"),
            ("travel", "largest relative motion of the absorber"),
            ("allowed", "1: it keeps the bounds of the case"),
        )
    ),
    entry(f"{ROOT}/buy/peak", "", "", "largest response with the best pair of stock parts"),
    entry(f"{ROOT}/buy/penalty", "", "", "that peak over the one of the tuning, less 1"),
    entry(f"{ROOT}/warming/damping", "temperature", "N*m*s/rad", "of the best oil as it warms"),
    entry(f"{ROOT}/warming/secondary_damping", "temperature", "", "c2 / (2 sqrt(K1 J1))"),
    entry(f"{ROOT}/warming/peak", "temperature", "", "largest response with springs and oil kept"),
    entry(f"{ROOT}/warming/best_stiffness_ratio", "temperature", "",
          "stiffness that would be best for this damping"),
    entry(f"{ROOT}/warming/best_peak", "temperature", "", "peak with such springs"),
    entry(f"{ROOT}/bending/frequency", "mode", "rad/s", "bending of the rod with its flywheel"),
    entry(f"{ROOT}/bending/forward", "mode", "rad/s", "whirl with the spin"),
    entry(f"{ROOT}/bending/backward", "mode", "rad/s", "whirl against the spin"),
    entry(f"{ROOT}/bending/rayleigh", "", "rad/s", "Rayleigh's quotient for half a sine"),
)  # fmt: skip
