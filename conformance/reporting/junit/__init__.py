"""JUnit files in the strict form that Jenkins reads: of all cases, and of the rules alone."""
