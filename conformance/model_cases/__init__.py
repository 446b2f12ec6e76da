"""Cases that a machine makes: states of a server, what is sent there, random conversations."""
