"""Tuning of absorbers: smallest largest response, its certificate, and closed forms."""
