"""The benchmark as a command."""

from benchmarks.kernel.run import main

if __name__ == '__main__':
    main()
