"""The benchmark as a command."""

from benchmarks.start_up.run import main

if __name__ == '__main__':
    main()
