"""Many runs at a glance: which device was tested when, and how it ended."""
