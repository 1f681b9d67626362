"""What each part of a scene costs, and how cost grows: the pieces of `examples/scene_cost.py`."""
