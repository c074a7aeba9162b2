"""The command `python -m obs_ros.replay`."""

import sys

from obs_ros.cli.replay import main

if __name__ == '__main__':
    sys.exit(main())
