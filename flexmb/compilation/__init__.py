"""What JAX's compiler and caches need: nowhere else are programs and traces looked into."""
