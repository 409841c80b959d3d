"""Copies."""

OPERATIONS = {}
