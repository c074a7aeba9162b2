"""The benchmark as a command."""

from benchmarks.peers.run import main

if __name__ == '__main__':
    main()
