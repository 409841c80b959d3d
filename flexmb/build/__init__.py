"""Named nodes and elements in, a checked Model out. Checking is an analysis, so this room stands above that one."""
