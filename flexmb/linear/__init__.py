"""Questions asked of the mechanism linearised about a state: frequencies, buckling, compliance, stress."""
