"""Sections of the report about shaft lines."""
