"""Compilation of the kernels and their cache on disk."""
