"""The ROS side: the estimator node, and what both nodes share."""
