"""The benchmark as a command."""

from benchmarks.interconnected.report import main

if __name__ == '__main__':
    main()
