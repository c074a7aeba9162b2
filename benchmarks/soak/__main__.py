"""The benchmark as a command."""

from benchmarks.soak.run import main

if __name__ == '__main__':
    main()
