"""The benchmark as a command."""

from benchmarks.three_tank_tables.run import main

if __name__ == '__main__':
    main()
