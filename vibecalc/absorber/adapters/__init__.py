"""From a case with an absorber to the kernels, and from their answers to results."""
