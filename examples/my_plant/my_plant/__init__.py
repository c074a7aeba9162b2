"""A plant of your own, for obs_ros."""
