"""What can be asked of a mechanism in a state: a file a question, found by looking into this folder."""
