"""The frame: it knows no machine and no subject."""
