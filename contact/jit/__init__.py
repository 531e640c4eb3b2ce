"""Compilation of the kernels and their cache on disk."""

from contact.jit import kernels

__all__ = ["kernels"]
