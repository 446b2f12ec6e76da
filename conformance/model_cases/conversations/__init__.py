"""Random conversations with a device: whole transfers, disturbed or not, judged by the oracle."""
