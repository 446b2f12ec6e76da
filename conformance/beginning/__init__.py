"""Before the first case: does the device answer, what is it, what would hide all else?"""
