"""How long tests wait for what must come: time never decides one that is right."""

import os


def patience(seconds: float) -> float:
    """Return how long to wait (s) for what takes less than `seconds` on an idle machine.

    The factor is $OBS_ROS_TEST_PATIENCE: 6, unless told otherwise. Only failing takes so long.
    """
    return seconds * float(os.environ.get('OBS_ROS_TEST_PATIENCE', '6'))
