"""How a linear machine answers: modes, direct solutions, resonances and singular points."""
