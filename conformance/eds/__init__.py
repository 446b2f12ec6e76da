"""Descriptions of devices: EDS and DCF (CiA 306-1), XDD and XDC (CiA 311), read and checked."""
