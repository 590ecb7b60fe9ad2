"""A case at many points: grid or sample, computed, kept and put together."""
