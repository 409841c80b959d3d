"""Arrays only: rotations and the linear algebra that structural mechanics needs."""
