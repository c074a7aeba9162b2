"""The command `python -m obs_ros.replay`."""

import sys

from obs_ros.cli.start import replay

if __name__ == '__main__':
    sys.exit(replay())
