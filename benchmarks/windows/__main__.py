"""The benchmark as a command."""

from benchmarks.windows.run import main

if __name__ == '__main__':
    main()
