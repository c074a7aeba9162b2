"""The benchmark as a command."""

from benchmarks.h_infinity.report import main

if __name__ == '__main__':
    main()
