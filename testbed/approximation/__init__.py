"""Adaptive approximation of known surfaces: fit, measure, split where a bound is exceeded, sample, fit again."""
