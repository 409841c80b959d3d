"""Equilibrium under loads, and where coordinates lie at given degrees of freedom."""
