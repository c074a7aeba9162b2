"""The ROS side: the estimator node, and the parts that both nodes share."""
