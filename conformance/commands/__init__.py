"""The commands beside pytest: each module has one, with its options."""
