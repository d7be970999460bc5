"""The geometry kernel: patches in batches, exact derivatives, and the complex that joins patches to a surface."""
