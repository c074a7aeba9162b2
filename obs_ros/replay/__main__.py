"""What `python -m obs_ros.replay` runs."""

import sys

from obs_ros.replay.command import main

if __name__ == '__main__':
    sys.exit(main())
