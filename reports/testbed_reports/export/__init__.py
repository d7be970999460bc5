"""Surfaces as files for other programs: triangles for viewers, Bézier cells for ParaView, control nets as arrays."""
