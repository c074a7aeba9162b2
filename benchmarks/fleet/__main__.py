"""A hundred plants in two processes: memory, messages lost, windows skipped, and latencies.

Three-tank plants send outputs and inputs in wall time, from one further process; a window of 300
samples closes every 50. Each fleet has its part of the plants, and as many workers as cores.
"""

from benchmarks.fleet.report import report
from benchmarks.fleet.run import Load, Measured, measured
from benchmarks.report import publish
from benchmarks.runner import options


def main(arguments: list[str] | None = None) -> Measured:
    """Measure, print, and write the report."""
    usual = Load()
    parser = options(__doc__)
    parser.add_argument('--plants', type=int, default=usual.plants)
    parser.add_argument('--processes', type=int, default=usual.processes)
    parser.add_argument('--rate', type=float, default=usual.rate, help='Hz of wall time')
    parser.add_argument('--window', type=int, default=usual.window, help='samples')
    parser.add_argument('--every', type=int, default=usual.every, help='samples between windows')
    parser.add_argument('--seconds', type=float, default=usual.seconds, help='of wall time')
    parser.add_argument('--at-once', action='store_true', help='all windows close together')
    parser.add_argument('--domain', type=int, default=86, help='ROS domain id')
    chosen = vars(parser.parse_args(arguments))
    results, domain = chosen.pop('results'), chosen.pop('domain')
    found = measured(Load(**chosen), domain)
    load = found.load
    title = f'{load.plants} plants in {load.processes} processes'
    name = 'fleet_jumping' if load.jumping else 'fleet'
    publish(results, f'{name}_at_once' if load.at_once else name, title, report(found))
    return found


if __name__ == '__main__':
    main()
