"""The benchmark as a command."""

from benchmarks.selects.run import main

if __name__ == '__main__':
    main()
