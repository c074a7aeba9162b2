"""The benchmark as a command."""

from benchmarks.scaling.run import main

if __name__ == '__main__':
    main()
