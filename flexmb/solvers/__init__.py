"""Solvers of motion that diffrax runs."""
