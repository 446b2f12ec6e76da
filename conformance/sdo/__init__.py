"""The SDO protocol without I/O: values in, values out. Imports nothing but the standard library."""
