"""What is analysed: a Model, made by a Builder."""
