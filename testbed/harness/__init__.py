"""The harness: plan the grid, compute its cells in worker processes, keep every result."""
