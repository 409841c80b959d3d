"""What the command line and files hold: answers by mode, tables, saved motions."""
