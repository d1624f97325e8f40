//! The shared library on the desktop, through `ctypes` of Python.
