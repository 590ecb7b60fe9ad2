"""Claim: frequencies and shapes of the published engine, with and without damper, as printed."""

import numpy as np
import pytest
from torsion_lines import engine

from vibecalc.torsion.modes import natural_modes

SEVEN = [0.0, 264.15, 767.52, 1235.91, 1639.16, 1949.90, 2145.93]
SEVEN_SHAPES = [
    [1.0] * 7,
    [1.00000, 0.94301, 0.83227, 0.67409, 0.47750, 0.25369, -0.02935],
    [1.00000, 0.51882, -0.21201, -0.84082, -1.06505, -0.77679, 0.00966],
    [1.00000, -0.24768, -1.18634, -0.64482, 0.70123, 1.17236, -0.00558],
    [1.00000, -1.19468, -0.76742, 1.34408, 0.50576, -1.44254, 0.00389],
    [1.00000, -2.10567, 1.32819, 0.63713, -2.03265, 1.61032, -0.00307],
    [1.00000, -2.76150, 3.86439, -4.04564, 3.26202, -1.70041, 0.00268],
]
EIGHT = [0.0, 135.05, 286.43, 773.29, 1238.70, 1640.55, 1950.49, 2146.07]
EIGHT_SHAPES = [
    [1.0] * 8,
    [1.0, 0.1597, 0.1353, 0.1089, 0.0809, 0.0516, 0.0217, -0.0142],
    [1.0, -2.7801, -2.6926, -2.4248, -1.9945, -1.4305, -0.7706, 0.0745],
    [1.0, -26.5517, -14.3038, 4.9307, 21.7568, 27.9561, 20.5005, -0.2511],
    [1.0, -69.6973, 15.8060, 81.4993, 45.0475, -47.8633, -80.7860, 0.3827],
    [1.0, -123.0073, 144.1677, 94.4038, -162.8978, -62.0841, 175.2156, -0.4723],
    [1.0, -174.2892, 362.7336, -227.4499, -110.8254, 350.1927, -277.0242, 0.5278],
    [1.0, -211.2064, 577.7996, -806.8768, 843.9178, -680.1068, 354.4308, -0.5576],
]


@pytest.mark.parametrize(
    ("damper", "frequencies", "shapes", "digit"),
    [(False, SEVEN, SEVEN_SHAPES, 1e-5), (True, EIGHT, EIGHT_SHAPES, 1e-4)],
    ids=["seven inertias", "eight with the damper"],
)
def test_section_4_4_frequencies_and_shapes(
    damper: bool, frequencies: list[float], shapes: list[list[float]], digit: float
) -> None:
    found = natural_modes(engine(damper))
    assert np.abs(found.frequency - frequencies).max() < 0.005
    # printed with the first angle 1, here the largest one is
    scaled = found.shape / found.shape[:, :1]
    # some last digits are cut off instead of rounded: one whole unit of the last digit
    assert np.abs(scaled - shapes).max() < digit
