"""Named nodes and elements in, a checked Model out."""
