"""Minimise over a box. Nothing here knows plants or ROS."""
