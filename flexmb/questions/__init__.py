"""Questions about a mechanism in a state. Each file of this folder defines questions; flexmb finds the files."""
