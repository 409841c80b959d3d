"""The mechanism as a plant: linear state space and nonlinear system, with named inputs and outputs."""
