"""A share of a study's runs in this process, without any of what makes it a study of many."""

import argparse
import json
import sys
from pathlib import Path

from obs_ros.replay.parameter_file import read_parameters
from obs_ros.replay.recording import Source
from obs_ros.studies.keys import content
from obs_ros.studies.run import replayed
from obs_ros.studies.variants import variants


def main() -> None:
    """Do every n-th run, from the k-th one on, and write each result to a file."""
    parser = argparse.ArgumentParser()
    parser.add_argument('share', type=json.loads)
    parser.add_argument('recordings', nargs='+', type=Path)
    for option in ('--params', '--output'):
        parser.add_argument(option, type=Path)
    parser.add_argument('--vary', action='append')
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True)
    own, shares = chosen.share
    every = variants(read_parameters(chosen.params), chosen.vary)
    runs = [(path, variant) for path in chosen.recordings for variant in every]
    for index, (path, variant) in list(enumerate(runs))[own::shares]:
        result = replayed(Source(path), content(path), variant.given, False)
        (chosen.output / str(index)).write_bytes(result)


if __name__ == '__main__':
    sys.exit(main())
