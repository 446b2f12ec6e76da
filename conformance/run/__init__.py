"""Cases at run time: what they may say to a device, what they find, and what is left behind."""
