"""The benchmark as a command."""

from benchmarks.observer_costs.run import main

if __name__ == '__main__':
    main()
