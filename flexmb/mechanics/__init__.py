"""The static equations, each once. Element functions are vmapped per block and scattered; no loop over elements."""
