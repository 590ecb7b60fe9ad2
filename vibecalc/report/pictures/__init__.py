"""The pictures of a result, one file each."""
