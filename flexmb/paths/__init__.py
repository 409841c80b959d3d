"""Equilibrium paths under growing loads, their critical points and limit loads."""
