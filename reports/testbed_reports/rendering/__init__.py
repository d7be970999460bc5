"""Pictures of surfaces: a z-buffer finds which patch shows in each pixel, and that patch is evaluated there."""
