"""The benchmark as a command."""

from benchmarks.fuzz.run import main

if __name__ == '__main__':
    main()
