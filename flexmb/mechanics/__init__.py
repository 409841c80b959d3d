"""The equations, each once. Element functions are vmapped per block and scattered; nothing loops over elements."""
