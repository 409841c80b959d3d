"""Designs: sensitivities, sweeps and tuning of named dimensions."""
