"""Mobility: which constraints are too many or too few, and what moves; asked by the builder and by users."""
