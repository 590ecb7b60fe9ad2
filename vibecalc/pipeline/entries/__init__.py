"""Result paths, one file for each stage or group of stages."""
