"""The plugin kinds: what a scheme, a boundary curve, a dataset, a measure and a report are, and their text form."""
