"""The sections of the text report, one file each."""
