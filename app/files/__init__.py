"""What Flexura reads and writes."""
