"""The same case at many points: a grid over some of its keys, or samples of them."""
