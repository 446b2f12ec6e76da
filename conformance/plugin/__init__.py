"""What is pytest's: options, cases as items, a run, what comes of it, and its worker processes."""
