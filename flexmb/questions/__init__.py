"""Questions of a mechanism in a state: one file a question, found by looking into this folder."""
