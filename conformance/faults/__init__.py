"""Faulty and unusual reference servers: what proves that the cases can fail, and when not to."""
