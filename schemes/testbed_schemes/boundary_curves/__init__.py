"""Boundary curve constructions: one module each."""
