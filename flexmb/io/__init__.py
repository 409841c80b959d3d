"""Files: SPACAR input files read and written, answers of the analyses saved."""
