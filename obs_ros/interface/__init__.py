"""The part that node and replay share: bindings, readers, parameters, health. Knows no ROS."""
