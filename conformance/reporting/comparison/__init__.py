"""Two runs side by side: what a change of the device has fixed, and what it has broken."""
