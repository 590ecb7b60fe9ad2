"""The worst points that the search has found, with what they gave; `CORRECTED` were above 1."""

from stability.search import Find

#: the worse of seeds 8 and 9, 21 November 2026; machines are those of that seed
FINDS: tuple[Find, ...] = (
    Find("peak over a cycle", 0.459, (0.609886, 0.891951, 0.353395, 0.619333, 0.934244), 1938, 0),
    Find("line modes", 0.928, (0.067704, 0.964279, 0.077493, 0.618341, 0.025858), 5050, 0),
    Find(
        "line forced",
        0.0275,
        (0.813738, 0.449486, 0.318519, 0.67651, 0.593445, 0.709753, 0.354725),
        800,
        0,
    ),
    Find("periodic", 0.67, (0.814998, 0.548809, 0.050373), 600, 0),
    Find("periodic march", 0.548, (0.227302, 0.109815), 275, 0),
    Find("multipliers", 0.587, (0.555821, 0.023611, 0.541318, 0.634656), 1483, 0),
    Find(
        "absorber peaks",
        0.269,
        (0.387683, 0.527912, 0.291475, 0.735819, 0.712683, 0.936386),
        1928,
        0,
    ),
    Find("absorber grid", 0.295, (1.0, 0.531316, 0.882164, 0.549201, 0.118743, 0.55762), 3227, 0),
    Find("tuning", 0, (0.996128, 0.575155, 0.432804, 0.391284), 314, 0),
    Find("mean square", 0.121, (0.067789, 0.892269, 0.176012, 0.228527, 0.352132), 20000, 0),
)
#: points that broke a promise, with what they gave before the mend: roundings of a - b k in a light
#: and tuned absorber, panels far from normal, a narrow resonance that several absorbers missed, a
#: Newton step of the march that was small by accident (twice)
CORRECTED: tuple[Find, ...] = (
    Find("mean square", 2.22, (0.607919, 0.295875, 0.534358, 0.416063, 0.584766), 40, 0),
    Find("multipliers", 171.0, (0.989828, 0.432889, 0.664595, 0.577258), 1208, 0),
    Find(
        "absorber peaks",
        3.51e13,
        (0.221679, 0.187071, 0.317145, 0.602857, 0.154577, 0.981254),
        673,
        0,
    ),
    Find("periodic march", 11.7, (0.695603, 0.972484), 58, 0),
    Find("periodic march", 46.2, (0.56151, 0.944074), 25, 0),
)
