"""Every state that a server can be led into, and every frame that it may get there."""
