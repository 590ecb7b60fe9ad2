"""From a case with mounts to the kernels, and from their answers to results."""
