"""The benchmark as a command."""

from benchmarks.node_throughput.run import main

if __name__ == '__main__':
    main()
