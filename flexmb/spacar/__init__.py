"""SPACAR's input files read and written, and the interface of SPACAR Light."""
