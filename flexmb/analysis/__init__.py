"""One public question each: mobility, equilibrium, linearisation, modes, buckling, compliance."""
