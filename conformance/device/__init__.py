"""What is known of the device under test, and what may be done to it."""
