"""The interactive part of the page: surfaces sampled, packed, and shown side by side in a browser."""
