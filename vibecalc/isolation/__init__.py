"""The rigid machine on its mounts: response, transmitted forces, run-up."""
