"""National Instruments modules."""
