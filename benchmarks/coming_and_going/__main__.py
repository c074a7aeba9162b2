"""The benchmark as a command."""

from benchmarks.coming_and_going.run import main

if __name__ == '__main__':
    main()
