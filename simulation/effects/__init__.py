"""What real plates and rigs do that a plain twin does not, one effect in a file."""
