"""The benchmark as a command."""

from benchmarks.search.run import main

if __name__ == '__main__':
    main()
