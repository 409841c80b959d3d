"""Motion: its equations, in several forms, drives and controllers, solvers, and the simulation that joins them."""
