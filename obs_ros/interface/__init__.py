"""What the node and the replay share: bindings, readers, settings, health. Knows no ROS."""
